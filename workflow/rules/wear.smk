WEAR_RATES = batch_paths(
    f"{RESULTS}/wear_rates/block-{{block}}-batch-{{batch}}.parquet"
)
# A fixed number of parts, so that the results do not depend on the number of cores.
REPLICATE_PARTS = range(4)


localrules:
    wear,


rule wear:
    """Target: the wear rates of all cases."""
    input:
        WEAR_RATES,


rule wear_rates:
    """The wear rates of one batch."""
    input:
        cases=f"{RESULTS}/cases/block-{{block}}.parquet",
        series=rules.simulate.output.series,
        maps=rules.simulate.output.maps,
        parts=rules.simulate.output.parts,
        runs=rules.simulate.output.runs,
    output:
        f"{RESULTS}/wear_rates/block-{{block}}-batch-{{batch}}.parquet",
    log:
        f"{LOGS}/wear_rates/block-{{block}}-batch-{{batch}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        setup=SETUP,
        options=rate_options(CONFIG),
        code=code_of("wear/wear_rates"),
    script:
        "../scripts/wear/wear_rates.py"


rule angles:
    """Wear depth against time for several plate angles and factory angles."""
    output:
        curves=f"{RESULTS}/angles_curves.parquet",
        rates=f"{RESULTS}/angles_rates.parquet",
    log:
        f"{LOGS}/angles.log",
    benchmark:
        f"{RESULTS}/benchmarks/angles.tsv"
    conda:
        "../envs/abradem.yaml"
    params:
        case=TYPICAL,
        setup=SETUP,
        options={
            "angles": {
                "plate_angle": CONFIG.figures.angles.plate,
                "factory_angle": CONFIG.figures.angles.factory,
            },
            "duration": CONFIG.figures.angles.duration_s,
            "measure": MEASURE,
            "min_batches": CONFIG.wear_rate.min_batches,
        },
        code=code_of("wear/angles"),
    script:
        "../scripts/wear/angles.py"


rule replicates:
    """Some cases simulated again with other seeds."""

    # From the first block only, so that they do not change with the number of blocks.
    input:
        expand(rules.sample.output, block=f"{BLOCKS[0]:03d}"),
    output:
        f"{RESULTS}/replicates/part-{{part}}.parquet",
    log:
        f"{LOGS}/replicates/part-{{part}}.log",
    wildcard_constraints:
        part=r"\d+",
    conda:
        "../envs/abradem.yaml"
    params:
        setup=SETUP,
        cases=CONFIG.learning.noise.cases,
        replicates=CONFIG.learning.noise.replicates,
        part=lambda wildcards: [int(wildcards.part), len(REPLICATE_PARTS)],
        options=rate_options(CONFIG),
        code=code_of("wear/replicates"),
    script:
        "../scripts/wear/replicates.py"
