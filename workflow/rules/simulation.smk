localrules:
    simulation,
    exports,


rule simulation:
    """Target: the simulations of all cases."""
    input:
        shard_paths(f"{RESULTS}/runs/block-{{block}}-shard-{{shard}}.parquet"),
        # With it, `abradem simulate` repeats a case of these very simulations.
        f"{RESULTS}/config.yaml",


# A shard depends on its block's cases alone, so that a study grows by its new blocks.
rule simulate:
    """The simulations of one shard."""
    input:
        cases=f"{RESULTS}/cases/block-{{block}}.parquet",
    output:
        series=f"{RESULTS}/series/block-{{block}}-shard-{{shard}}.parquet",
        maps=f"{RESULTS}/maps/block-{{block}}-shard-{{shard}}.parquet",
        times=f"{RESULTS}/benchmarks/cases/block-{{block}}-shard-{{shard}}.parquet",
        runs=f"{RESULTS}/runs/block-{{block}}-shard-{{shard}}.parquet",
    log:
        f"{LOGS}/simulate/block-{{block}}-shard-{{shard}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/simulate/block-{{block}}-shard-{{shard}}.tsv"
    # The longest first, else the last of them keeps one core busy while the others wait.
    priority: seconds_of_shard
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(SHARD_MB),
        runtime=growing(SHARD_MINUTES),
    params:
        setup=SETUP,
        rows=lambda wildcards: SHARDS[int(wildcards.shard)],
        # Beside the outputs, wherever an importing workflow puts them.
        finished=lambda wildcards, output: beside(
            output.runs, f".finished/{Path(output.runs).stem}"
        ),
        code=CODE["simulate"],
    script:
        "../scripts/simulate.py"


rule exports:
    """Target: snapshots of the cases of simulation.export."""
    input:
        expand(
            f"{RESULTS}/export/case-{{case}}/{{table}}.parquet",
            case=CONFIG.simulation.export.cases,
            table=["particles", "contacts", "wear"],
        ),


rule export:
    """Snapshots of one case at regular intervals."""
    input:
        lambda wildcards: shards_with(
            [int(wildcards.case)], f"{RESULTS}/cases/block-{{block}}.parquet"
        ),
    output:
        particles=f"{RESULTS}/export/case-{{case}}/particles.parquet",
        contacts=f"{RESULTS}/export/case-{{case}}/contacts.parquet",
        wear=f"{RESULTS}/export/case-{{case}}/wear.parquet",
    log:
        f"{LOGS}/export/case-{{case}}.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(SHARD_MB),
        runtime=growing(SHARD_MINUTES),
    params:
        setup=SETUP,
        interval=CONFIG.simulation.export.interval_s,
        code=CODE["export"],
    script:
        "../scripts/export.py"
