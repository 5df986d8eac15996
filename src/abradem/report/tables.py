"""The tables of the report and their captions."""

from __future__ import annotations

TABLES: dict[str, str] = {
    "dataset": "The data set: quantities, features, wear depth rates and their standard errors for "
    "each case. The unit is in the header of a column, its meaning appears under the pointer.",
    "linear_coefficients": "Coefficients of the linear regression between standardised features "
    "and target, with standard errors and intervals.",
    "linear_published": "The printed coefficients of the linear equation compared with a refit by "
    "the same steps (protocol: as published). Misprints can be identified only on the paper's own "
    "data set; for other data sets the verdict is *another table*.",
    "penalised_weights": "Weights of lasso and ridge under both protocols, and the share of the "
    "fits in which the weight of a feature is not zero.",
    "selection": "The features chosen for the networks under both protocols, and the paper's list.",
    "scores": "Scores of the models: one row per model, protocol, split and metric.",
    "comparison": "Scores of each model and protocol on held-out cases with their intervals (R² of "
    "the wear, of its logarithm and of the logarithm of the wear number, errors), and the "
    "basis of the interval.",
    "beside_paper": "For each model, the printed R², the R² reproduced on this data set as "
    "published, and the leakage-free R².",
    "error_by_region": "Share of the held-out error of each model by region of the ranges "
    "(leakage-free, all splits): of the wear and of the logarithm of the wear number, beside the "
    "share of the cases, and R² of that logarithm within the region.",
    "power_law": "Exponents of the power law with standard errors (HC3): of the quantities, with "
    "all others fixed, and of the dimensionless groups.",
    "exponents": "Exponents of the wear depth rate that the models predict, by least squares of "
    "its logarithm on the cases faster than 4 m/s, beside those of the data that the paper's "
    "authors published (of v² + 2 g H for the speed of impact, of 1 + e for the restitution): "
    "standard errors, difference in combined standard errors, and a verdict (*agrees* up to two "
    "of them).",
    "targets": "R² of every wear measure and statistic over the plate for the power law and the "
    "Gaussian process: median over the repeated splits with their central share, R² of ln y, and "
    "the number of targets that were not positive and were raised.",
    "extrapolation": "R² and mean absolute relative error on cases beyond the training ranges, "
    "compared with models trained on such cases, and the coverage of the 95 % intervals.",
    "sobol": "First-order and total Sobol indices of the wear and of its logarithm over the ranges "
    "of the data set, from the Gaussian process, with intervals from functions drawn from its "
    "posterior.",
    "calibration": "Coverage of the prediction intervals on held-out cases by nominal level, with "
    "the binomial band and the median relative width.",
    "coverage": "Coverage of the prediction intervals on held-out cases by region of the ranges "
    "and nominal level, with the binomial band of each share and the joint band, which holds all "
    "shares of faultless intervals at once in 95 of 100 studies.",
    "fresh_coverage": "Coverage of the intervals of the surrogate on fresh cases, which no "
    "model has seen, by place of the plate, region of the ranges and nominal level, with the "
    "binomial band of each share and the joint band of those by region.",
    "failures": "Cases that are not in the data set, because they were rejected as physically "
    "inconsistent or ended early, with the reasons.",
}
"""Caption of each table, by its name, in the order of the report."""
