"""The figures of a study: the one place for the group, label, caption and protocol of each.

The report, the gallery and the rules of the workflow read this table. ``draw`` names the function
of `abradem.figures` that makes the figure; its parameters are the inputs of the figure's rule.
"""

from __future__ import annotations

from typing import NamedTuple

BOTH = "as published and leakage-free"
LEAKAGE_FREE = "leakage-free"
ALL_ROWS = "all rows, a description"


class Entry(NamedTuple):
    """What the report and the gallery say of a figure, and what draws it.

    Attributes
    ----------
    group : str
        Heading under which it is shown.
    label : str
        What it is, in a few words.
    draw : str
        ``module:function`` within `abradem.figures`.
    caption : str
        What it shows, as reStructuredText.
    protocol : str
        Protocol of the scores that it shows, "" where it shows none.
    """

    group: str
    label: str
    draw: str
    caption: str
    protocol: str = ""

    @property
    def module(self) -> str:
        """Module that draws it."""
        return f"abradem.figures.{self.draw.partition(':')[0]}"

    @property
    def full_caption(self) -> str:
        """The caption, with the protocol where there is one."""
        return f"{self.caption} Protocol: {self.protocol}." if self.protocol else self.caption


SETUP, SIMULATIONS, LINEAR = "Set-up", "Simulations", "Linear models"
COMPONENTS, TREES, NETWORKS = "Principal components", "Trees", "Networks"
PHYSICAL, ALL_MODELS = "Models on dimensionless groups", "All models"
VERIFICATION = "Verification and performance"

FIGURES: dict[str, Entry] = {
    "setup": Entry(
        SETUP,
        "simulation set-up",
        "setup:draw",
        "The simulation at one time step of the typical case (``figures.typical`` in the "
        "configuration): plate, factory patch and particles, and the wear of the plate as a map.",
    ),
    "generation": Entry(
        SETUP,
        "generation of the data",
        "flow:draw_generation",
        "How the data are generated, from the rules that the workflow runs, and how each "
        "simulation is set up, with the numbers of this study.",
    ),
    "rules": Entry(
        SETUP,
        "rules of the workflow",
        "flow:workflow_figure",
        "All rules that the study runs, as Snakemake states them, and what each takes from which.",
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
        "Relative standard error of the plate-mean wear depth rate, and R² of the cumulative wear "
        "against a straight line. R² of a cumulative series is high whatever happens: it "
        "describes, the standard error judges.",
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
        "velocity the case nearest to its middle. Each map has its own scale.",
    ),
    "coefficients": Entry(
        LINEAR,
        "coefficients of the linear regression",
        "linear:coefficients_figure",
        "Coefficients of the linear regression between standardised features and target, X1 to "
        "X10 and X11 to X20, with their intervals.",
        ALL_ROWS,
    ),
    "predicted": Entry(
        LINEAR,
        "predicted against simulated wear, linear regression",
        "linear:predicted_figure",
        "Wear depth rate predicted by the linear regression against the simulated one, held-out "
        "cases of the repeated splits.",
        LEAKAGE_FREE,
    ),
    "residuals": Entry(
        LINEAR,
        "residuals of the linear regression",
        "residuals:residuals_figure",
        "Residuals of the linear regression: residuals against fitted values with the "
        "Breusch-Pagan test (a small p: the scatter depends on the features), their quantiles, "
        "and variance inflation factors (how much dependence among features widens the interval "
        "of a coefficient).",
        ALL_ROWS,
    ),
    "penalised": Entry(
        LINEAR,
        "lasso and ridge",
        "penalised:penalised_figure",
        "Lasso and ridge: paths of the weights over the penalty, cross-validated R², and the "
        "weights under both protocols. Which features the lasso keeps, and in which share of the "
        "leakage-free splits.",
        BOTH,
    ),
    "selection": Entry(
        LINEAR,
        "selection of features",
        "selection:selection_figure",
        "The features that the networks get, chosen by weight and by loading under both "
        "protocols, beside the paper's list of 12.",
        BOTH,
    ),
    "correlations": Entry(
        COMPONENTS,
        "correlations",
        "pca:draw_correlations",
        "Pearson correlations among X1 to X10 and among X11 to X21 (the wear), all cases. Derived "
        "features follow those they are functions of.",
        ALL_ROWS,
    ),
    "loadings": Entry(
        COMPONENTS,
        "principal components",
        "pca:loadings_figure",
        "Principal components of the 20 features, scaled to 0...1 over all rows (as published) "
        "and standardised (leakage-free): shares of the variance and loadings, with the "
        "stiffnesses that load together.",
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
        "The decision tree of all cases: pruned by cost and complexity, the penalty "
        "cross-validated.",
        LEAKAGE_FREE,
    ),
    "tree_depth": Entry(
        TREES,
        "depth of the decision tree",
        "trees:tree_curve_figure",
        "R² of the decision tree against its largest depth on training and test rows, both "
        "protocols, and the importance of features for the leakage-free tree and forest. As "
        "published the features are unscaled, and the library never splits on the wear constant.",
        BOTH,
    ),
    "ga_ann": Entry(
        NETWORKS,
        "genetic search",
        "ga_ann:draw",
        "The genetic search for a network: fitness and size over the generations under both "
        "protocols, the descent of the best network, and the scores of the same network trained "
        "again. As published the fitness is read from the test rows, so that it flatters; "
        "leakage-free it is read from validation rows.",
        BOTH,
    ),
    "architecture": Entry(
        NETWORKS,
        "networks that the search found",
        "architecture:draw",
        "The networks that the genetic search found under both protocols: features, neurons of "
        "each hidden layer, wear depth rate.",
        BOTH,
    ),
    "distributions": Entry(
        NETWORKS,
        "distributions of wear and errors",
        "distributions:draw",
        "Distribution of the standardised wear depth rate, of the predictions of the network that "
        "the search found on test rows under both protocols, and of their errors.",
        BOTH,
    ),
    "models": Entry(
        PHYSICAL,
        "models on dimensionless groups",
        "physical:models_figure",
        "Models on dimensionless groups on one page: R² on held-out cases beside the best that "
        "any model could reach, coverage of the intervals, R² against the number of training "
        "cases, Sobol indices, and the power law.",
        LEAKAGE_FREE,
    ),
    "sensitivity": Entry(
        PHYSICAL,
        "sensitivity",
        "sensitivity:sensitivity_figure",
        "Which quantities decide the wear: Sobol indices, fall of R² when a quantity is shuffled, "
        "and the predicted wear with one quantity set.",
        LEAKAGE_FREE,
    ),
    "reach": Entry(
        PHYSICAL,
        "extrapolation and every target",
        "reach:reach_figure",
        "Models beyond the ranges that they learned from, and the R² of every wear measure and "
        "statistic.",
        LEAKAGE_FREE,
    ),
    "comparison": Entry(
        ALL_MODELS,
        "all models",
        "comparison:comparison_figure",
        "R² of all models on held-out cases: printed in the paper, by its steps on this data set "
        "(as published, optimistic), and leakage-free with intervals.",
        BOTH,
    ),
    "predictions": Entry(
        ALL_MODELS,
        "predictions of all models",
        "comparison:predictions_figure",
        "Predicted against simulated wear of the test rows for each model, both protocols.",
        BOTH,
    ),
    "verification": Entry(
        VERIFICATION,
        "verification",
        "verdicts:draw",
        "All checks of the last ``make verify``: which share of its tolerance each uses.",
    ),
    "speed": Entry(
        VERIFICATION,
        "performance of the engine",
        "speed:cost_figure",
        "Cost of a simulation: seconds for each simulated second against the particles present, "
        "by stepping and by other codes where they are installed, from the last run of "
        "``benchmarks/cost.py``.",
    ),
}
"""Figures in the order in which a text would show them."""


def groups() -> dict[str, dict[str, Entry]]:
    """Figures by group, in the order of `FIGURES`."""
    found: dict[str, dict[str, Entry]] = {}
    for name, entry in FIGURES.items():
        found.setdefault(entry.group, {})[name] = entry
    return found
