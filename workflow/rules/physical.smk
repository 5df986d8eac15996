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
        "geometry",
    )
    if name in SETUP
}
DISTILLED = SURROGATE.model_dump(include={"points", "hidden", "epochs"})
FAMILIES = {
    "boosting": {"trees": PHYSICAL.boosting_trees, "depth": PHYSICAL.boosting_depth},
    "networks": {"members": PHYSICAL.networks, "steps": PHYSICAL.network_steps},
}


# Blocks of fresh cases, if there are any; a table from elsewhere has none.
TESTED_WITH = FRESH if SIMULATED else range(0)
FRESH_COVERAGE = [f"{RESULTS}/learning/fresh_coverage.parquet"] if TESTED_WITH else []
FRESH_SUMMARY = [f"{RESULTS}/learning/fresh_coverage.json"] if TESTED_WITH else []


localrules:
    physical,
    coverage,


rule physical:
    """Target: the physics-informed models, and the surrogate for abradem predict."""
    input:
        f"{RESULTS}/models/surrogate.json",
        f"{RESULTS}/learning/physical.json",
        f"{RESULTS}/learning/targets.parquet",
        f"{RESULTS}/models/wear_maps.json" if ON_PLATE else [],
        FRESH_COVERAGE,


rule coverage:
    """Target: coverage of the prediction intervals by region, on learning.fresh_blocks too."""
    input:
        f"{RESULTS}/learning/coverage.parquet",
        FRESH_COVERAGE,


rule fit_physical:
    """Power law, Gaussian process, boosting and ensemble of networks on dimensionless groups."""
    input:
        ROWS,
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
    benchmark:
        f"{RESULTS}/benchmarks/fit_physical.tsv"
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
        ROWS,
    output:
        calibration=f"{RESULTS}/learning/calibration.parquet",
        regions=f"{RESULTS}/learning/coverage.parquet",
        scores=f"{RESULTS}/learning/held_out_errors.parquet",
        summary=f"{RESULTS}/learning/intervals.json",
    log:
        f"{LOGS}/intervals.log",
    benchmark:
        f"{RESULTS}/benchmarks/intervals.tsv"
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


rule local_wear:
    """Models of the wear at other places of the plate, for the surrogate."""
    input:
        ROWS,
    output:
        local=f"{RESULTS}/learning/local_wear.json",
        local_arrays=f"{RESULTS}/learning/local_wear.safetensors",
    log:
        f"{LOGS}/local_wear.log",
    benchmark:
        f"{RESULTS}/benchmarks/local_wear.tsv"
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        settings=DISTILLED,
        options={
            "fold_count": PHYSICAL.interval_folds,
            "seed": CONFIG.seed,
            "element_size": TARGET["element_size"],
        },
        code=code_of("physical/local_wear"),
    script:
        "../scripts/physical/local_wear.py"


rule surrogate:
    """The surrogate for `abradem predict`, and its scores."""
    input:
        dataset=ROWS,
        process=rules.fit_physical.output.process_arrays,
        intervals=rules.intervals.output.summary,
        errors=rules.intervals.output.scores,
        local=rules.local_wear.output.local,
        local_arrays=rules.local_wear.output.local_arrays,
    output:
        model=report(
            f"{RESULTS}/models/surrogate.json",
            caption="../report/surrogate.rst",
            category="Models",
            labels={"file": "surrogate.json", "content": "model of abradem predict"},
        ),
        model_arrays=f"{RESULTS}/models/surrogate.safetensors",
        scores=f"{RESULTS}/learning/surrogate_scores.parquet",
        predictions=f"{RESULTS}/learning/surrogate_predictions.parquet",
    log:
        f"{LOGS}/surrogate.log",
    benchmark:
        f"{RESULTS}/benchmarks/surrogate.tsv"
    conda:
        "../envs/abradem.yaml"
    resources:
        mem_mb=growing(LEARNING_MB),
        runtime=growing(LEARNING_MINUTES),
    params:
        setup=JET,
        table=LEARNED_FROM,
        settings=DISTILLED,
        splits=SPLITS,
        options={
            "confidence": LEARNING.confidence,
            "seed": CONFIG.seed,
            "element_size": TARGET["element_size"],
        },
        meaning={
            "jet_known": jet_is_known(CONFIG),
            "target_known": TARGET["known"],
            "cells": TARGET["cells"],
            "part": TARGET["part"],
            "contacts": contacts_of(CONFIG),
        },
        code=code_of("physical/surrogate"),
    script:
        "../scripts/physical/surrogate.py"


rule sensitivity:
    """Sensitivity of the wear to the sampled quantities."""
    input:
        dataset=ROWS,
        process=rules.fit_physical.output.process_arrays,
    output:
        indices=f"{RESULTS}/learning/sobol.parquet",
        falls=f"{RESULTS}/learning/permutation.parquet",
        dependence=f"{RESULTS}/learning/dependence.parquet",
        summary=f"{RESULTS}/learning/sensitivity.json",
    log:
        f"{LOGS}/sensitivity.log",
    benchmark:
        f"{RESULTS}/benchmarks/sensitivity.tsv"
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
        ROWS,
    output:
        curve=f"{RESULTS}/learning/learning_curve.parquet",
        extrapolation=f"{RESULTS}/learning/extrapolation.parquet",
        targets=f"{RESULTS}/learning/targets.parquet",
    log:
        f"{LOGS}/reach.log",
    benchmark:
        f"{RESULTS}/benchmarks/reach.tsv"
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


if ON_PLATE:

    rule wear_maps:
        """The map surrogate, for `abradem predict --map` and the explorer, and its scores."""
        input:
            dataset=f"{RESULTS}/dataset.parquet",
            # As paths: Snakemake would hash a named list of outputs once for each of its files.
            maps=batch_paths(f"{RESULTS}/maps/block-{{block}}-batch-{{batch}}.parquet"),
            runs=RUNS,
        output:
            model=f"{RESULTS}/models/wear_maps.json",
            model_arrays=f"{RESULTS}/models/wear_maps.safetensors",
            scores=f"{RESULTS}/learning/map_scores.parquet",
        log:
            f"{LOGS}/wear_maps.log",
        benchmark:
            f"{RESULTS}/benchmarks/wear_maps.tsv"
        conda:
            "../envs/abradem.yaml"
        resources:
            mem_mb=growing(LEARNING_MB),
            runtime=growing(LEARNING_MINUTES),
        params:
            setup=SETUP,
            table=LEARNED_FROM,
            elements={
                "measure": MEASURE,
                "element_size": rate_options(CONFIG)["element_size"],
            },
            options={**SPLITS, "confidence": LEARNING.confidence},
            code=code_of("physical/wear_maps"),
        script:
            "../scripts/physical/wear_maps.py"

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


if TESTED_WITH:

    use rule join_cases as join_fresh_cases with:
        input:
            expand(f"{RESULTS}/cases/block-{{block}}.parquet", block=TESTED_WITH),
        output:
            f"{RESULTS}/fresh/cases.parquet",
        log:
            f"{LOGS}/join_fresh_cases.log",

    use rule dataset as fresh_dataset with:
        input:
            cases=f"{RESULTS}/fresh/cases.parquet",
            rates=batch_paths(rules.wear_rates.output[0], TESTED_WITH),
            runs=batch_paths(rules.simulate.output.runs, TESTED_WITH),
        output:
            f"{RESULTS}/fresh/dataset.parquet",
        log:
            f"{LOGS}/fresh_dataset.log",

    rule fresh_coverage:
        """Coverage of the intervals of the surrogate on fresh cases."""
        input:
            dataset=rules.dataset.output[0],
            fresh=rules.fresh_dataset.output[0],
            surrogate=rules.surrogate.output.model,
            arrays=rules.surrogate.output.model_arrays,
        output:
            coverage=FRESH_COVERAGE[0],
            summary=FRESH_SUMMARY[0],
        log:
            f"{LOGS}/fresh_coverage.log",
        conda:
            "../envs/abradem.yaml"
        params:
            setup=JET,
            table=LEARNED_FROM,
            code=code_of("physical/fresh_coverage"),
        script:
            "../scripts/physical/fresh_coverage.py"


NOISE_SUMMARY = rules.noise_floor.output.summary if ON_PLATE else []
