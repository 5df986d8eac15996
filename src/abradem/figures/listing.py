"""The list of a study's figures: where the report and the gallery show each, and what it is."""

GROUPS: dict[str, dict[str, str]] = {
    "Set-up": {
        "setup": "Simulation set-up at a real time step, and the wear of the plate",
        "generation": "Generation of the data, and set-up of each simulation",
        "rules": "All rules of the workflow, and what each takes from which",
    },
    "Simulations": {
        "series": "Wear depth against time for some cases, with the fitted slopes",
        "angles": "Wear depth against time for angles of plate and factory",
        "quality": "How well the wear rates are known",
        "maps": "Wear on the plate for some cases",
        "gallery": "Wear maps over the parameter space",
    },
    "Linear models": {
        "coefficients": "Coefficients of the linear equation",
        "predicted": "Predicted against simulated wear, linear equation",
        "residuals": "What the linear equation leaves",
        "penalised": "Lasso and ridge: paths, penalties, weights",
        "selection": "Features that the networks get",
    },
    "Principal components": {
        "correlations": "Correlations of the quantities",
        "loadings": "Variances and loadings of the components",
        "components": "R² against the number of components",
    },
    "Trees": {
        "tree": "The decision tree",
        "tree_depth": "R² against the depth of the tree",
    },
    "Networks": {
        "ga_ann": "The genetic search",
        "architecture": "The networks that it found",
        "distributions": "Distributions of wear, predictions and errors",
    },
    "Models on dimensionless groups": {
        "models": "How good, how sure, from how many cases: models on dimensionless groups",
        "sensitivity": "Which quantities the wear depends on",
        "reach": "Models beyond the ranges they learned from",
    },
    "All models": {
        "comparison": "R² of all models: printed, as published, honest",
        "predictions": "Predicted against simulated wear of all models",
    },
    "Verification and speed": {
        "verification": "Which share of its tolerance each check of the engine uses",
        "speed": "What a simulation costs",
    },
}
"""Figures by group, in the order in which a text would show them."""

GROUP_OF: dict[str, str] = {name: group for group, names in GROUPS.items() for name in names}
