OF_SIMULATIONS = (
    ["setup", "angles", "series", "quality", "maps", "gallery"] if SIMULATED else []
)
OF_PAPER = [
    "generation",
    "rules",
    "architecture",
    "distributions",
    *(["verification"] if VERIFICATION_MADE else []),
    *(["speed"] if SPEED_MADE else []),
]
OF_LEARNING = [
    "coefficients",
    "residuals",
    "predicted",
    "penalised",
    "selection",
    "correlations",
    "loadings",
    "components",
    "tree_depth",
    "tree",
    "ga_ann",
    "comparison",
    "predictions",
    "models",
    "sensitivity",
    "reach",
]


localrules:
    figures,


rule figures:
    """Target: all figures, as PDF and PNG."""
    input:
        expand(
            f"{RESULTS}/figures/{{name}}.{{format}}",
            name=OF_SIMULATIONS + OF_LEARNING + OF_PAPER,
            format=FORMATS,
        ),


# One rule for each figure, or few that one table makes: a change to one remakes only that one.
rule figure_coefficients:
    """Coefficients of the linear regression."""
    input:
        table=rules.linear.output.coefficients,
        summary=rules.linear.output.summary,
    output:
        figure_files("coefficients", "coefficients"),
    log:
        f"{LOGS}/figure_coefficients.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_coefficients"],
    script:
        "../scripts/figure_coefficients.py"


rule figure_predicted:
    """Predicted against actual wear, held-out cases."""
    input:
        table=rules.linear.output.predictions,
        summary=rules.linear.output.summary,
    output:
        figure_files("predicted", "predicted against actual"),
    log:
        f"{LOGS}/figure_predicted.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_predicted"],
    script:
        "../scripts/figure_predicted.py"


rule figure_residuals:
    """What is left of the wear after the linear equation, and how features depend on each other."""
    input:
        summary=rules.linear.output.summary,
        residuals=rules.linear.output.residuals,
        coefficients=rules.linear.output.coefficients,
    output:
        figure_files("residuals", "residuals of the linear regression"),
    log:
        f"{LOGS}/figure_residuals.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_residuals"],
    script:
        "../scripts/figure_residuals.py"


rule figure_penalised:
    """Paths, penalties and weights of lasso and ridge."""
    input:
        paths=rules.penalised.output.paths,
        validation=rules.penalised.output.validation,
        weights=rules.penalised.output.weights,
        summary=rules.penalised.output.summary,
    output:
        figure_files("penalised", "lasso and ridge"),
    log:
        f"{LOGS}/figure_penalised.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_penalised"],
    script:
        "../scripts/figure_penalised.py"


rule figure_selection:
    """The features that the networks get."""
    input:
        selection=rules.selection.output.selection,
        summary=rules.selection.output.summary,
    output:
        figure_files("selection", "selection of features"),
    log:
        f"{LOGS}/figure_selection.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_selection"],
    script:
        "../scripts/figure_selection.py"


rule figure_pca:
    """Correlations, loadings, and regression on principal components."""
    input:
        loadings=rules.pca.output.loadings,
        scree=rules.pca.output.scree,
        correlations=rules.pca.output.correlations,
        curve=rules.pca.output.curve,
        summary=rules.pca.output.summary,
        model=rules.pca.output.model,
    output:
        correlations=figure_files("correlations", "correlations"),
        loadings=figure_files("loadings", "principal components"),
        curve=figure_files("components", "regression on components"),
    log:
        f"{LOGS}/figure_pca.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_pca"],
    script:
        "../scripts/figure_pca.py"


rule figure_trees:
    """How deep a tree may grow, and the pruned one."""
    input:
        curve=rules.trees.output.curve,
        importance=rules.trees.output.importance,
        nodes=rules.trees.output.nodes,
        summary=rules.trees.output.summary,
    output:
        curve=figure_files("tree_depth", "depth of the tree"),
        tree=figure_files("tree", "decision tree"),
    log:
        f"{LOGS}/figure_trees.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_trees"],
    script:
        "../scripts/figure_trees.py"


rule figure_ga_ann:
    """The genetic search, both protocols."""
    input:
        history=expand(rules.ga_ann.output.history, protocol=PROTOCOLS),
        scores=expand(rules.ga_ann.output.scores, protocol=PROTOCOLS),
        summaries=expand(rules.ga_ann.output.summary, protocol=PROTOCOLS),
    output:
        figure_files("ga_ann", "genetic search"),
    log:
        f"{LOGS}/figure_ga_ann.log",
    conda:
        "../envs/abradem.yaml"
    params:
        formats=FORMATS,
        code=CODE["figure_ga_ann"],
    script:
        "../scripts/figure_ga_ann.py"


rule figure_comparison:
    """All models side by side."""
    input:
        predictions=rules.scores.output.predictions,
        comparison=rules.scores.output.comparison,
        beside_paper=rules.scores.output.beside_paper,
    output:
        comparison=figure_files("comparison", "all models"),
        predictions=figure_files("predictions", "predictions of all models"),
    log:
        f"{LOGS}/figure_comparison.log",
    conda:
        "../envs/abradem.yaml"
    params:
        table=CONFIG.study,
        formats=FORMATS,
        code=CODE["figure_comparison"],
    script:
        "../scripts/figure_comparison.py"
