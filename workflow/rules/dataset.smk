WEAR_RATES = shard_paths(
    f"{RESULTS}/wear_rates/block-{{block}}-shard-{{shard}}.parquet"
)
RUNS = shard_paths(f"{RESULTS}/runs/block-{{block}}-shard-{{shard}}.parquet")
# The joins name their inputs by path, not as `rules.<name>.output`: for each file of a named
# list Snakemake would then hash the whole list, minutes for thousands of shards.
CASES = f"{RESULTS}/cases.parquet"
FAILURES = f"{RESULTS}/failures.parquet"


rule wear_rates:
    """The wear rates of one shard."""
    input:
        cases=f"{RESULTS}/cases/block-{{block}}.parquet",
        series=rules.simulate.output.series,
        maps=rules.simulate.output.maps,
        runs=rules.simulate.output.runs,
    output:
        f"{RESULTS}/wear_rates/block-{{block}}-shard-{{shard}}.parquet",
    log:
        f"{LOGS}/wear_rates/block-{{block}}-shard-{{shard}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        setup=SETUP,
        options=CONFIG.wear_rate.model_dump(include={"min_batches", "footprint_share"}),
        code=CODE["wear_rates"],
    script:
        "../scripts/wear_rates.py"


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
        code=CODE["failures"],
    script:
        "../scripts/failures.py"


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
        code=CODE["dataset"],
    script:
        "../scripts/dataset.py"
