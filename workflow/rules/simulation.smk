# Short simulations of the typical case for pictures.
TYPICAL = typical_case(CONFIG)
PICTURED = CONFIG.figures.typical
FILM = CONFIG.figures.movie

# A geometry may be a file of the user.
MESH = (
    [CONFIG.simulation.geometry.mesh.file]
    if CONFIG.simulation.geometry.kind == "mesh"
    else []
)

# A film has plates at several angles, or a geometry.
FILMED = (
    {"film": {}}
    if WEARS_SURFACE
    else {f"plate_{angle:g}": {"plate_angle": angle} for angle in FILM.plate_angles}
)

# For each scene: differences from the typical case, duration (s), time between snapshots (s).
SCENES = {
    "typical": ({}, PICTURED.duration_s, PICTURED.interval_s),
    **{
        name: (
            difference,
            FILM.duration_s,
            1.0 / (FILM.frames_per_second * FILM.slow_motion),
        )
        for name, difference in FILMED.items()
    },
}


localrules:
    simulation,
    snapshots,


rule simulation:
    """Target: the simulations of all cases."""
    input:
        batch_paths(f"{RESULTS}/runs/block-{{block}}-batch-{{batch}}.parquet"),
        # Needed by `abradem simulate` to repeat a case.
        f"{RESULTS}/config.yaml",


# A batch depends only on the cases of its block, so that a larger study adds only new blocks.
rule simulate:
    """The simulations of one batch."""
    input:
        cases=f"{RESULTS}/cases/block-{{block}}.parquet",
        mesh=MESH,
    output:
        series=f"{RESULTS}/series/block-{{block}}-batch-{{batch}}.parquet",
        maps=f"{RESULTS}/maps/block-{{block}}-batch-{{batch}}.parquet",
        parts=f"{RESULTS}/parts/block-{{block}}-batch-{{batch}}.parquet",
        times=f"{RESULTS}/benchmarks/cases/block-{{block}}-batch-{{batch}}.parquet",
        runs=f"{RESULTS}/runs/block-{{block}}-batch-{{batch}}.parquet",
    log:
        f"{LOGS}/simulate/block-{{block}}-batch-{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/simulate/block-{{block}}-batch-{{batch}}.tsv"
    # Longest batches first, so that all cores finish at about the same time.
    priority: seconds_of_batch
    conda:
        "../envs/abradem.yaml"
    # Results do not depend on it, so it is no parameter.
    threads: CONFIG.threads
    resources:
        mem_mb=growing(BATCH_MB),
        runtime=growing(BATCH_MINUTES),
    params:
        setup=SETUP,
        rows=lambda wildcards: BATCHES[int(wildcards.batch)],
        # In the folder of the outputs, also if an importing workflow moves them.
        finished=lambda wildcards, output: beside(
            output.runs, f".finished/{Path(output.runs).stem}"
        ),
        code=code_of("simulation/simulate"),
    script:
        "../scripts/simulation/simulate.py"


rule snapshots:
    """Target: snapshots of the cases of simulation.export."""
    input:
        expand(
            f"{RESULTS}/export/case-{{case}}/{{table}}.parquet",
            case=CONFIG.simulation.export.cases,
            table=["particles", "contacts", "wear"],
        ),


rule snapshots_of_case:
    """Snapshots of one case at regular intervals."""
    input:
        cases=lambda wildcards: batches_with(
            [int(wildcards.case)], f"{RESULTS}/cases/block-{{block}}.parquet"
        ),
        mesh=MESH,
    output:
        particles=f"{RESULTS}/export/case-{{case}}/particles.parquet",
        contacts=f"{RESULTS}/export/case-{{case}}/contacts.parquet",
        wear=f"{RESULTS}/export/case-{{case}}/wear.parquet",
    log:
        f"{LOGS}/export/case-{{case}}.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(BATCH_MB),
        runtime=growing(BATCH_MINUTES),
    params:
        setup=SETUP,
        interval=CONFIG.simulation.export.interval_s,
        code=code_of("simulation/snapshots"),
    script:
        "../scripts/simulation/snapshots.py"


rule scene:
    """Snapshots of a short simulation for pictures."""
    input:
        MESH,
    output:
        particles=f"{RESULTS}/scenes/{{scene}}/particles.parquet",
        contacts=f"{RESULTS}/scenes/{{scene}}/contacts.parquet",
        wear=f"{RESULTS}/scenes/{{scene}}/wear.parquet",
    log:
        f"{LOGS}/scene/{{scene}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/scene/{{scene}}.tsv"
    wildcard_constraints:
        scene="|".join(map(re.escape, SCENES)),
    conda:
        "../envs/abradem.yaml"
    params:
        case=lambda wildcards: {**TYPICAL, **SCENES[wildcards.scene][0]},
        setup=SETUP,
        options=lambda wildcards: dict(
            zip(("duration", "interval"), SCENES[wildcards.scene][1:])
        ),
        code=code_of("simulation/scene"),
    script:
        "../scripts/simulation/scene.py"
