PROTOCOLS = ["as_published", "leakage_free"]
LEARNING = CONFIG.learning
# The splits, and so the held-out rows, are the same for all models.
SPLITS = {
    "test_share": LEARNING.test_share,
    "repeats": LEARNING.repeats,
    "seed": CONFIG.seed,
}
# A geometry is no study of the paper, whose networks are then trained on demand alone.
BASELINES = [
    "linear",
    "penalised",
    "pca",
    "trees",
    *([] if WEARS_SURFACE else [f"ga_ann_{protocol}" for protocol in PROTOCOLS]),
]
# The rows that models learn from.
ROWS = rules.dataset.output[0] if LEARNING.part is None else rules.part_rows.output[0]
LEARNED_FROM = {"target": LEARNING.target, "name": CONFIG.study}


localrules:
    baselines,


rule baselines:
    """Target: the paper's models under both protocols."""
    input:
        f"{RESULTS}/learning/linear.json",
        f"{RESULTS}/learning/selection.parquet",
        expand(f"{RESULTS}/learning/{{stage}}_scores.parquet", stage=BASELINES),


rule linear:
    """The linear regression of the data set."""
    input:
        ROWS,
    output:
        summary=report(
            f"{RESULTS}/learning/linear.json",
            caption="../report/linear.rst",
            category="Models",
            labels={"file": "linear.json", "content": "equation"},
        ),
        summary_arrays=f"{RESULTS}/learning/linear.safetensors",
        coefficients=f"{RESULTS}/learning/linear_coefficients.parquet",
        residuals=f"{RESULTS}/learning/linear_residuals.parquet",
        published=f"{RESULTS}/learning/linear_published.parquet",
        scores=f"{RESULTS}/learning/linear_scores.parquet",
        predictions=f"{RESULTS}/learning/linear_predictions.parquet",
    log:
        f"{LOGS}/linear.log",
    benchmark:
        f"{RESULTS}/benchmarks/linear.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        **module_of("linear"),
        table=LEARNED_FROM,
        options={
            "confidence": LEARNING.confidence,
            **SPLITS,
        },
    script:
        "../scripts/baselines/baseline.py"


rule penalised:
    """Lasso and ridge."""
    input:
        ROWS,
    output:
        weights=f"{RESULTS}/learning/penalised_weights.parquet",
        paths=f"{RESULTS}/learning/penalised_paths.parquet",
        validation=f"{RESULTS}/learning/penalised_validation.parquet",
        scores=f"{RESULTS}/learning/penalised_scores.parquet",
        predictions=f"{RESULTS}/learning/penalised_predictions.parquet",
        summary=f"{RESULTS}/learning/penalised.json",
        lasso=f"{RESULTS}/learning/lasso.json",
        lasso_arrays=f"{RESULTS}/learning/lasso.safetensors",
        ridge=f"{RESULTS}/learning/ridge.json",
        ridge_arrays=f"{RESULTS}/learning/ridge.safetensors",
    log:
        f"{LOGS}/penalised.log",
    benchmark:
        f"{RESULTS}/benchmarks/penalised.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        **module_of("penalised"),
        table=LEARNED_FROM,
        options={
            **LEARNING.penalised.model_dump(),
            "fold_count": LEARNING.folds,
            "confidence": LEARNING.confidence,
            **SPLITS,
        },
    script:
        "../scripts/baselines/baseline.py"


rule pca:
    """Principal component analysis, and regression on the components."""
    input:
        ROWS,
    output:
        loadings=f"{RESULTS}/learning/pca_loadings.parquet",
        scree=f"{RESULTS}/learning/pca_scree.parquet",
        correlations=f"{RESULTS}/learning/pca_correlations.parquet",
        curve=f"{RESULTS}/learning/pca_curve.parquet",
        scores=f"{RESULTS}/learning/pca_scores.parquet",
        predictions=f"{RESULTS}/learning/pca_predictions.parquet",
        summary=f"{RESULTS}/learning/pca.json",
        model=f"{RESULTS}/learning/pca_regression.json",
        model_arrays=f"{RESULTS}/learning/pca_regression.safetensors",
    log:
        f"{LOGS}/pca.log",
    benchmark:
        f"{RESULTS}/benchmarks/pca.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        **module_of("pca"),
        table=LEARNED_FROM,
        options={
            "fold_count": LEARNING.folds,
            "confidence": LEARNING.confidence,
            **SPLITS,
        },
    script:
        "../scripts/baselines/baseline.py"


rule selection:
    """Selection of the features of the networks."""
    input:
        ROWS,
    output:
        selection=f"{RESULTS}/learning/selection.parquet",
        summary=f"{RESULTS}/learning/selection.json",
    log:
        f"{LOGS}/selection.log",
    benchmark:
        f"{RESULTS}/benchmarks/selection.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        **module_of("selection"),
        table=LEARNED_FROM,
        options={
            "count": LEARNING.selection.features,
            "lasso_alpha": LEARNING.penalised.lasso_alpha,
            "ridge_alpha": LEARNING.penalised.ridge_alpha,
            **SPLITS,
        },
    script:
        "../scripts/baselines/baseline.py"


rule trees:
    """Decision tree and random forest."""
    input:
        ROWS,
    output:
        curve=f"{RESULTS}/learning/trees_curve.parquet",
        nodes=f"{RESULTS}/learning/trees_nodes.parquet",
        importance=f"{RESULTS}/learning/trees_importance.parquet",
        scores=f"{RESULTS}/learning/trees_scores.parquet",
        predictions=f"{RESULTS}/learning/trees_predictions.parquet",
        summary=f"{RESULTS}/learning/trees.json",
        tree=f"{RESULTS}/learning/tree.json",
        tree_arrays=f"{RESULTS}/learning/tree.safetensors",
        forest=f"{RESULTS}/learning/forest.json",
        forest_arrays=f"{RESULTS}/learning/forest.safetensors",
    log:
        f"{LOGS}/trees.log",
    benchmark:
        f"{RESULTS}/benchmarks/trees.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        **module_of("trees"),
        table=LEARNED_FROM,
        options={
            **LEARNING.trees.model_dump(),
            "fold_count": LEARNING.folds,
            "confidence": LEARNING.confidence,
            **SPLITS,
        },
    script:
        "../scripts/baselines/baseline.py"


# Networks are trained one per core, so the rule asks for as many cores as a generation has
# networks; the result does not depend on the number. An interrupted search resumes.
rule ga_ann:
    """Genetic search for the architecture of a network, under one protocol."""
    input:
        ROWS,
    output:
        history=f"{RESULTS}/learning/ga_ann_{{protocol}}_history.parquet",
        scores=f"{RESULTS}/learning/ga_ann_{{protocol}}_scores.parquet",
        predictions=f"{RESULTS}/learning/ga_ann_{{protocol}}_predictions.parquet",
        summary=report(
            f"{RESULTS}/learning/ga_ann_{{protocol}}.json",
            caption="../report/ga_ann_summary.rst",
            category="Models",
            labels={"file": "ga_ann_{protocol}.json", "content": "network found"},
        ),
        model=f"{RESULTS}/learning/ga_ann_{{protocol}}_model.json",
        model_arrays=f"{RESULTS}/learning/ga_ann_{{protocol}}_model.safetensors",
    log:
        f"{LOGS}/ga_ann_{{protocol}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/ga_ann/{{protocol}}.tsv"
    wildcard_constraints:
        protocol="|".join(PROTOCOLS),
    # After the models that are cheap to train.
    priority: -1
    conda:
        "../envs/abradem.yaml"
    threads: LEARNING.ga_ann.population
    resources:
        mem_mb=lambda wildcards, threads, attempt: (1500 + 500 * threads) * attempt,
        runtime=growing(LEARNING_MINUTES),
    params:
        table=LEARNED_FROM,
        networks=LEARNING.ga_ann.model_dump(),
        options={
            "features": LEARNING.selection.features,
            "lasso_alpha": LEARNING.penalised.lasso_alpha,
            "ridge_alpha": LEARNING.penalised.ridge_alpha,
            "confidence": LEARNING.confidence,
            **SPLITS,
        },
        folder=lambda wildcards, output: beside(
            output.summary, f".ga_ann-{wildcards.protocol}"
        ),
        code=code_of("baselines/ga_ann"),
    script:
        "../scripts/baselines/ga_ann.py"
