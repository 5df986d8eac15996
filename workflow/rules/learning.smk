rule learning:
    input:
        f"{RESULTS}/learning/linear.json",


rule linear:
    input:
        rules.dataset.output,
    output:
        summary=report(
            f"{RESULTS}/learning/linear.json",
            caption="../report/linear.rst",
            category="Models",
            labels={"model": "linear regression", "content": "equation"},
        ),
        coefficients=f"{RESULTS}/learning/linear_coefficients.parquet",
        scores=f"{RESULTS}/learning/scores.parquet",
        predictions=f"{RESULTS}/learning/predictions.parquet",
    log:
        f"{LOGS}/linear.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options=CONFIG.learning.linear.model_dump(),
        seed=CONFIG.seed,
        code=CODE["linear"],
    script:
        "../scripts/linear.py"
