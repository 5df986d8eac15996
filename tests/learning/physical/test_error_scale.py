"""Error scale: it finds a planted dependence, and intervals then hold in every region."""

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
from abradem.learning.physical.noise_terms import TERMS, terms
from abradem.learning.physical.problem import problem
from abradem.learning.physical.region_coverage import band, coverage_by_region
from abradem.learning.regions import regions_of
from abradem.learning.rows import standard_scaler
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
PLANTED = {"flatness": 0.8, "log_froude": -0.4, "log_size": 0.3}


def cases(n, seed):
    """Cases without noise, and the planted scale of their errors."""
    given = problem(product_law(n, 0.0, seed), JET)
    found = terms(given.groups)
    reference = terms(problem(product_law(4000, 0.0, 9), JET).groups)
    z = (found - reference.mean(axis=0)) / reference.std(axis=0)
    return given, np.exp(z @ [PLANTED[name] for name in TERMS])


def scores_of(scale, seed):
    """Held-out scores with this scale: absolute values of errors with Student's distribution."""
    return scale * np.abs(np.random.default_rng(seed).standard_t(FREEDOM, len(scale)))


def test_a_planted_scale_is_found():
    given, scale = cases(4000, 9)
    found = fit_scale(scores_of(scale, 1), given.groups)
    np.testing.assert_allclose(found.weights, list(PLANTED.values()), atol=0.05)
    assert np.median(found.at(given.groups) / scale) == pytest.approx(1.0, rel=0.05)


def test_the_fit_is_the_minimum_of_its_loss():
    given, scale = cases(60, 2)
    scores = scores_of(scale, 3)
    found = fit_scale(scores, given.groups)
    z = standard_scaler(terms(given.groups)).forward(terms(given.groups))

    def loss(w):
        scale = np.exp(w[0] + z @ w[1:])
        density = stats.t.logpdf(scores, FREEDOM, scale=scale)
        return -np.sum(density) - np.sum(stats.norm.logpdf(w[1:], scale=PRIOR))

    best = minimize(loss, np.zeros(4), method="Nelder-Mead",
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
    assert flat.weights[0] == 0.0 and np.isfinite(flat.at(level)).all()


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
