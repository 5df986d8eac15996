CASES = f"{RESULTS}/cases.parquet"


localrules:
    sampling,


rule sampling:
    """Target: the parameter sets of all cases."""
    input:
        CASES,


rule sample:
    """One block of cases."""
    output:
        f"{RESULTS}/cases/block-{{block}}.parquet",
    log:
        f"{LOGS}/sample/block-{{block}}.log",
    # Before any simulation, as the longest one may be in the last block.
    priority: 10**9
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "seed": CONFIG.seed,
            "cases_per_block": CONFIG.sampling.cases_per_block,
            "method": CONFIG.sampling.method,
            "ranges": sampled_ranges(CONFIG),
            "geometry": geometry_ranges(CONFIG),
        },
        setup=SETUP,
        code=code_of("sampling/sample"),
    script:
        "../scripts/sampling/sample.py"


# Made from the blocks, not the other way round, so that new blocks do not change existing ones.
rule join_cases:
    """The cases of all blocks in one table."""
    input:
        expand(f"{RESULTS}/cases/block-{{block:03d}}.parquet", block=BLOCKS),
    output:
        report(
            CASES,
            caption="../report/cases.rst",
            category="Data",
            labels={"file": "cases.parquet"},
        ),
    log:
        f"{LOGS}/join_cases.log",
    conda:
        "../envs/abradem.yaml"
    params:
        code=code_of("sampling/join_cases"),
    script:
        "../scripts/sampling/join_cases.py"
