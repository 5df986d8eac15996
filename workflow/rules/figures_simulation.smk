SHOWN = CONFIG.figures.series_cases


# Figures of simulations, which an external table has none of. Figures of single cases take the
# shards that hold these, so that new blocks leave them as they are.
rule figure_series:
    """Wear depth against time for some cases."""
    input:
        cases=shards_with(SHOWN, f"{RESULTS}/cases/block-{{block}}.parquet"),
        series=shards_with(SHOWN, rules.simulate.output.series),
        runs=shards_with(SHOWN, rules.simulate.output.runs),
    output:
        figure_files("series", "wear depth against time"),
    log:
        f"{LOGS}/figure_series.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={"shown": SHOWN, "min_batches": CONFIG.wear_rate.min_batches},
        setup=SETUP,
        formats=FORMATS,
        code=CODE["figure_series"],
    script:
        "../scripts/figure_series.py"


rule figure_maps:
    """Where on the plate the wear is, for some cases."""
    input:
        cases=shards_with(SHOWN, f"{RESULTS}/cases/block-{{block}}.parquet"),
        maps=shards_with(SHOWN, rules.simulate.output.maps),
        runs=shards_with(SHOWN, rules.simulate.output.runs),
    output:
        figure_files("maps", "wear on the plate"),
    log:
        f"{LOGS}/figure_maps.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={"shown": SHOWN},
        setup=SETUP,
        formats=FORMATS,
        code=CODE["figure_maps"],
    script:
        "../scripts/figure_maps.py"


rule figure_quality:
    """How well the wear rates are known."""
    input:
        rules.dataset.output,
    output:
        figure_files("quality", "quality of the wear rates"),
    log:
        f"{LOGS}/figure_quality.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={
            "target_stderr": CONFIG.simulation.stop.target_stderr,
            "good_r2": CONFIG.wear_rate.good_r2,
        },
        formats=FORMATS,
        code=CODE["figure_quality"],
    script:
        "../scripts/figure_quality.py"


rule figure_setup:
    """The simulation set-up: plate, factory and particles, and the wear."""
    input:
        particles=f"{RESULTS}/scenes/typical/particles.parquet",
        wear=f"{RESULTS}/scenes/typical/wear.parquet",
    output:
        figure_files("setup", "simulation set-up"),
    log:
        f"{LOGS}/figure_setup.log",
    conda:
        "../envs/abradem.yaml"
    params:
        case=TYPICAL,
        setup=SETUP,
        formats=FORMATS,
        code=CODE["figure_setup"],
    script:
        "../scripts/figure_setup.py"


rule figure_angles:
    """Wear depth against time for angles of plate and factory."""
    input:
        curves=rules.angles.output.curves,
        rates=rules.angles.output.rates,
    output:
        figure_files("angles", "wear depth by angle"),
    log:
        f"{LOGS}/figure_angles.log",
    conda:
        "../envs/abradem.yaml"
    params:
        options={"case": TYPICAL, "duration": CONFIG.figures.angles.duration_s},
        formats=FORMATS,
        code=CODE["figure_angles"],
    script:
        "../scripts/figure_angles.py"


rule figure_gallery:
    """Wear maps over the parameter space."""
    input:
        cases=CASES,
        maps=shard_paths(rules.simulate.output.maps),
        runs=RUNS,
    output:
        figure_files("gallery", "wear over the parameter space"),
    log:
        f"{LOGS}/figure_gallery.log",
    conda:
        "../envs/abradem.yaml"
    params:
        grid={
            "across": "plate_angle",
            "down": "particle_velocity_y",
            "columns": 6,
            "rows": 5,
        },
        setup=SETUP,
        formats=FORMATS,
        code=CODE["figure_gallery"],
    script:
        "../scripts/figure_gallery.py"
