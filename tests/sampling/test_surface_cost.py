"""Estimated computing times of cases on geometries, beside measured ones and by hand."""

from pathlib import Path

import pytest

from abradem.config import geometry_ranges, read_config, sampled_ranges, setup_dict
from abradem.running.effort import estimate
from abradem.sampling.cost import STEP, case_seconds
from abradem.sampling.draw import block_cases
from abradem.sampling.surface_cost import PASSING, STIRRED, presence

ROOT = Path(__file__).parents[2]


def study(name):
    """Cases of a study, its set-up as plain values, and its configuration."""
    config = read_config(ROOT / "config.yaml", ROOT / "studies" / f"{name}.yaml")
    sampling = config.sampling
    cases = block_cases(
        config.seed, 0, sampling.cases_per_block, sampling.method, sampled_ranges(config),
        geometry=geometry_ranges(config),
    )  # fmt: skip
    return cases, setup_dict(config), config


MEASURED = {"two_plates": 2.8, "curved_chute": 1.5, "chute_stl": 0.19}
"""Processor times of all cases of a study, s."""


@pytest.fixture(autouse=True)
def in_root(monkeypatch):
    # The mesh of a study is named from there.
    monkeypatch.chdir(ROOT)


@pytest.mark.parametrize("name", MEASURED)
def test_the_estimate_is_within_a_factor_of_one_and_a_half_of_measured_times(name):
    cases, setup, _ = study(name)
    assert 1.0 / 1.5 < case_seconds(cases, setup).sum() / MEASURED[name] < 1.5


def test_a_particle_stays_in_a_screw_until_it_is_conveyed_out():
    """From a pitch before the closed end, 0.3 m, by a pitch of 0.1 m in each turn."""
    cases, setup, _ = study("screw")
    dwell, share = presence(cases, setup)
    stays = 0.3 / (0.1 * cases["screw_revolutions"].to_numpy() / 60.0)
    assert dwell == pytest.approx(stays) and (share == STIRRED).all()
    # All that are present, 140 more a second until as many leave, in steps of 6.37 us.
    present = 0.45 / 3.217e-3 * (0.5 * stays**2 + 3.0 * stays)
    expected = present / 6.37e-6 * STIRRED * STEP
    assert case_seconds(cases, setup) == pytest.approx(expected, rel=0.02)


def test_a_full_screw_costs_what_was_measured():
    """467 particles of the study's size took 10 s for a simulated second."""
    assert 467 / 6.37e-6 * STIRRED * STEP == pytest.approx(10.0, rel=0.1)


def test_a_particle_passes_a_chute_on_its_fall():
    """The diagonal of chute and factory at the mean of the speeds of the release and the end."""
    cases, setup, _ = study("chute_stl")
    dwell, share = presence(cases.assign(particle_velocity_y=-4.0), setup)
    fast = (16.0 + 2.0 * 9.81 * 1.0) ** 0.5
    diagonal = (0.6**2 + 1.179**2 + 0.4**2) ** 0.5
    assert dwell[0] == pytest.approx(diagonal / (0.5 * (4.0 + fast)), rel=1e-3)
    assert (share == PASSING).all()


def test_a_case_that_cannot_be_simulated_costs_little():
    cases, setup, _ = study("chute_stl")
    aside = {**setup, "geometry": {**setup["geometry"], "centre": [9.0, 1.0, 9.0]}}
    assert (case_seconds(cases, aside) < 0.02).all()


def test_the_line_of_a_run_says_what_a_screw_takes():
    assert "simulated in about 2 min on 2 cores" in estimate(study("screw")[2], 2)
    assert "simulated in about 5 s on 2 cores" in estimate(study("chute_stl")[2], 2)
