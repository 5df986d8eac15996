"""All that a study makes of its data set, in one process: models, tables, figures and texts."""

import json
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pandas as pd

from abradem.config import load_config, setup_dict
from abradem.figures import comparison as of_comparison
from abradem.figures import (
    distributions,
    ga_ann,
    linear,
    pca,
    penalised,
    physical,
    reach,
    residuals,
    selection,
    sensitivity,
    trees,
)
from abradem.figures.architecture import draw as draw_architecture
from abradem.learning.baselines import ga_ann as networks
from abradem.learning.baselines.linear import train as train_linear
from abradem.learning.baselines.pca import train as train_pca
from abradem.learning.baselines.penalised import train as train_penalised
from abradem.learning.baselines.selection import train as train_selection
from abradem.learning.baselines.trees import train as train_trees
from abradem.learning.comparison import (
    beside_paper,
    compare,
    join_tables,
    number_scores,
    with_scale,
)
from abradem.learning.exponents import exponents_beside_published
from abradem.learning.network import Training
from abradem.learning.physical import distil
from abradem.learning.physical.intervals import Conformal, calibrate
from abradem.learning.physical.models import (
    BOOSTING,
    POWER_LAW,
    PROCESS,
    all_targets,
    fit_physical,
    makers,
)
from abradem.learning.physical.problem import problem
from abradem.learning.physical.reach import extrapolate, learning_curve
from abradem.learning.physical.sensitivity import (
    partial_dependence,
    permutation,
    sobol,
    verdict,
)
from abradem.learning.regions import error_by_region
from abradem.learning.rows import learning_table
from abradem.report import latex
from abradem.report.findings import findings, to_html
from abradem.report.readable import readable
from abradem.report.summary import study_summary
from abradem.report.tables import TABLES
from abradem.store.files import write_json
from abradem.surrogate.groups import Jet
from abradem.words.labels import MODELS

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
TARGET, NAME = "wear_total_mean", "small"
SPLITS = {"test_share": 0.2, "repeats": 3, "seed": 1}
FAMILIES = {"boosting": {"trees": 5}, "networks": {"members": 1, "hidden": (4,), "steps": 10}}
QUICK = Training(epochs=2, batch=8, learning_rate=1e-3)


def through_json(value, folder):
    """Plain data as another rule reads it: nan is None."""
    write_json(value, folder / "value.json")
    return json.loads((folder / "value.json").read_text())


def learned(table, folder):
    """Results of all learning stages of a data set, by stage, as the rules of the report get them.

    Parameters
    ----------
    table : DataFrame
        case_id, features and target.
    folder : path
        For temporary files.
    """
    found = {
        "linear": train_linear(table, TARGET, NAME, **SPLITS),
        "penalised": train_penalised(table, TARGET, NAME, path_points=6, fold_count=3, **SPLITS),
        "pca": train_pca(table, TARGET, NAME, fold_count=3, **SPLITS),
        "selection": train_selection(table, TARGET, NAME, **SPLITS),
        "trees": train_trees(table, TARGET, NAME, max_depth=4, forest_trees=4, fold_count=3,
                             **SPLITS),
    }  # fmt: skip
    options = networks.Options(population=2, generations=2, max_layers=3, max_neurons=12)
    for protocol in ("as_published", "leakage_free"):
        with mock.patch.object(networks, "NETWORK", (6, 5)):
            one = networks.fit_networks(
                learning_table(table, TARGET, NAME, 8), protocol, options, QUICK, QUICK,
                retrainings=2, repeats=3, seed=1,
            )  # fmt: skip
        found[f"ga_ann_{protocol}"] = {
            "history": one.history, "scores": one.results.scores,
            "predictions": one.results.predictions, "summary": one.summary,
        }  # fmt: skip
    given = problem(table, JET, TARGET, NAME, 8)
    models = makers(1, **FAMILIES)
    results, exponents, summary, _ = fit_physical(given, models, **SPLITS)
    found["physical"] = {
        "scores": results.scores, "predictions": results.predictions, "exponents": exponents,
        "summary": summary,
    }  # fmt: skip
    process = models[PROCESS]().fit(given.groups, given.log_number, given.error)
    intervals = calibrate(given, 3, 1)
    found["intervals"] = intervals._asdict()
    settings = distil.Settings(100, (4,), 1)
    scored = distil.evaluate_surrogate(given, settings, 0.2, 2, 1)
    description, arrays = distil.surrogate_of(
        given, process, Conformal.of(intervals.summary, intervals.scores), settings, scored, seed=1
    )
    found["surrogate"] = {
        "scores": scored.scores, "predictions": scored.predictions, "summary": description,
        "arrays": arrays,
    }  # fmt: skip
    indices = sobol(process, given, points=16, draws=5, seed=1)
    found["sensitivity"] = {
        "indices": indices, "falls": permutation(given, 0.2, 2, 1),
        "dependence": partial_dependence(process, given, 1), "summary": verdict(indices),
    }  # fmt: skip
    three = {name: models[name] for name in (POWER_LAW, PROCESS, BOOSTING)}
    two = {name: models[name] for name in (POWER_LAW, PROCESS)}
    found["reach"] = {
        "curve": learning_curve(given, three, **SPLITS),
        "extrapolation": extrapolate(given, three, 1),
        "targets": all_targets(table, JET, two, **SPLITS),
    }
    stages = [one for one in found.values() if "predictions" in one]
    scores, predictions = (
        join_tables([one[kind] for one in stages]) for kind in ("scores", "predictions")
    )
    predictions = with_scale(predictions, table, JET)
    scores = join_tables([scores, number_scores(predictions, NAME)])
    compared = compare(scores, predictions, draws=200)
    found["scores"] = {
        "scores": scores, "predictions": predictions, "comparison": compared,
        "beside_paper": beside_paper(compared), "by_region": error_by_region(predictions, table),
    }  # fmt: skip
    for one in found.values():
        one["summary"] = through_json(one.get("summary", {}), folder)
        if isinstance(one["summary"], list):
            one["summary"] = one["summary"][0]
    return {name: SimpleNamespace(**one) for name, one in found.items()}


def texts_of(table, found):
    """Findings, LaTeX, tables of the report and its summary, by name."""
    sensitivity_found, scored = found["sensitivity"], found["scores"]
    exponents = exponents_beside_published(table, TARGET, setup_dict(load_config({"study": NAME})))
    paragraphs = findings(
        found["physical"].summary, found["intervals"].summary, found["surrogate"].summary,
        sensitivity_found.summary, found["reach"].curve, found["reach"].extrapolation,
        sensitivity_found.indices, sensitivity_found.falls, scored.comparison, scored.by_region,
        exponents=exponents,
    )  # fmt: skip
    summary = study_summary(
        table, None, found["linear"].summary, scored.comparison, 0.95, "small.csv"
    )
    config = load_config({"study": NAME}).model_dump(mode="json")
    config["dataset"]["external"] = "small.csv"
    cited = latex.CitedResults(
        {
            latex.CONFIG: config, latex.DATASET: table, latex.SUMMARY: summary,
            latex.COMPARISON: scored.comparison, latex.BESIDE: scored.beside_paper,
            latex.EXPONENTS: exponents, latex.SCORES: scored.scores,
            latex.SELECTION: found["selection"].selection,
            **{file: found[f"ga_ann_{protocol}"].summary
               for protocol, file in latex.NETWORKS.items()},
        }
    )  # fmt: skip
    shown = {
        "linear_coefficients": found["linear"].coefficients,
        "linear_published": found["linear"].published,
        "penalised_weights": found["penalised"].weights,
        "selection": found["selection"].selection,
        "scores": scored.scores,
        "comparison": scored.comparison,
        "beside_paper": scored.beside_paper,
        "error_by_region": scored.by_region,
        "power_law": found["physical"].exponents,
        "exponents": exponents,
        "targets": found["reach"].targets,
        "extrapolation": found["reach"].extrapolation,
        "sobol": sensitivity_found.indices,
        "calibration": found["intervals"].calibration,
        "coverage": found["intervals"].regions,
    }
    assert set(shown) == set(TABLES) - {"dataset", "failures", "fresh_coverage"}
    return {
        "findings": to_html("Models", paragraphs),
        "numbers": latex.numbers_tex(latex.study_numbers(cited), NAME),
        "quantities": latex.quantities_tex(cited, NAME),
        "features": latex.features_tex(cited, NAME),
        "exponents_tex": latex.exponents_tex(cited, NAME),
        "models": latex.models_tex(cited, MODELS, NAME),
        "equation": found["linear"].summary["equation"],
        "notes": " ".join(found["linear"].summary["notes"]),
        "equation_tex": found["physical"].summary["equation_tex"],
        **{name: readable(one).to_csv(index=False) for name, one in shown.items()},
    }


def figures_of(table, found):
    """All figures of the models, by name."""
    scored, sensed = found["scores"], found["sensitivity"]
    summaries = [found[f"ga_ann_{name}"].summary for name in ("as_published", "leakage_free")]
    histories, marks = (
        [getattr(found[f"ga_ann_{name}"], kind) for name in ("as_published", "leakage_free")]
        for kind in ("history", "scores")
    )
    one, of_pca, of_trees = found["linear"], found["pca"], found["trees"]
    lasso = found["penalised"]
    yield "coefficients", linear.coefficients_figure(one.coefficients, one.summary)
    yield "predicted", linear.predicted_figure(one.predictions, one.summary)
    yield "residuals", residuals.residuals_figure(one.residuals, one.coefficients, one.summary)
    yield (
        "penalised",
        penalised.penalised_figure(lasso.paths, lasso.validation, lasso.weights, lasso.summary),
    )
    yield (
        "selection",
        selection.selection_figure(found["selection"].selection, found["selection"].summary),
    )
    yield "correlations", pca.draw_correlations(of_pca.correlations, one.summary)
    yield "loadings", pca.loadings_figure(of_pca.loadings, of_pca.scree, of_pca.summary)
    yield "components", pca.components_curve_figure(of_pca.curve)
    yield "tree", trees.tree_figure(of_trees.nodes, of_trees.summary)
    yield (
        "tree_depth",
        trees.tree_curve_figure(of_trees.curve, of_trees.importance, of_trees.summary),
    )
    yield "ga_ann", ga_ann.draw(histories, marks, summaries)
    yield "architecture", draw_architecture(summaries)
    yield "distributions", distributions.draw(table, scored.predictions, TARGET, "ga_ann")
    yield "models", physical.models_figure(
        scored.comparison, found["intervals"].calibration, found["reach"].curve, None, NAME,
    )  # fmt: skip
    yield "power_law", physical.power_law_figure(found["physical"].exponents, NAME)
    yield (
        "sensitivity",
        sensitivity.sensitivity_figure(sensed.indices, sensed.falls, sensed.dependence, NAME),
    )
    yield "reach", reach.reach_figure(found["reach"].extrapolation, found["reach"].targets, NAME)
    yield (
        "comparison",
        of_comparison.comparison_figure(scored.comparison, scored.beside_paper, NAME),
    )
    yield "predictions", of_comparison.predictions_figure(scored.predictions, scored.comparison)


def two_varied(n, *names, seed=0, noise=0.05):
    """Rows in which only the named quantities vary, with a known law and noise."""
    from tables import drawn

    from abradem.quantities import SAMPLED

    middle = {row.name: sum(row.paper_range) / 2.0 for row in SAMPLED if row.name not in names}
    rows = drawn(n, seed, **middle)
    wear = (
        3e6
        * rows["archard_constant"]
        * (rows["particle_velocity_y"] ** 2 + 5.0)
        * (1.0 + rows["plate_angle"] / 40.0)
    )
    scatter = np.exp(noise * np.random.default_rng(seed + 1).standard_normal(n))
    return pd.DataFrame(rows).assign(**{TARGET: wear * scatter})
