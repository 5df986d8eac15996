# One rule per figure, so that a change redraws only the figures concerned. Group, label, caption
# and drawing function of each figure are in abradem.figures.catalogue.
SHOWN = CONFIG.figures.series_cases
GALLERY_GRID = {
    "across": "plate_angle",
    "down": "particle_velocity_y",
    "columns": 6,
    "rows": 5,
}


localrules:
    figures,


rule figures:
    """Target: all figures, as PDF and PNG."""
    input:
        expand(
            f"{RESULTS}/figures/{{name}}.{{format}}",
            name=[name for name in FIGURES if is_made(name)],
            format=FORMATS,
        ),


if ON_PLATE:

    # Figures of single cases depend only on the batches of these cases, so that new blocks do not
    # redraw them.
    rule figure_series:
        """Wear depth against time for some cases."""
        input:
            cases=batches_with(SHOWN, f"{RESULTS}/cases/block-{{block}}.parquet"),
            series=batches_with(SHOWN, rules.simulate.output.series),
            runs=batches_with(SHOWN, rules.simulate.output.runs),
        output:
            figure_files("series"),
        log:
            f"{LOGS}/figure_series.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("series"),
            options={
                "shown": SHOWN,
                "setup": SETUP,
                "min_batches": CONFIG.wear_rate.min_batches,
                "target": TARGET,
            },
        script:
            "../scripts/figures/figure.py"

    rule figure_angles:
        """Wear depth against time for several plate angles and factory angles."""
        input:
            curves=rules.angles.output.curves,
            rates=rules.angles.output.rates,
        output:
            figure_files("angles"),
        log:
            f"{LOGS}/figure_angles.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("angles"),
            options={
                "case": TYPICAL,
                "duration": CONFIG.figures.angles.duration_s,
                "measure": MEASURE,
            },
        script:
            "../scripts/figures/figure.py"

    rule figure_quality:
        """Quality of the wear rates."""
        input:
            dataset=rules.dataset.output[0],
        output:
            figure_files("quality"),
        log:
            f"{LOGS}/figure_quality.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("quality"),
            options={
                "target": TARGET,
                "target_stderr": CONFIG.simulation.stop.target_stderr,
                "good_r2": CONFIG.wear_rate.good_r2,
            },
        script:
            "../scripts/figures/figure.py"

    rule figure_maps:
        """Distribution of the wear over the plate, for some cases."""
        input:
            cases=batches_with(SHOWN, f"{RESULTS}/cases/block-{{block}}.parquet"),
            maps=batches_with(SHOWN, rules.simulate.output.maps),
            runs=batches_with(SHOWN, rules.simulate.output.runs),
        output:
            figure_files("maps"),
        log:
            f"{LOGS}/figure_maps.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("maps"),
            options={"shown": SHOWN, "setup": SETUP, "target": TARGET},
        script:
            "../scripts/figures/figure.py"

    rule figure_gallery:
        """Wear maps over the parameter space."""
        input:
            cases=CASES,
            maps=batch_paths(rules.simulate.output.maps),
            runs=RUNS,
        output:
            figure_files("gallery"),
        log:
            f"{LOGS}/figure_gallery.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("gallery"),
            options={"setup": SETUP, "grid": GALLERY_GRID, "target": TARGET},
        script:
            "../scripts/figures/figure.py"


rule figure_generation:
    """Flow chart: generation of the data, set-up of a simulation."""
    input:
        graph=rules.rule_graph.output[0],
    output:
        figure_files("generation"),
    log:
        f"{LOGS}/figure_generation.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("generation"),
        options={
            "study": {
                "cases": CONFIG.cases,
                "blocks": CONFIG.sampling.blocks,
                "jobs": CONFIG.jobs,
                "method": CONFIG.sampling.method,
                "seed": CONFIG.seed,
                "external": CONFIG.dataset.external,
            },
            "setup": SETUP if SIMULATED else None,
        },
    script:
        "../scripts/figures/figure.py"


rule figure_rules:
    """Flow chart: all rules of the workflow."""
    input:
        graph=rules.rule_graph.output[0],
    output:
        figure_files("rules"),
    log:
        f"{LOGS}/figure_rules.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("rules"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_coefficients:
    """Coefficients of the linear regression."""
    input:
        coefficients=rules.linear.output.coefficients,
        model=rules.linear.output.summary,
    output:
        figure_files("coefficients"),
    log:
        f"{LOGS}/figure_coefficients.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("coefficients"),
        options={
            name: TARGET[name] for name in ("element_size", "known", "cells", "part")
        },
    script:
        "../scripts/figures/figure.py"


rule figure_predicted_linear:
    """Predicted against simulated wear for held-out cases."""
    input:
        predictions=rules.linear.output.predictions,
        model=rules.linear.output.summary,
    output:
        figure_files("predicted_linear"),
    log:
        f"{LOGS}/figure_predicted_linear.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("predicted_linear"),
        options={
            name: TARGET[name] for name in ("element_size", "known", "cells", "part")
        },
    script:
        "../scripts/figures/figure.py"


rule figure_residuals:
    """Residuals of the linear regression, and dependence among the features."""
    input:
        residuals=rules.linear.output.residuals,
        coefficients=rules.linear.output.coefficients,
        model=rules.linear.output.summary,
    output:
        figure_files("residuals"),
    log:
        f"{LOGS}/figure_residuals.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("residuals"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_penalised:
    """Paths, penalties and weights of lasso and ridge."""
    input:
        paths=rules.penalised.output.paths,
        validation=rules.penalised.output.validation,
        weights=rules.penalised.output.weights,
        summary=rules.penalised.output.summary,
    output:
        figure_files("penalised"),
    log:
        f"{LOGS}/figure_penalised.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("penalised"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_selection:
    """Selection of the features of the networks."""
    input:
        selection=rules.selection.output.selection,
        summary=rules.selection.output.summary,
    output:
        figure_files("selection"),
    log:
        f"{LOGS}/figure_selection.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("selection"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_correlations:
    """Correlations of the quantities."""
    input:
        correlations=rules.pca.output.correlations,
        model=rules.pca.output.model,
    output:
        figure_files("correlations"),
    log:
        f"{LOGS}/figure_correlations.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("correlations"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_loadings:
    """Variances and loadings of the principal components."""
    input:
        loadings=rules.pca.output.loadings,
        scree=rules.pca.output.scree,
        summary=rules.pca.output.summary,
    output:
        figure_files("loadings"),
    log:
        f"{LOGS}/figure_loadings.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("loadings"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_components:
    """Regression on principal components."""
    input:
        curve=rules.pca.output.curve,
    output:
        figure_files("components"),
    log:
        f"{LOGS}/figure_components.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("components"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_tree_depth:
    """Scores of the decision tree against its depth."""
    input:
        curve=rules.trees.output.curve,
        importance=rules.trees.output.importance,
        summary=rules.trees.output.summary,
    output:
        figure_files("tree_depth"),
    log:
        f"{LOGS}/figure_tree_depth.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("tree_depth"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_tree:
    """The pruned decision tree."""
    input:
        nodes=rules.trees.output.nodes,
        summary=rules.trees.output.summary,
    output:
        figure_files("tree"),
    log:
        f"{LOGS}/figure_tree.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("tree"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_ga_ann:
    """The genetic search under both protocols."""
    input:
        history=expand(rules.ga_ann.output.history, protocol=PROTOCOLS),
        scores=expand(rules.ga_ann.output.scores, protocol=PROTOCOLS),
        summaries=expand(rules.ga_ann.output.summary, protocol=PROTOCOLS),
    output:
        figure_files("ga_ann"),
    log:
        f"{LOGS}/figure_ga_ann.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("ga_ann"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_architecture:
    """The networks found by the genetic search."""
    input:
        summaries=expand(rules.ga_ann.output.summary, protocol=PROTOCOLS),
    output:
        figure_files("architecture"),
    log:
        f"{LOGS}/figure_architecture.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("architecture"),
        options={},
    script:
        "../scripts/figures/figure.py"


rule figure_distributions:
    """Distributions of standardised wear, predictions and errors."""
    input:
        dataset=ROWS,
        predictions=rules.scores.output.predictions,
    output:
        figure_files("distributions"),
    log:
        f"{LOGS}/figure_distributions.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("distributions"),
        options={"target": LEARNING.target, "model": "ga_ann"},
    script:
        "../scripts/figures/figure.py"


rule figure_models:
    """Overview of the models on dimensionless groups."""
    input:
        comparison=rules.scores.output.comparison,
        calibration=rules.intervals.output.calibration,
        curve=rules.reach.output.curve,
        noise=NOISE_SUMMARY,
    output:
        figure_files("models"),
    log:
        f"{LOGS}/figure_models.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("models"),
        options={"table": CONFIG.study},
    script:
        "../scripts/figures/figure.py"


rule figure_power_law:
    """Exponents and equation of the power law."""
    input:
        exponents=rules.fit_physical.output.exponents,
    output:
        figure_files("power_law"),
    log:
        f"{LOGS}/figure_power_law.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("power_law"),
        options={"table": CONFIG.study},
    script:
        "../scripts/figures/figure.py"


rule figure_sensitivity:
    """Sobol indices, permutation importance, partial dependence."""
    input:
        indices=rules.sensitivity.output.indices,
        falls=rules.sensitivity.output.falls,
        dependence=rules.sensitivity.output.dependence,
    output:
        figure_files("sensitivity"),
    log:
        f"{LOGS}/figure_sensitivity.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("sensitivity"),
        options={"table": CONFIG.study},
    script:
        "../scripts/figures/figure.py"


rule figure_reach:
    """Extrapolation, and scores for all wear rates."""
    input:
        extrapolation=rules.reach.output.extrapolation,
        targets=rules.reach.output.targets,
    output:
        figure_files("reach"),
    log:
        f"{LOGS}/figure_reach.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("reach"),
        options={"table": CONFIG.study},
    script:
        "../scripts/figures/figure.py"


rule figure_comparison:
    """Comparison of all models."""
    input:
        comparison=rules.scores.output.comparison,
        beside_paper=rules.scores.output.beside_paper,
    output:
        figure_files("comparison"),
    log:
        f"{LOGS}/figure_comparison.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("comparison"),
        options={"table": CONFIG.study},
    script:
        "../scripts/figures/figure.py"


rule figure_predictions:
    """Predictions of all models on held-out cases."""
    input:
        predictions=rules.scores.output.predictions,
        comparison=rules.scores.output.comparison,
    output:
        figure_files("predictions"),
    log:
        f"{LOGS}/figure_predictions.log",
    conda:
        "../envs/abradem.yaml"
    params:
        **drawn_as("predictions"),
        options={},
    script:
        "../scripts/figures/figure.py"


if VERIFICATION_MADE:

    # The checks are not an input of the study: the figure shows the last results of `make verify`
    # and does not repeat it.
    rule figure_verification:
        """Overview of the verification study."""
        output:
            figure_files("verification"),
        log:
            f"{LOGS}/figure_verification.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("verification"),
            shown={"checks": str(VERIFICATION_CHECKS)},
            content=files_hash(VERIFICATION_CHECKS),
            options={},
        script:
            "../scripts/figures/figure.py"


if SPEED_MADE:

    rule figure_speed:
        """Cost of simulations."""
        output:
            figure_files("speed"),
        log:
            f"{LOGS}/figure_speed.log",
        conda:
            "../envs/abradem.yaml"
        params:
            **drawn_as("speed"),
            shown={path.stem: str(path) for path in SPEED_TABLES},
            content=files_hash(*SPEED_TABLES),
            options={},
        script:
            "../scripts/figures/figure.py"
