# Joint results of all models. Each model can be rerun separately; these rules then follow.
SCORED = [*BASELINES, "physical", "surrogate"]
# Rules that need a quantity that varies.
LEARNERS = {
    "linear",
    "penalised",
    "pca",
    "selection",
    "trees",
    "ga_ann",
    "fit_physical",
    "intervals",
    "surrogate",
    "sensitivity",
    "reach",
    "wear_maps",
}


localrules:
    learning,


rule learning:
    """Target: all models, their scores and their analysis."""
    input:
        rules.baselines.input,
        rules.physical.input,
        f"{RESULTS}/learning/scores.parquet",
        [] if WEARS_SURFACE else f"{RESULTS}/learning/exponents.parquet",


rule scores:
    """The scores and predictions of all models, and their comparison."""
    input:
        dataset=ROWS,
        scores=expand(f"{RESULTS}/learning/{{stage}}_scores.parquet", stage=SCORED),
        predictions=expand(
            f"{RESULTS}/learning/{{stage}}_predictions.parquet", stage=SCORED
        ),
    output:
        scores=f"{RESULTS}/learning/scores.parquet",
        predictions=f"{RESULTS}/learning/predictions.parquet",
        comparison=f"{RESULTS}/learning/comparison.parquet",
        beside_paper=f"{RESULTS}/learning/beside_paper.parquet",
        by_region=f"{RESULTS}/learning/error_by_region.parquet",
    log:
        f"{LOGS}/scores.log",
    benchmark:
        f"{RESULTS}/benchmarks/scores.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        setup=JET,
        table=CONFIG.study,
        options={
            "draws": LEARNING.bootstrap,
            "confidence": LEARNING.confidence,
            "seed": CONFIG.seed,
        },
        code=code_of("learning/scores"),
    script:
        "../scripts/learning/scores.py"


rule exponents:
    """Exponents of the wear rate beside those of the published data."""
    input:
        ROWS,
    output:
        f"{RESULTS}/learning/exponents.parquet",
    log:
        f"{LOGS}/exponents.log",
    conda:
        "../envs/abradem.yaml"
    params:
        target=LEARNING.target,
        setup=JET,
        code=code_of("learning/exponents"),
    script:
        "../scripts/learning/exponents.py"
