# The joins of all models. Each stage reruns alone, and these follow.
SCORED = [*BASELINES, "physical", "surrogate"]


localrules:
    learning,


rule learning:
    """Target: all models, their scores and what they say."""
    input:
        rules.baselines.input,
        rules.physical.input,
        f"{RESULTS}/learning/scores.parquet",


rule scores:
    """The scores of all models in one table, and side by side."""
    input:
        scores=expand(f"{RESULTS}/learning/{{stage}}_scores.parquet", stage=SCORED),
        predictions=expand(
            f"{RESULTS}/learning/{{stage}}_predictions.parquet", stage=SCORED
        ),
    output:
        scores=f"{RESULTS}/learning/scores.parquet",
        predictions=f"{RESULTS}/learning/predictions.parquet",
        comparison=f"{RESULTS}/learning/comparison.parquet",
        beside_paper=f"{RESULTS}/learning/beside_paper.parquet",
    log:
        f"{LOGS}/scores.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "draws": LEARNING.bootstrap,
            "confidence": LEARNING.confidence,
            "seed": CONFIG.seed,
        },
        code=code_of("learning/scores"),
    script:
        "../scripts/learning/scores.py"
