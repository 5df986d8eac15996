"""Figures of the models on dimensionless groups: print quality, complete content."""

import numpy as np
import pytest
from figure_checks import assert_fit_to_print, texts
from tables import product_law

from abradem.figures.physical import models_figure, power_law_figure
from abradem.figures.reach import reach_figure
from abradem.figures.sensitivity import sensitivity_figure
from abradem.learning.comparison import compare, with_scale
from abradem.learning.physical.intervals import calibrate
from abradem.learning.physical.models import POWER_LAW, PROCESS, all_targets, fit_physical, makers
from abradem.learning.physical.problem import problem
from abradem.learning.physical.reach import extrapolate, learning_curve
from abradem.learning.physical.sensitivity import partial_dependence, permutation, sobol
from abradem.surrogate.groups import Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
NOISE = {"cases": 10, "replicates": 90, "r2_floor": 0.9999, "r2_floor_band": [0.9998, 0.99993]}


def figures(rows):
    frame = product_law(rows)
    given = problem(frame, JET)
    hasty = {"boosting": {"trees": 5}, "networks": {"members": 1, "hidden": (8,), "steps": 20}}
    models = makers(1, **hasty)
    results, exponents, _, _ = fit_physical(given, models, repeats=2)
    two = {name: models[name] for name in (POWER_LAW, PROCESS)}
    process = models[PROCESS]().fit(given.groups, given.log_number, given.error)
    calibration = calibrate(given, 3).calibration
    indices = sobol(process, given, points=32, draws=5)
    comparison = compare(results.scores, with_scale(results.predictions, frame, JET), draws=100)
    curve = learning_curve(given, two, repeats=2)
    for noise in (NOISE, None, {**NOISE, "r2_floor": None}):
        yield models_figure(comparison, calibration, curve, noise, "t")
    yield sensitivity_figure(
        indices, permutation(given, repeats=1), partial_dependence(process, given), "t"
    )
    yield reach_figure(extrapolate(given, two), all_targets(frame, JET, two, repeats=2), "t")
    yield power_law_figure(exponents, "t")


@pytest.fixture(scope="module", params=[90, 12])
def drawn(request):
    return list(figures(request.param))


def test_the_figures_are_fit_to_print(drawn):
    for figure in drawn:
        assert_fit_to_print(figure)


def test_every_model_and_every_quantity_is_named(drawn):
    page, _, _, sensitivity, *_ = drawn
    words = texts(page)
    for name in ("power law", "network ensemble", "boosting", "Gaussian process", "noise floor"):
        assert name in words
    words = texts(sensitivity)
    assert all(name in words for name in ("Archard", "plate angle", "velocity", "radius"))


def test_coverage_is_drawn_where_it_lies(drawn):
    panel = drawn[0].axes[1]
    levels, coverage = panel.lines[1].get_data()
    assert np.all((0.0 <= np.asarray(coverage)) & (np.asarray(coverage) <= 100.0))
    assert levels[0] == pytest.approx(5.0)
