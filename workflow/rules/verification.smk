# The verification study: `make verify` or `snakemake verification`. It is not part of rule all and
# does not depend on the configuration.
VERIFIED = "results/verification"
VERIFICATION_LOGS = f"{VERIFIED}/logs"

# Shown in the report of a study if the verification study was run.
VERDICTS = Path(VERIFIED, "summary.json")
config["verification"] = read_if_sound(VERDICTS)

# The tables of each part of the study; every part has a table of checks.
PARTS = {
    "laws": ["checks", "restitution", "angles", "convergence"],
    "chung_ooi": ["checks", "tests", "measured"],
    "codes": ["checks", "impacts", "jets", "forces"],
    "time_step": ["checks", "impacts", "mean", "jets", "angles"],
    "statistics": ["checks", "replicates", "stopped", "extremes"],
    "steady_state": ["checks", "rates", "series"],
    "conveyor": ["checks", "rates"],
    "trends": ["checks", "measurements", "exponents"],
    "facets_and_bed": ["checks", "sizes", "heap"],
    "stop_rule": ["checks", "ended"],
    "surfaces": ["checks", "chutes"],
}

# The tables of each figure, in the order of the parameters of its drawing function.
VERIFICATION_FIGURES = {
    "restitution": ["laws_restitution"],
    "slip": ["laws_angles"],
    "convergence": ["laws_convergence"],
    "codes": ["codes_impacts"],
    "codes_forces": ["codes_forces"],
    "codes_jets": ["codes_jets"],
    "time_step": ["time_step_mean", "time_step_jets"],
    "coverage": ["statistics_replicates"],
    "steady_state": ["steady_state_rates", "steady_state_series"],
    "conveyor": ["conveyor_rates"],
    "trends": ["trends_measurements", "trends_exponents"],
    "heap": ["facets_and_bed_heap"],
    "chute": ["surfaces_chutes"],
    **{
        f"chung_ooi_{number}": ["chung_ooi_tests", "chung_ooi_measured"]
        for number in range(1, 9)
    },
}
VERIFICATION_FORMATS = ["pdf", "png"]


rule verification:
    """Target, on demand: the verification study of the engine."""
    input:
        f"{VERIFIED}/results.md",
        expand(
            f"{VERIFIED}/figures/{{figure}}.{{format}}",
            figure=VERIFICATION_FIGURES,
            format=VERIFICATION_FORMATS,
        ),


rule verification_laws:
    """Single impacts against closed forms, and the order of convergence."""
    output:
        **part_files("laws", "parquet"),
        text=list(part_files("laws", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/laws.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("laws"),
    script:
        "../scripts/verification/part.py"


rule verification_chung_ooi:
    """The eight particle-level tests of Chung & Ooi (2011)."""
    output:
        **part_files("chung_ooi", "parquet"),
        text=list(part_files("chung_ooi", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/chung_ooi.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("chung_ooi"),
    script:
        "../scripts/verification/part.py"


rule verification_codes:
    """Comparison with independent codes with the same options."""
    input:
        impacts=file_of_workflow("tests/data/codes/single_impacts.csv"),
        jets=file_of_workflow("tests/data/codes/jets.csv"),
        forces=file_of_workflow("tests/data/codes/forces.csv"),
    output:
        **part_files("codes", "parquet"),
        text=list(part_files("codes", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/codes.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("codes"),
    script:
        "../scripts/verification/part.py"


rule verification_time_step:
    """Effect of the time step on each wear measure."""
    output:
        **part_files("time_step", "parquet"),
        text=list(part_files("time_step", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/time_step.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("time_step"),
    script:
        "../scripts/verification/part.py"


rule verification_statistics:
    """Standard errors compared with replicates."""
    output:
        **part_files("statistics", "parquet"),
        text=list(part_files("statistics", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/statistics.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("statistics"),
    script:
        "../scripts/verification/part.py"


rule verification_steady_state:
    """The paper's steady-state study."""
    output:
        **part_files("steady_state", "parquet"),
        text=list(part_files("steady_state", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/steady_state.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("steady_state", "steady_state_study"),
    script:
        "../scripts/verification/part.py"


rule verification_conveyor:
    """The paper's screw-conveyor check."""
    output:
        **part_files("conveyor", "parquet"),
        text=list(part_files("conveyor", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/conveyor.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("conveyor"),
    script:
        "../scripts/verification/part.py"


rule verification_trends:
    """Exponents of the wear in dilute jets."""
    output:
        **part_files("trends", "parquet"),
        text=list(part_files("trends", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/trends.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("trends"),
    script:
        "../scripts/verification/part.py"


rule verification_facets_and_bed:
    """Independence of the facet size, and the balances of a bed."""
    output:
        **part_files("facets_and_bed", "parquet"),
        text=list(part_files("facets_and_bed", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/facets_and_bed.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("facets_and_bed"),
    script:
        "../scripts/verification/part.py"


rule verification_stop_rule:
    """Coverage of the intervals of cases that the stop rule ended."""
    output:
        **part_files("stop_rule", "parquet"),
        text=list(part_files("stop_rule", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/stop_rule.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("stop_rule"),
    script:
        "../scripts/verification/part.py"


rule verification_surfaces:
    """Triangulated surfaces against the plate, closed forms and other codes."""
    input:
        chutes=file_of_workflow("tests/data/codes/chutes.csv"),
    output:
        **part_files("surfaces", "parquet"),
        text=list(part_files("surfaces", "csv").values()),
    log:
        f"{VERIFICATION_LOGS}/surfaces.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **part("surfaces"),
    script:
        "../scripts/verification/part.py"


rule verification_results:
    """All checks of the verification study: table, results page, and number of checks that hold."""
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
        code=code_of("verification/results"),
    script:
        "../scripts/verification/results.py"


rule verification_figure:
    """One figure of the verification study."""
    input:
        tables=lambda wildcards: [
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
        draw="verification:draw",
        options=lambda wildcards: {"figure": wildcards.figure},
        code=code_of("figures/figure", "abradem.figures.verification"),
    script:
        "../scripts/figures/figure.py"
