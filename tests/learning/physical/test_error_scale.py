"""Error scale: it finds a planted dependence, and intervals then hold in every region."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize
from tables import product_law

from abradem.learning.physical.error_scale import (
    FREEDOM,
    PRIOR,
    ErrorScale,
    cross_fitted,
    fit_scale,
)
from abradem.learning.physical.intervals import HeldOut, conformal_of
from abradem.learning.physical.noise_terms import ERROR_TERMS, error_terms, noise_terms
from abradem.learning.physical.problem import problem
from abradem.learning.physical.region_coverage import band, coverage_by_region
from abradem.learning.regions import regions_of
from abradem.learning.rows import standard_scaler
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import GROUP_NAMES, Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
PLANTED = {"flat_plate": 0.6, "gentle_slope": 0.5, "log_froude": -0.4, "log_size": 0.3}


def cases(n, seed):
    """Cases without noise, and the planted scale of their errors."""
    given = problem(product_law(n, 0.0, seed), JET)
    found = error_terms(given.groups)
    reference = error_terms(problem(product_law(4000, 0.0, 9), JET).groups)
    z = (found - reference.mean(axis=0)) / reference.std(axis=0)
    return given, np.exp(z @ [PLANTED[name] for name in ERROR_TERMS])


def scores_of(scale, seed):
    """Held-out scores with this scale: absolute values of errors with Student's distribution."""
    return scale * np.abs(np.random.default_rng(seed).standard_t(FREEDOM, len(scale)))


def test_the_terms_are_their_formulas():
    """Written out for angles of both signs, a wall and a plate at the middle slope."""
    given = problem(product_law(5, 0.0, 1), JET)
    groups = given.groups.copy()
    column = GROUP_NAMES.index("plate_angle")
    middle = math.atan(0.3)
    groups[:, column] = [0.0, middle, -middle, 0.5 * math.pi, 1.0]
    u = math.tan(1.0) / 0.3
    errors = error_terms(groups)
    np.testing.assert_allclose(
        errors[:, 0], [1, 1 / math.e, 1 / math.e, 0, math.exp(-u)], atol=1e-9
    )
    np.testing.assert_allclose(errors[:, 1], [0, 1, 1, 0, u * math.exp(1 - u)], atol=1e-9)
    noise = noise_terms(groups)
    flat = [1, math.exp(-2), math.exp(-2), 0, math.exp(-math.tan(1.0) / 0.15)]
    np.testing.assert_allclose(noise[:, 0], flat, atol=1e-9)
    for found in (errors, noise):
        np.testing.assert_array_equal(found[:, -2], groups[:, GROUP_NAMES.index("log_froude")])
        np.testing.assert_array_equal(found[:, -1], groups[:, GROUP_NAMES.index("log_size")])


def test_intervals_hold_on_gentle_slopes_where_errors_are_largest():
    """A bed slides or stays there: errors 3.7 times those of steep, 2.1 those of flat plates.

    The shares inside 80 % intervals are means over six sets of 200 cases to learn from.
    """

    def with_bump(n, seed):
        given = problem(product_law(n, 0.0, seed), JET)
        angle = given.inputs[:, SAMPLED_NAMES.index("plate_angle")]
        u = np.tan(np.radians(angle)) / 0.3
        return given, angle, np.exp(0.55 * np.exp(-u) + 1.1 * u * np.exp(1.0 - u))

    fresh, angle, fresh_scale = with_bump(4000, 30)
    new = scores_of(fresh_scale, 31)
    places = (angle < 12.0, (angle >= 12.0) & (angle < 20.0), angle >= 50.0)
    local, one_width = [], []
    for seed in range(6):
        trained, _, scale = with_bump(200, 40 + seed)
        observed = HeldOut(
            np.arange(200) % 5, np.zeros(200), np.ones(200), scores_of(scale, 50 + seed)
        )
        half = conformal_of(trained, np.arange(200), observed).half(fresh.groups, 0.8)
        local.append([(new <= half)[place].mean() for place in places])
        one = np.quantile(observed.score, 0.8)
        one_width.append([(new <= one)[place].mean() for place in places])
    np.testing.assert_allclose(np.mean(local, axis=0), 0.8, atol=0.06)
    _, gentle, steep = np.mean(one_width, axis=0)
    assert gentle < 0.7 and steep > 0.87


def test_a_planted_scale_is_found():
    given, scale = cases(4000, 9)
    found = fit_scale(scores_of(scale, 1), given.groups)
    np.testing.assert_allclose(found.weights, list(PLANTED.values()), atol=0.05)
    assert np.median(found.at(given.groups) / scale) == pytest.approx(1.0, rel=0.05)


def test_the_fit_is_the_minimum_of_its_loss():
    given, scale = cases(60, 2)
    scores = scores_of(scale, 3)
    found = fit_scale(scores, given.groups)
    z = standard_scaler(error_terms(given.groups)).forward(error_terms(given.groups))

    def loss(w):
        scale = np.exp(w[0] + z @ w[1:])
        density = stats.t.logpdf(scores, FREEDOM, scale=scale)
        return -np.sum(density) - np.sum(stats.norm.logpdf(w[1:], scale=PRIOR))

    best = minimize(loss, np.zeros(5), method="Nelder-Mead",
                    options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 10_000}).x  # fmt: skip
    np.testing.assert_allclose([found.constant, *found.weights], best, atol=1e-5)


def test_a_scale_is_restored_from_its_description():
    given, scale = cases(50, 4)
    found = fit_scale(scores_of(scale, 5), given.groups)
    again = ErrorScale.of(found.describe())
    np.testing.assert_array_equal(again.at(given.groups), found.at(given.groups))


def test_without_dependence_the_scale_is_nearly_constant_and_wild_rows_do_not_bend_it():
    given, scale = cases(200, 6)
    scores = scores_of(np.ones_like(scale), 7)
    scores[:2] = 30.0
    found = fit_scale(scores, given.groups).at(given.groups)
    assert found.max() / found.min() < 2.0
    # Scores of 0, and a term that all rows share, are no trouble.
    level = given.groups.copy()
    level[:, 8] = 0.3
    flat = fit_scale(np.zeros(200), level)
    assert (flat.weights[:2] == 0.0).all() and np.isfinite(flat.at(level)).all()


def test_the_scale_of_a_row_does_not_know_its_score():
    given, scale = cases(80, 8)
    scores, fold = scores_of(scale, 9), np.arange(80) % 5
    before = cross_fitted(scores, given.groups, fold)
    scores[fold == 2] *= 100.0
    after = cross_fitted(scores, given.groups, fold)
    np.testing.assert_array_equal(before[fold == 2], after[fold == 2])
    assert (before[fold != 2] != after[fold != 2]).all()


def test_intervals_hold_in_every_region_where_those_of_one_width_do_not():
    trained, scale = cases(300, 10)
    fresh, fresh_scale = cases(2000, 11)
    rows = np.arange(300)
    observed = HeldOut(rows % 5, np.zeros(300), np.ones(300), scores_of(scale, 12))
    local = conformal_of(trained, rows, observed)
    new = scores_of(fresh_scale, 13)
    one_width = np.quantile(observed.score, 0.8)
    regions = regions_of(trained.inputs)
    covered = {
        name: coverage_by_region({0.8: new <= half}, fresh.inputs, regions)
        for name, half in (("local", local.half(fresh.groups, 0.8)), ("one", one_width))
    }
    assert len(covered["local"]) == 8 and covered["local"]["tested"].sum() == 3 * 2000
    away = {name: (table["coverage"] - 0.8).abs() for name, table in covered.items()}
    assert away["local"].max() < 0.12 < 0.25 < away["one"].max()


def test_regions_divide_the_cases_and_leave_out_what_was_held_fixed():
    given = problem(product_law(100), JET)
    regions = regions_of(given.inputs)
    assert [one.name for one in regions] == [
        "below 12 deg", "12 to 20 deg", "20 to 50 deg", "above 50 deg", "slow", "fast", "small",
        "large",
    ]  # fmt: skip
    for part in (regions[:4], regions[4:6], regions[6:]):
        np.testing.assert_array_equal(sum(one.holds(given.inputs).astype(int) for one in part), 1)
    angle = given.inputs[:, SAMPLED_NAMES.index("plate_angle")]
    np.testing.assert_array_equal(regions[1].holds(given.inputs), (angle >= 12.0) & (angle < 20.0))
    fixed = given.inputs.copy()
    fixed[:, SAMPLED_NAMES.index("plate_angle")] = 30.0
    assert [one.name for one in regions_of(fixed)] == ["slow", "fast", "small", "large"]


def test_the_band_of_a_coverage_is_binomial():
    ends = np.rint(100.0 * np.array(band(100, 0.8)))
    # Each tail holds at most 2.5 %, and more with one row more.
    below, above = stats.binom.cdf(ends - [1, 0], 100, 0.8)
    assert below <= 0.025 and 1.0 - above <= 0.025
    assert stats.binom.cdf(ends[0], 100, 0.8) > 0.025
    assert stats.binom.sf(ends[1] - 1, 100, 0.8) > 0.025
    table = coverage_by_region(
        {0.5: np.arange(100) < 50}, problem(product_law(100), JET).inputs, []
    )
    assert table.empty and "in_band" in table
