"""The tables that the report offers for reading: what each holds."""

from __future__ import annotations

TABLES: dict[str, str] = {
    "linear_coefficients": "Coefficients of the linear regression between standardised features "
    "and target, with standard errors and intervals.",
    "linear_published": "The printed coefficients of the linear equation beside a refit by its "
    "steps (protocol: as published). Misprints can be told only on the paper's own data set; "
    "elsewhere the verdict is that the data set is another one.",
    "penalised_weights": "Weights of lasso and ridge under both protocols, and the share of the "
    "fits in which a feature survives.",
    "selection": "The features chosen for the networks under both protocols, and the paper's list.",
    "scores": "Scores of the models: one row per protocol, split and metric.",
    "comparison": "R² of each model and protocol on held-out cases with its interval, and what "
    "that rests on.",
    "beside_paper": "The printed R², what its steps give on this data set, and the leakage-free "
    "R², for each model.",
    "power_law": "Exponents of the power law: of the quantities, all else fixed, and of the "
    "dimensionless groups, with standard errors (HC3).",
    "targets": "R² of every wear measure and statistic over the plate for the power law and the "
    "Gaussian process: median over the repeated splits with its central share, R² of ln y, and "
    "how many targets were not positive and were raised.",
    "extrapolation": "R² and mean absolute relative error on cases beyond what was learned from, "
    "beside models that saw such cases, and the coverage of the 95 % intervals.",
    "sobol": "First-order and total Sobol indices of the wear and of its logarithm over the ranges "
    "of the data set, by the Gaussian process, with bootstrap intervals.",
    "calibration": "Coverage of the prediction intervals on held-out cases by nominal level, with "
    "the binomial band and the median relative width.",
    "failures": "Cases that are no row of the data set: rejected as physically inconsistent, or "
    "ended early, and why.",
}
"""Caption of each table, by its name, in the order of the report."""
