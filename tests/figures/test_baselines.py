"""Figures of the paper's models: print quality, named protocols, all models and features shown."""

import numpy as np
import pandas as pd
import pytest
from figure_checks import assert_fit_to_print, texts
from tables import product_law

from abradem.figures.comparison import comparison_figure, optimistic, predictions_figure
from abradem.figures.ga_ann import search_figure
from abradem.figures.pca import components_curve_figure, correlations_figure, loadings_figure
from abradem.figures.penalised import penalised_figure
from abradem.figures.residuals import residuals_figure
from abradem.figures.selection import selection_figure
from abradem.figures.trees import tree_curve_figure, tree_figure
from abradem.learning.baselines.ga_ann import fit_networks
from abradem.learning.baselines.genetic import Options
from abradem.learning.baselines.linear import fit_linear
from abradem.learning.baselines.pca import fit_pca
from abradem.learning.baselines.penalised import fit_penalised
from abradem.learning.baselines.selection import fit_selection
from abradem.learning.baselines.trees import fit_trees
from abradem.learning.comparison import beside_paper, compare, join_tables, with_scale
from abradem.learning.network import Training
from abradem.learning.rows import learning_table
from abradem.surrogate.groups import Jet
from abradem.words.labels import MODELS

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


class Learned:
    """Results of all baselines on one table."""

    def __init__(self, rows):
        frame = product_law(rows)
        table, shared = learning_table(frame), {"repeats": 3, "seed": 1}
        self.linear = fit_linear(frame, **shared)
        self.penalised = fit_penalised(table, path_points=12, **shared)
        self.principal = fit_pca(table, **shared)
        self.selection = fit_selection(table, **shared)
        self.trees = fit_trees(table, forest_trees=5, max_depth=12, **shared)
        options = Options(population=4, generations=3, max_neurons=20)
        quick = Training(2, 16)
        self.networks = {
            protocol: fit_networks(table, protocol, options, quick, quick, retrainings=3, repeats=3)
            for protocol in ("as_published", "leakage_free")
        }
        stages = [
            self.linear, self.penalised.results, self.principal.results, self.trees.results,
            *(result.results for result in self.networks.values()),
        ]  # fmt: skip
        self.scores = join_tables([stage.scores for stage in stages])
        self.predictions = join_tables([stage.predictions for stage in stages])
        self.comparison = compare(self.scores, with_scale(self.predictions, frame, JET), draws=200)

    def figures(self):
        networks = self.networks.values()
        pca, trees = self.principal, self.trees
        yield residuals_figure(self.linear.residuals, self.linear.coefficients, self.linear.summary)
        found = self.penalised
        yield penalised_figure(found.paths, found.validation, found.weights, found.summary)
        yield selection_figure(*self.selection)
        yield correlations_figure(pca.correlations, len(self.linear.residuals))
        yield loadings_figure(pca.loadings, pca.scree, pca.summary)
        yield components_curve_figure(pca.curve)
        yield tree_curve_figure(trees.curve, trees.importance, trees.summary)
        yield tree_figure(trees.nodes, trees.summary)
        yield search_figure(
            pd.concat([result.history for result in networks]),
            self.scores,
            {result.summary["protocol"]: result.summary for result in networks},
        )
        yield comparison_figure(self.comparison, beside_paper(self.comparison), "planted")
        yield predictions_figure(self.predictions, self.comparison)


NAMES = (
    "residuals", "penalised", "selection", "correlations", "loadings", "components", "tree_depth",
    "tree", "ga_ann", "comparison", "predictions",
)  # fmt: skip


@pytest.fixture(scope="module", params=[12, 90])
def figures(request):
    return dict(zip(NAMES, Learned(request.param).figures(), strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_figures_are_fit_to_print_and_name_their_protocol(figures, name):
    figure = figures[name]
    words = texts(figure).replace("\n", " ").lower()
    assert "leakage-free" in words or "both protocols" in words
    if name not in ("tree", "residuals", "correlations"):
        assert "as published" in words
    assert_fit_to_print(figure)


def test_heat_maps_show_every_pair(figures):
    """Each of X1 to X21 with each other, once."""
    shown = figures["correlations"].axes[0].images[0].get_array()
    assert shown.shape == (20, 20)
    known = np.isfinite(np.ma.filled(shown, np.nan))
    assert (known == np.tril(np.ones((20, 20), dtype=bool))).all()


def test_only_scores_above_the_leakage_free_ones_are_called_optimistic():
    beside = pd.DataFrame(
        {"model": ["ridge", "ga_ann"], "as_published_r2": [0.5, 0.9],
         "leakage_free_r2": [0.6, 0.8]}
    )  # fmt: skip
    assert optimistic(beside) == f"above leakage-free, hence optimistic: {MODELS['ga_ann']}; "
    assert optimistic(beside.assign(as_published_r2=0.1)) == ""


def test_every_model_is_compared(figures):
    labels = [tick.get_text() for tick in figures["comparison"].axes[0].get_yticklabels()]
    assert labels == [
        "least squares", "lasso", "ridge", "PCA, wrong target", "PCA regression",
        "decision tree", "random forest", "449-24-500-385 net", "GA-ANN",
    ]  # fmt: skip
    assert len(figures["predictions"].axes) == 8


def test_the_search_shows_every_network(figures):
    for panel in figures["ga_ann"].axes[:2]:
        assert len(panel.collections[0].get_offsets()) == 12


def test_legends_of_the_penalised_models_cover_no_bar(figures):
    figure = figures["penalised"]
    assert len(figure.legends) == 1
    assert all(panel.get_legend() is None for panel in figure.axes)


def test_residuals_are_drawn_as_they_were_computed():
    learned = fit_linear(product_law(90), repeats=1)
    panel = residuals_figure(learned.residuals, learned.coefficients, learned.summary).axes[1]
    shown = panel.collections[0].get_offsets()
    np.testing.assert_allclose(shown, learned.residuals[["normal_quantile", "studentised"]])


def test_a_score_below_the_axis_is_an_arrowhead_and_no_mark():
    comparison = pd.DataFrame(
        [
            ("linear", "leakage_free", "repeated splits", 20, -2.0, -9.0, -0.2),
            ("linear", "leakage_free", "fixed split", 1, 0.5, -3.0, 0.7),
            ("pca_wrong_target", "as_published", "fixed split", 1, -4.0, np.nan, np.nan),
        ],
        columns=["model", "protocol", "basis", "repeats", "r2", "r2_lower", "r2_upper"],
    ).assign(r2_log=0.5, r2_number=0.4)
    panel = comparison_figure(comparison, beside_paper(comparison), "t").axes[0]
    marks = [
        (line.get_marker(), float(line.get_xdata()[0]))
        for line in panel.lines
        if line.get_marker() in ("<", "o", "s", "^")
    ]
    # The axis is 1 - R2, which ends at 2.
    assert marks == [("<", 2.0)] * 2
    drawn = [line.get_xdata() for line in panel.lines if len(line.get_xdata()) == 2]
    assert any(np.allclose(ends, [2.0, 1.2]) for ends in drawn)
