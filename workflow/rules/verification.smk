# The verification study: make verify, or snakemake verification. rule all never asks for it, and
# nothing of it depends on the configuration.
VERIFIED = "results/verification"
VERIFICATION_LOGS = f"{VERIFIED}/logs"

# The tables of each part; every part has its checks.
PARTS = {
    "laws": ["checks", "restitution", "angles", "convergence"],
    "chung_ooi": ["checks", "tests", "measured"],
    "codes": ["checks", "impacts", "jets"],
    "time_step": ["checks", "impacts", "mean", "jets"],
    "statistics": ["checks", "replicates", "stopped", "extremes"],
    "steady_state": ["checks", "rates", "series"],
    "conveyor": ["checks", "rates"],
    "trends": ["checks", "measurements", "exponents"],
    "facets_and_bed": ["checks", "sizes", "heap"],
}

PART_INPUTS = {
    "codes": {
        "impacts": "tests/data/codes/single_impacts.csv",
        "jets": "tests/data/codes/jets.csv",
    },
}

# The tables that each figure shows, in the order in which its function takes them.
VERIFICATION_FIGURES = {
    "restitution": ["laws_restitution"],
    "slip": ["laws_angles"],
    "convergence": ["laws_convergence"],
    "codes": ["codes_impacts"],
    "time_step": ["time_step_mean", "time_step_jets"],
    "coverage": ["statistics_replicates"],
    "steady_state": ["steady_state_rates", "steady_state_series"],
    "conveyor": ["conveyor_rates"],
    "trends": ["trends_measurements", "trends_exponents"],
    "heap": ["facets_and_bed_heap"],
    **{
        f"chung_ooi_{number}": ["chung_ooi_tests", "chung_ooi_measured"]
        for number in range(1, 9)
    },
}
VERIFICATION_FORMATS = ["pdf", "png"]


rule verification:
    input:
        f"{VERIFIED}/results.md",
        expand(
            f"{VERIFIED}/figures/{{figure}}.{{format}}",
            figure=VERIFICATION_FIGURES,
            format=VERIFICATION_FORMATS,
        ),


for part, tables in PARTS.items():

    rule:
        name:
            f"verification_{part}"
        input:
            **PART_INPUTS.get(part, {}),
        output:
            [f"{VERIFIED}/tables/{part}_{table}.csv" for table in tables],
            **{table: f"{VERIFIED}/tables/{part}_{table}.parquet" for table in tables},
        log:
            f"{VERIFICATION_LOGS}/{part}.log",
        conda:
            "../envs/abradem.yaml"
        params:
            tables=tables,
            code=CODE[f"verification_{part}"],
        script:
            f"../scripts/verification_{part}.py"


rule verification_page:
    input:
        [f"{VERIFIED}/tables/{part}_checks.parquet" for part in PARTS],
    output:
        page=f"{VERIFIED}/results.md",
        checks=f"{VERIFIED}/checks.parquet",
        text=f"{VERIFIED}/checks.csv",
        summary=f"{VERIFIED}/summary.json",
    log:
        f"{VERIFICATION_LOGS}/page.log",
    conda:
        "../envs/abradem.yaml"
    params:
        code=CODE["verification_page"],
    script:
        "../scripts/verification_page.py"


rule verification_figure:
    input:
        lambda wildcards: [
            f"{VERIFIED}/tables/{table}.parquet"
            for table in VERIFICATION_FIGURES[wildcards.figure]
        ],
    output:
        [f"{VERIFIED}/figures/{{figure}}.{format}" for format in VERIFICATION_FORMATS],
    log:
        f"{VERIFICATION_LOGS}/figures/{{figure}}.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=VERIFICATION_FORMATS,
        code=CODE["verification_figure"],
    script:
        "../scripts/verification_figure.py"
