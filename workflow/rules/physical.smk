PHYSICAL, SURROGATE = LEARNING.physical, LEARNING.surrogate
# Quantities of the set-up that enter the dimensionless groups.
JET = {
    name: SETUP[name]
    for name in (
        "fall_height",
        "angle_acts",
        "arc_radius",
        "gravity",
        "mass_rate",
        "number_rate",
        "plate_length",
        "plate_width",
        "patch_length",
        "patch_width",
    )
}
FAMILIES = {
    "boosting": {"trees": PHYSICAL.boosting_trees, "depth": PHYSICAL.boosting_depth},
    "networks": {"members": PHYSICAL.networks, "steps": PHYSICAL.network_steps},
}


localrules:
    physical,


rule physical:
    """Target: the physics-informed models, and the surrogate for abradem predict."""
    input:
        f"{RESULTS}/models/surrogate.json",
        f"{RESULTS}/learning/physical.json",
        f"{RESULTS}/learning/targets.parquet",


rule fit_physical:
    """Power law, Gaussian process, boosting and ensemble of networks on dimensionless groups."""
    input:
        rules.dataset.output,
    output:
        scores=f"{RESULTS}/learning/physical_scores.parquet",
        predictions=f"{RESULTS}/learning/physical_predictions.parquet",
        exponents=f"{RESULTS}/learning/power_law.parquet",
        summary=report(
            f"{RESULTS}/learning/physical.json",
            caption="../report/physical.rst",
            category="Models",
            labels={"file": "physical.json", "content": "power law, scores"},
        ),
        process=f"{RESULTS}/models/gaussian_process.json",
        process_arrays=f"{RESULTS}/models/gaussian_process.safetensors",
    log:
        f"{LOGS}/fit_physical.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        models=FAMILIES,
        options={**SPLITS, "confidence": LEARNING.confidence},
        code=code_of("physical/physical"),
    script:
        "../scripts/physical/physical.py"


rule intervals:
    """Prediction intervals of the Gaussian process, calibrated and tested on held-out rows."""
    input:
        rules.dataset.output,
    output:
        calibration=f"{RESULTS}/learning/calibration.parquet",
        summary=f"{RESULTS}/learning/intervals.json",
    log:
        f"{LOGS}/intervals.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        options={"fold_count": PHYSICAL.interval_folds, "seed": CONFIG.seed},
        code=code_of("physical/intervals"),
    script:
        "../scripts/physical/intervals.py"


rule surrogate:
    """The surrogate for `abradem predict`, and its scores."""
    input:
        dataset=rules.dataset.output[0],
        process=rules.fit_physical.output.process_arrays,
        intervals=rules.intervals.output.summary,
    output:
        model=report(
            f"{RESULTS}/models/surrogate.json",
            caption="../report/surrogate.rst",
            category="Models",
            labels={"file": "surrogate.json", "content": "of abradem predict"},
        ),
        model_arrays=f"{RESULTS}/models/surrogate.safetensors",
        scores=f"{RESULTS}/learning/surrogate_scores.parquet",
        predictions=f"{RESULTS}/learning/surrogate_predictions.parquet",
    log:
        f"{LOGS}/surrogate.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        settings=SURROGATE.model_dump(include={"points", "hidden", "epochs"}),
        splits=SPLITS,
        options={
            "confidence": LEARNING.confidence,
            "seed": CONFIG.seed,
            "element_size": TARGET["element_size"],
        },
        code=code_of("physical/surrogate"),
    script:
        "../scripts/physical/surrogate.py"


rule sensitivity:
    """Sensitivity of the wear to the sampled quantities."""
    input:
        dataset=rules.dataset.output[0],
        process=rules.fit_physical.output.process_arrays,
    output:
        indices=f"{RESULTS}/learning/sobol.parquet",
        falls=f"{RESULTS}/learning/permutation.parquet",
        dependence=f"{RESULTS}/learning/dependence.parquet",
        summary=f"{RESULTS}/learning/sensitivity.json",
    log:
        f"{LOGS}/sensitivity.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        sobol={
            "points": PHYSICAL.sobol_points,
            "confidence": LEARNING.confidence,
            "seed": CONFIG.seed,
        },
        splits={**SPLITS, "repeats": PHYSICAL.target_repeats},
        code=code_of("physical/sensitivity"),
    script:
        "../scripts/physical/sensitivity.py"


rule reach:
    """Learning curves, extrapolation, and scores for all wear rates."""
    input:
        rules.dataset.output,
    output:
        curve=f"{RESULTS}/learning/learning_curve.parquet",
        extrapolation=f"{RESULTS}/learning/extrapolation.parquet",
        targets=f"{RESULTS}/learning/targets.parquet",
    log:
        f"{LOGS}/reach.log",
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        models=FAMILIES,
        curve={
            **SPLITS,
            "repeats": PHYSICAL.curve_repeats,
            "confidence": LEARNING.confidence,
        },
        targets={
            **SPLITS,
            "repeats": PHYSICAL.target_repeats,
            "confidence": LEARNING.confidence,
        },
        code=code_of("physical/reach"),
    script:
        "../scripts/physical/reach.py"


if SIMULATED:

    rule noise_floor:
        """The largest R2 that any model could reach."""
        input:
            replicates=expand(rules.replicates.output, part=REPLICATE_PARTS),
            dataset=rules.dataset.output[0],
        output:
            per_case=f"{RESULTS}/learning/noise.parquet",
            summary=f"{RESULTS}/learning/noise_floor.json",
        log:
            f"{LOGS}/noise_floor.log",
        conda:
            "../envs/abradem.yaml"
        params:
            target=LEARNING.target,
            confidence=LEARNING.confidence,
            code=code_of("physical/noise_floor"),
        script:
            "../scripts/physical/noise_floor.py"

    rule speed_up:
        """Computing times of engine and surrogate, measured in turn in one job."""
        input:
            dataset=rules.dataset.output[0],
            surrogate=rules.surrogate.output.model,
            arrays=rules.surrogate.output.model_arrays,
        output:
            report(
                f"{RESULTS}/learning/speed_up.json",
                caption="../report/speed_up.rst",
                category="Models",
                labels={"file": "speed_up.json", "content": "speed of the surrogate"},
            ),
        log:
            f"{LOGS}/speed_up.log",
        conda:
            "../envs/abradem.yaml"
        params:
            options={
                "count": SURROGATE.timed_cases,
                "setup": SETUP,
                "seed": CONFIG.seed,
            },
            code=code_of("physical/speed_up"),
        script:
            "../scripts/physical/speed_up.py"


NOISE_SUMMARY = rules.noise_floor.output.summary if SIMULATED else []
