"""Catalogue of the figures of a study: group, label, caption, protocol and drawing function.

The report, the gallery and the workflow rules use this table. The parameters of a drawing function
are the inputs and options of the workflow rule of the figure.
"""

from __future__ import annotations

from typing import NamedTuple

BOTH = "as published and leakage-free"
LEAKAGE_FREE = "leakage-free"
ALL_ROWS = "all rows, descriptive"


class Entry(NamedTuple):
    """A figure of the catalogue.

    Attributes
    ----------
    group : str
        Heading under which the figure is shown.
    label : str
        Short name.
    draw : str
        Drawing function, ``module:function`` within `abradem.figures`.
    caption : str
        Caption in reStructuredText.
    protocol : str
        Protocol of the scores shown; "" if there are none.
    """

    group: str
    label: str
    draw: str
    caption: str
    protocol: str = ""

    @property
    def module(self) -> str:
        """Full name of the module of the drawing function."""
        return f"abradem.figures.{self.draw.partition(':')[0]}"

    @property
    def full_caption(self) -> str:
        """The caption, followed by the protocol if there is one."""
        return f"{self.caption} Protocol: {self.protocol}." if self.protocol else self.caption


SETUP, SIMULATIONS, LINEAR = "Set-up", "Simulations", "Linear models"
COMPONENTS, TREES, NETWORKS = "Principal components", "Trees", "Networks"
PHYSICAL, ALL_MODELS = "Models on dimensionless groups", "All models"
VERIFICATION = "Verification and performance"
CALIBRATION = "Calibration to a table"
SURFACE = "Wear of a surface"

FIGURES: dict[str, Entry] = {
    "setup": Entry(
        SETUP,
        "simulation set-up",
        "setup:draw",
        "The simulation at one time step of the typical case (``figures.typical`` in the "
        "configuration): plate, factory patch and particles, and the wear of the plate as a map. "
        "Of a geometry: parts, factory, jet and particles in space, and from the side with angles "
        "and the limits beyond which particles are removed.",
    ),
    "generation": Entry(
        SETUP,
        "generation of the data",
        "flow:draw_generation",
        "Generation of the data by the rules of the workflow, and set-up of each simulation, with "
        "the numbers of this study.",
    ),
    "rules": Entry(
        SETUP,
        "rules of the workflow",
        "flow:workflow_figure",
        "All workflow rules of the study, as reported by Snakemake, and their dependencies.",
    ),
    "series": Entry(
        SIMULATIONS,
        "wear depth against time",
        "series:draw",
        "Mean wear depth of the plate against simulated time for the cases of "
        "``figures.series_cases``, with the fitted slopes.",
    ),
    "angles": Entry(
        SIMULATIONS,
        "wear depth by angle",
        "angles:angles_figure",
        "Mean wear depth of the plate against time for several plate angles and factory angles, "
        "the other quantities as in the typical case, and the steady slopes with standard errors.",
    ),
    "quality": Entry(
        SIMULATIONS,
        "quality of the wear rates",
        "quality:draw",
        "Relative standard error of the wear depth rate that the models predict, and R² of a "
        "straight line fitted to the cumulative wear. R² of a cumulative series is always high and "
        "only descriptive; the standard error measures the quality.",
    ),
    "maps": Entry(
        SIMULATIONS,
        "wear on the plate",
        "maps:draw",
        "Wear depth rate on the facets of the plate, within the window after the transient, for "
        "the cases of ``figures.series_cases``.",
    ),
    "gallery": Entry(
        SIMULATIONS,
        "wear maps over the parameter space",
        "gallery:draw",
        "Wear maps over the parameter space: for each cell of plate angle and vertical particle "
        "velocity, the case nearest to its centre. Each map has its own colour scale.",
    ),
    "coefficients": Entry(
        LINEAR,
        "coefficients of the linear regression",
        "linear:coefficients_figure",
        "Coefficients of the linear regression between standardised features and target, X1 to "
        "X10 and X11 to X20, with their intervals.",
        ALL_ROWS,
    ),
    "predicted_linear": Entry(
        LINEAR,
        "predicted against simulated wear, linear regression",
        "linear:predicted_figure",
        "Wear depth rate predicted by the linear regression against the simulated one, for "
        "held-out cases of the repeated splits.",
        LEAKAGE_FREE,
    ),
    "residuals": Entry(
        LINEAR,
        "residuals of the linear regression",
        "residuals:residuals_figure",
        "Residuals of the linear regression: residuals against fitted values with the "
        "Breusch-Pagan test (for a small p the variance of the residuals depends on the "
        "features), quantiles of the residuals, and variance inflation factors (how much "
        "dependence among features widens the interval of a coefficient).",
        ALL_ROWS,
    ),
    "penalised": Entry(
        LINEAR,
        "lasso and ridge",
        "penalised:penalised_figure",
        "Lasso and ridge: paths of the weights over the penalty, cross-validated R², and the "
        "weights under both protocols, with the share of the leakage-free splits in which the "
        "lasso keeps a feature.",
        BOTH,
    ),
    "selection": Entry(
        LINEAR,
        "selection of features",
        "selection:selection_figure",
        "Features of the networks, chosen by weight and by loading under both protocols, compared "
        "with the paper's list of 12.",
        BOTH,
    ),
    "correlations": Entry(
        COMPONENTS,
        "correlations",
        "pca:draw_correlations",
        "Pearson correlations of every pair of X1 to X21 (the wear), all cases. Derived "
        "features are correlated with the features they are functions of.",
        ALL_ROWS,
    ),
    "loadings": Entry(
        COMPONENTS,
        "principal components",
        "pca:loadings_figure",
        "Principal components of the 20 features, scaled to 0...1 over all rows (as published) "
        "and standardised (leakage-free): shares of the variance, loadings, and the stiffnesses "
        "grouped by the same component.",
        BOTH,
    ),
    "components": Entry(
        COMPONENTS,
        "regression on principal components",
        "pca:components_curve_figure",
        "R² on held-out cases of the regression on 1, 2, ... principal components: as published "
        "with the paper's wrong target (the last component) and with the wear, leakage-free with "
        "the wear.",
        BOTH,
    ),
    "tree": Entry(
        TREES,
        "decision tree",
        "trees:tree_figure",
        "The decision tree of all cases after cost-complexity pruning with a cross-validated "
        "penalty.",
        LEAKAGE_FREE,
    ),
    "tree_depth": Entry(
        TREES,
        "depth of the decision tree",
        "trees:tree_curve_figure",
        "R² of the decision tree on training and test rows against its maximum depth, under both "
        "protocols, and the importance of features for the leakage-free tree and forest. As "
        "published the features are unscaled, and scikit-learn never splits on the wear constant.",
        BOTH,
    ),
    "ga_ann": Entry(
        NETWORKS,
        "genetic search",
        "ga_ann:draw",
        "The genetic search for a network: fitness and size over the generations under both "
        "protocols, the lineage of the best network, and the scores of the same network trained "
        "again. As published the fitness is computed on the test rows, so that chance "
        "raises it; leakage-free it is computed on validation rows.",
        BOTH,
    ),
    "architecture": Entry(
        NETWORKS,
        "networks found by the search",
        "architecture:draw",
        "The networks found by the genetic search under both protocols: features, neurons of each "
        "hidden layer, wear depth rate.",
        BOTH,
    ),
    "distributions": Entry(
        NETWORKS,
        "distributions of wear and errors",
        "distributions:draw",
        "Distributions of the standardised wear depth rate, of the predictions on test rows by the "
        "network found under each protocol, and of their errors.",
        BOTH,
    ),
    "models": Entry(
        PHYSICAL,
        "models on dimensionless groups",
        "physical:models_figure",
        "Models on dimensionless groups: R² on held-out cases compared with the best that any "
        "model could reach, coverage of the intervals, and R² against the number of training "
        "cases.",
        LEAKAGE_FREE,
    ),
    "power_law": Entry(
        PHYSICAL,
        "power law",
        "physical:power_law_figure",
        "The power law of the wear depth rate on dimensionless groups: its equation, and the "
        "exponents of the quantities and of some groups.",
        ALL_ROWS,
    ),
    "sensitivity": Entry(
        PHYSICAL,
        "sensitivity",
        "sensitivity:sensitivity_figure",
        "Sensitivity of the wear to the sampled quantities: Sobol indices, fall of R² when a "
        "quantity is shuffled, and partial dependence of the predicted wear.",
        LEAKAGE_FREE,
    ),
    "reach": Entry(
        PHYSICAL,
        "extrapolation and all wear rates",
        "reach:reach_figure",
        "Models beyond the ranges of their training data, and R² for every wear measure and "
        "statistic.",
        LEAKAGE_FREE,
    ),
    "comparison": Entry(
        ALL_MODELS,
        "all models",
        "comparison:comparison_figure",
        "R² of all models on held-out cases: printed in the paper, reproduced on this data set as "
        "published, and leakage-free with intervals.",
        BOTH,
    ),
    "predictions": Entry(
        ALL_MODELS,
        "predictions of all models",
        "comparison:predictions_figure",
        "Predicted against simulated wear (parity) of the test rows for each model under both "
        "protocols.",
        BOTH,
    ),
    "agreement": Entry(
        CALIBRATION,
        "simulated against given wear rates",
        "calibration:draw_agreement",
        "Wear depth rates simulated with the best set-up against those of the table, without a "
        "fitted constant, and their ratio against each quantity.",
        "rows used by the search and rows held out",
    ),
    "profiles": Entry(
        CALIBRATION,
        "profiles of the unknowns",
        "calibration:draw_profiles",
        "The best agreement for each value of each unknown of the set-up, whatever the others are: "
        "what the table tells apart, and what not.",
        "rows of the first rung of the search",
    ),
    "surface": Entry(
        SURFACE,
        "wear of the surface",
        "surface_map:draw_surface",
        "Wear depth rate of every cell of the surface in the window after the transient, in space, "
        "and of the parts that can be laid out flat, for the first case of "
        "``figures.series_cases``.",
    ),
    "part_rates": Entry(
        SURFACE,
        "wear of the parts",
        "part_rates:draw_part_rates",
        "Wear depth rate of each named part of the surface against the quantities that varied, "
        "those with the strongest rank correlation first; where none varied, side by side.",
    ),
    "verification": Entry(
        VERIFICATION,
        "verification",
        "verdicts:draw",
        "All checks of the last run of ``make verify``, with the share of the tolerance that each "
        "uses.",
    ),
    "speed": Entry(
        VERIFICATION,
        "performance of the engine",
        "speed:cost_figure",
        "Cost of a simulation: computing time per simulated second against the number of "
        "particles present, for both stepping methods and for other codes if they are installed, "
        "from the last run of ``benchmarks/cost.py``.",
    ),
}
"""The figures by name, in the order of the report."""


def groups() -> dict[str, dict[str, Entry]]:
    """The figures by group and name, in the order of `FIGURES`."""
    found: dict[str, dict[str, Entry]] = {}
    for name, entry in FIGURES.items():
        found.setdefault(entry.group, {})[name] = entry
    return found
