# Short simulations for pictures, of the case that stands for the study.
TYPICAL = typical_case(CONFIG)
PICTURED = CONFIG.figures.typical
FILM = CONFIG.figures.movie

# Each with what differs from the typical case, its duration and the time between snapshots, s.
SCENES = {
    "typical": ({}, PICTURED.duration_s, PICTURED.interval_s),
    **{
        f"plate_{angle:g}": (
            {"plate_angle": angle},
            FILM.duration_s,
            1.0 / (FILM.frames_per_second * FILM.slow_motion),
        )
        for angle in FILM.plate_angles
    },
}


rule scene:
    """Snapshots of a case of the pictures."""
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
        code=CODE["scene"],
    script:
        "../scripts/scene.py"


rule angles:
    """Wear depth against time for angles of plate and factory."""
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
            "min_batches": CONFIG.wear_rate.min_batches,
        },
        code=CODE["angles"],
    script:
        "../scripts/angles.py"
