"""Bands of the coverage by region against closed forms, and planted good and bad intervals."""

import numpy as np
import pytest
from scipy import stats
from tables import product_law

from abradem.learning.physical.fresh import EVERYWHERE
from abradem.learning.physical.problem import problem
from abradem.learning.physical.region_coverage import (
    band,
    coverage_by_region,
    faultless,
    faultless_in_folds,
    faultless_on_new,
    joint_summary,
    p_values,
    with_joint_bands,
)
from abradem.learning.regions import regions_of
from abradem.surrogate.groups import Jet
from abradem.surrogate.model import conformal_quantile

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
LEVELS = (0.5, 0.8, 0.95)
KNOWN = 200


@pytest.fixture(scope="module")
def inputs():
    return problem(product_law(200, seed=3), JET).inputs


@pytest.fixture(scope="module")
def regions(inputs):
    return regions_of(inputs)


@pytest.fixture(scope="module")
def joint(inputs, regions):
    return faultless(faultless_on_new(KNOWN, len(inputs)), LEVELS, inputs, regions)


def verdict_on(scores, known, inputs, regions, joint):
    """Verdict on intervals that rest on ``known`` scores, for new rows with other scores."""
    inside = {level: scores <= conformal_quantile(known, level) for level in LEVELS}
    table = with_joint_bands(coverage_by_region(inside, inputs, regions), joint)
    return joint_summary(table, joint)


def test_the_p_value_is_twice_the_smaller_tail_of_the_binomial_distribution():
    np.testing.assert_allclose(p_values(2, 0.5), [0.5, 1.0, 0.5])
    for count, p_value in enumerate(p_values(17, 0.8)):
        chances = stats.binom.pmf(np.arange(18), 17, 0.8)
        tails = chances[: count + 1].sum(), chances[count:].sum()
        assert p_value == pytest.approx(min(1.0, 2.0 * min(tails)))


def test_of_separate_regions_and_known_quantiles_the_chances_are_products(inputs, regions):
    """With quantiles from very many scores the numbers inside are independent and binomial."""
    apart = regions[:4]
    found = faultless(faultless_on_new(100_000, len(inputs)), (0.8,), inputs, apart)
    sizes = [int(region.holds(inputs).sum()) for region in apart]
    in_band, all_in, all_beyond = 0.0, 1.0, 1.0
    for size in sizes:
        chances = stats.binom.pmf(np.arange(size + 1), size, 0.8)
        share, (low, high) = np.arange(size + 1) / size, band(size, 0.8)
        in_band += chances[(share >= low - 1e-9) & (share <= high + 1e-9)].sum()
        all_in *= chances[p_values(size, 0.8) >= found.p_value].sum()
        all_beyond *= chances[p_values(size, 0.8) > found.p_value].sum()
    assert found.expected == pytest.approx(in_band, abs=0.03)
    # The p value is the largest with which 95 % of the tests are in; numbers inside are whole.
    assert all_in > 0.94 and all_beyond < 0.96


@pytest.mark.parametrize("trained", [60, 200, 5000])
def test_the_shares_of_faultless_intervals_follow_the_beta_binomial_law(inputs, trained):
    """The number of new rows inside an interval that ends at the r-th of n errors is beta-binomial
    with r and n + 1 - r (Vovk 2012): its chance to be in the binomial band is a closed form."""
    chance = 0.0
    for level in LEVELS:
        rank = np.ceil((trained + 1) * level - 1e-9)
        low, high = (round(200 * end) for end in band(200, level))
        inside = stats.betabinom(200, rank, trained + 1 - rank)
        chance += inside.cdf(high) - inside.cdf(low - 1)
    found = faultless(faultless_on_new(trained, len(inputs)), LEVELS, inputs, [EVERYWHERE])
    # At most 3 shares of one band each, over 2000 draws.
    assert found.expected == pytest.approx(chance, abs=4.0 * 1.5 / np.sqrt(2000))


def test_a_region_without_rows_has_no_shares(inputs, regions):
    flat = inputs[regions[0].holds(inputs)]
    held = sum(region.holds(flat).any() for region in regions)
    assert held < len(regions)
    found = faultless(faultless_on_new(KNOWN, len(flat)), LEVELS, flat, regions)
    assert 2 * held < found.expected <= 3 * held


def test_joint_bands_hold_all_shares_of_faultless_intervals_and_single_bands_do_not(
    inputs, regions, joint
):
    rng = np.random.default_rng(7)
    whole, single, in_band = 0, 0, []
    for _ in range(200):
        known, scores = np.sort(rng.random(KNOWN)), rng.random(len(inputs))
        verdict = verdict_on(scores, known, inputs, regions, joint)
        whole += verdict["in_joint"] == verdict["shares"] == 24
        single += verdict["in_band"] == 24
        in_band.append(verdict["in_band"])
    # 95 of 100, within three standard errors of 200 draws.
    assert 0.90 * 200 <= whole <= 0.995 * 200
    assert single < 0.65 * 200
    assert np.mean(in_band) == pytest.approx(joint.expected, abs=0.5)


@pytest.mark.parametrize("planted", ["flat plates", "all"])
def test_intervals_that_are_too_short_are_found(inputs, regions, joint, planted):
    rng = np.random.default_rng(8)
    flat = regions[0].holds(inputs)
    errors = np.where(flat, 3.0, 1.0) if planted == "flat plates" else np.full(len(inputs), 1.5)
    found = 0
    for _ in range(50):
        known = np.sort(np.abs(rng.standard_normal(KNOWN)))
        scores = errors * np.abs(rng.standard_normal(len(inputs)))
        verdict = verdict_on(scores, known, inputs, regions, joint)
        found += verdict["in_joint"] < verdict["shares"]
    assert found >= 45


def test_of_rows_that_calibrate_one_another_the_overall_share_is_nearly_the_level():
    fold = np.arange(200) % 10
    rng = np.random.default_rng(9)
    spread = {}
    for agreement in (0.0, 0.9, 1.0):
        draw = faultless_in_folds(fold, agreement)
        shares = np.array([draw(rng, LEVELS).mean(axis=1) for _ in range(300)])
        np.testing.assert_allclose(shares.mean(axis=0), LEVELS, atol=0.015)
        spread[agreement] = shares[:, 0].std()
    # Independent scores of rows and quantiles: twice the variance of a binomial share.
    assert spread[0.0] == pytest.approx(np.sqrt(2.0 * 0.25 / 200), rel=0.2)
    assert spread[1.0] < 0.2 * spread[0.0] < spread[0.9] < 0.7 * spread[0.0]


def test_joint_bands_contain_the_binomial_ones(inputs, regions, joint):
    inside = {level: np.arange(len(inputs)) < level * len(inputs) for level in LEVELS}
    table = with_joint_bands(coverage_by_region(inside, inputs, regions), joint)
    assert (table["joint_lower"] <= table["band_lower"]).all()
    assert (table["joint_upper"] >= table["band_upper"]).all()
    assert (table["joint_lower"] < table["band_lower"]).any()
    within = table["coverage"].between(table["joint_lower"], table["joint_upper"])
    assert (table["in_joint"] == within).all()


def test_without_regions_or_levels_nothing_is_out_of_its_band(inputs, regions):
    draw = faultless_on_new(KNOWN, len(inputs))
    for levels, of in ((LEVELS, []), ((), regions)):
        none = faultless(draw, levels, inputs, of)
        table = coverage_by_region(
            {level: np.ones(len(inputs), bool) for level in levels}, inputs, of
        )
        table = with_joint_bands(table, none)
        assert joint_summary(table, none) == {
            "shares": 0, "in_band": 0, "expected": 0.0, "in_joint": 0
        }  # fmt: skip


def test_the_same_seed_gives_the_same_bands(inputs, regions, joint):
    again = faultless(faultless_on_new(KNOWN, len(inputs)), LEVELS, inputs, regions)
    assert again == joint
