RUNS = batch_paths(f"{RESULTS}/runs/block-{{block}}-batch-{{batch}}.parquet")
# The joins name their inputs by path, not as `rules.<name>.output`: for each file of a named
# list Snakemake would then hash the whole list, minutes for thousands of batches.
FAILURES = f"{RESULTS}/failures.parquet"


# A rule of its own, so that they are written whatever is wrong with the data set.
rule failures:
    """The cases that are no row of the data set, and why."""
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
    """Target: the data set, one row for each case that ended well."""
    input:
        cases=CASES,
        rates=WEAR_RATES,
        runs=RUNS,
        # Not read: the reasons are to be there when the data set is.
        failures=FAILURES,
    output:
        report(
            f"{RESULTS}/dataset.parquet",
            caption="../report/dataset.rst",
            category="Data",
            labels={"table": "data set"},
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
