RUNS = batch_paths(f"{RESULTS}/runs/block-{{block}}-batch-{{batch}}.parquet")
# The joins list their inputs as paths, not as `rules.<name>.output`: Snakemake would hash a named
# list once for each of its files, which takes minutes for thousands of batches.
FAILURES = f"{RESULTS}/failures.parquet"


# A separate rule, so that the failures are written even if the data set is refused.
rule failures:
    """The cases that are not in the data set, with the reasons."""
    input:
        cases=CASES,
        rates=WEAR_RATES,
        runs=RUNS,
    output:
        FAILURES,
    log:
        f"{LOGS}/failures.log",
    conda:
        "../envs/abradem.yaml"
    params:
        code=code_of("dataset/failures"),
    script:
        "../scripts/dataset/failures.py"


rule dataset:
    """Target: the data set, one row for each successful case."""
    input:
        cases=CASES,
        rates=WEAR_RATES,
        runs=RUNS,
        # Not read; ensures that the reasons are written before the data set.
        failures=FAILURES,
    output:
        report(
            f"{RESULTS}/dataset.parquet",
            caption="../report/dataset.rst",
            category="Data",
            labels={"file": "dataset.parquet"},
        ),
    log:
        f"{LOGS}/dataset.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options=CONFIG.features.model_dump(),
        max_failed_share=CONFIG.simulation.max_failed_share,
        code=code_of("dataset/dataset"),
    script:
        "../scripts/dataset/dataset.py"
