"""Estimated computing times agree with measured ones, and affect no result."""

from pathlib import Path

import numpy as np
import pytest

from abradem.config import read_config, sampled_ranges, setup_dict
from abradem.sampling.cost import batch_seconds, case_seconds, contact_time, simulated_time
from abradem.sampling.draw import block_cases

ROOT = Path(__file__).parents[2]


def study(*overrides):
    """Cases of the blocks 0 and 1 of a study, and its set-up as plain values."""
    config = read_config(ROOT / "config.yaml", *(ROOT / "studies" / name for name in overrides))
    sampling = config.sampling
    blocks = [
        block_cases(
            config.seed, block, sampling.cases_per_block, sampling.method, sampled_ranges(config)
        )
        for block in range(2)
    ]
    return blocks, setup_dict(config)


@pytest.fixture(scope="module")
def paper():
    return study()


@pytest.fixture(scope="module")
def dilute():
    return study("dilute.yaml")


PAPER = {
    89: 71.0, 27: 57.0, 141: 37.0, 66: 15.0, 64: 10.0, 160: 7.0, 70: 5.9, 51: 3.5, 199: 2.7,
    135: 2.4, 129: 0.21, 26: 0.083, 114: 0.040, 175: 0.022, 59: 0.009,
}  # fmt: skip
DILUTE = {
    33: 69.0, 140: 28.0, 89: 10.0, 99: 8.0, 67: 2.4, 19: 1.9, 66: 1.3, 199: 1.2, 160: 0.85,
    122: 0.84, 32: 0.71, 88: 0.69, 77: 0.082, 0: 0.037, 16: 0.024, 93: 0.022, 73: 0.013,
}  # fmt: skip
"""Computing times of single cases, s, from the most expensive to the cheapest, by ``case_id``."""


@pytest.mark.parametrize(
    ("overrides", "measured", "spread"), [((), PAPER, 1.6), (("dilute.yaml",), DILUTE, 2.2)]
)
def test_estimates_of_single_cases_are_near_the_measured_times(overrides, measured, spread):
    blocks, setup = study(*overrides)
    guess = np.concatenate([case_seconds(cases, setup) for cases in blocks])[list(measured)]
    seconds = np.array(list(measured.values()))
    ratio = np.log(guess / seconds)
    assert ratio.std() < np.log(spread)
    assert np.abs(ratio).max() < 2.5 * np.log(spread)
    assert guess.sum() == pytest.approx(seconds.sum(), rel=0.5)


@pytest.mark.parametrize(("overrides", "measured"), [((), 828.0), (("dilute.yaml",), 138.0)])
def test_the_estimate_of_a_study_is_within_a_factor_of_one_and_a_half(overrides, measured):
    blocks, setup = study(*overrides)
    guess = np.concatenate([case_seconds(cases, setup) for cases in blocks])
    assert measured / 1.5 < guess.sum() < measured * 1.5
    # The two that took half to two thirds of all the time in both studies.
    assert {33, 140} <= set(np.argsort(guess)[-2:])


def changed(blocks, setup, **values):
    """Estimate (s) of the first case with other values of some quantities."""
    return case_seconds(blocks[0].iloc[:1].assign(**values), setup)[0]


def test_beds_small_particles_and_crowded_jets_take_long(paper, dilute):
    base = {
        "particle_radius": 0.01, "plate_angle": 10.0, "particle_velocity_y": -1.0,
        "restitution": 0.4,
    }  # fmt: skip
    known = changed(*paper, **base)
    assert known > 3.0 * changed(*paper, **{**base, "plate_angle": 40.0})
    assert known > 2.0 * changed(*paper, **{**base, "particle_velocity_y": -9.0})
    # In a crowded jet others take the speed of a particle whatever the restitution.
    elastic = {**base, "restitution": 0.7}
    assert 1.2 * changed(*paper, **elastic) < known < 2.0 * changed(*paper, **elastic)
    assert changed(*dilute, **base) > 2.0 * changed(*dilute, **elastic)
    assert known < changed(*paper, **{**base, "particle_radius": 0.005}) / 4.0
    assert known > 4.0 * changed(*dilute, **base)


def test_a_bed_holds_at_most_what_was_released(paper):
    """If no particle leaves, those released are present for half of the time on average."""
    blocks, setup = paper
    level = blocks[0].assign(plate_angle=0.0, particle_velocity_y=0.0, particle_radius=0.005)
    assert (contact_time(level, setup) < 0.5 * simulated_time(level, setup)).all()
    slow = contact_time(level, {**setup, "gravity": 1e-6})
    assert slow == pytest.approx(0.5 * simulated_time(level, setup), rel=0.35)


def test_the_window_holds_the_particles_that_the_error_asks_for(paper, dilute):
    blocks, setup = paper
    assert simulated_time(blocks[0], setup) == pytest.approx(setup["window"] + 0.5, abs=0.6)
    blocks, setup = dilute
    large = blocks[0].assign(particle_radius=0.03, particle_density=3000.0, plate_angle=60.0)
    # 4 kg/s are 11.8 particles a second; 0.12 / 0.02^2 = 300 of them are asked for.
    assert simulated_time(large, setup) == pytest.approx(300.0 / 11.8 + 0.5, rel=0.1)
    assert (simulated_time(blocks[0], {**setup, "target_stderr": 1e-3}) == 60.0).all()


def test_extreme_cases_have_a_finite_positive_estimate(paper):
    blocks, setup = paper
    odd = blocks[0].assign(restitution=1.0, rolling_friction=0.0, particle_velocity_y=0.0)
    for changes in ({}, {"gravity": 0.0}, {"number_rate": 1e-3, "mass_rate": None}):
        seconds = case_seconds(odd, {**setup, **changes})
        assert np.isfinite(seconds).all() and (seconds > 0.0).all()


def test_a_batch_takes_the_times_of_its_cases(paper):
    blocks, setup = paper
    batches = [(0, 30), (30, 60), (60, 100)]
    total = case_seconds(blocks[0], setup)
    assert batch_seconds(blocks[0], setup, batches) == [
        list(total[start:stop]) for start, stop in batches
    ]
