"""Sampling: coverage, additional blocks, seeds, and physically inconsistent cases."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abradem.dem.model import Setup
from abradem.elastic import rayleigh_time
from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.sampling.checks import FEWEST_STEPS, check_case
from abradem.sampling.draw import METHODS, block_cases, case_seed

PAPER = {row.name: row.paper_range for row in SAMPLED}
MIDDLE = {name: (low + high) / 2.0 for name, (low, high) in PAPER.items()}


def unit_values(frame: pd.DataFrame) -> np.ndarray:
    """Values of a block as shares of their ranges, shape (cases, 14)."""
    low, high = np.array(list(PAPER.values())).T
    return (frame[list(SAMPLED_NAMES)].to_numpy() - low) / (high - low)


@pytest.mark.parametrize("block", [0, 1, 7])
def test_each_block_of_a_latin_hypercube_is_a_latin_hypercube(block):
    cases = 50
    strata = np.floor(unit_values(block_cases(3, block, cases, "lhs", PAPER)) * cases)
    for column in strata.T:
        assert sorted(column) == list(range(cases))


def test_sobol_block_of_a_power_of_two_is_balanced_in_every_quantity():
    cases = 64
    strata = np.floor(unit_values(block_cases(3, 0, cases, "sobol", PAPER)) * cases)
    for column in strata.T:
        assert sorted(column) == list(range(cases))


def test_sobol_blocks_continue_one_balanced_sequence():
    blocks = [unit_values(block_cases(3, block, 16, "sobol", PAPER)) for block in range(4)]
    for column in np.floor(np.concatenate(blocks) * 64).T:
        assert sorted(column) == list(range(64))
    assert not np.array_equal(blocks[0], unit_values(block_cases(4, 0, 16, "sobol", PAPER)))


def test_uniform_sample_is_uniform():
    values = unit_values(block_cases(3, 0, 4000, "uniform", PAPER))
    # Mean 1/2 and variance 1/12, within five standard errors.
    assert np.abs(values.mean(axis=0) - 0.5).max() < 5.0 * math.sqrt(1.0 / 12.0 / 4000)
    assert np.abs(values.var(axis=0) - 1.0 / 12.0).max() < 5.0 * math.sqrt(1.0 / 180.0 / 4000)


@pytest.mark.parametrize("method", METHODS)
def test_a_block_is_a_pure_function_of_its_arguments(method):
    first = block_cases(5, 2, 10, method, PAPER)
    block_cases(5, 3, 10, method, PAPER)
    pd.testing.assert_frame_equal(first, block_cases(5, 2, 10, method, PAPER))


@pytest.mark.parametrize("method", ["lhs", "uniform"])
def test_blocks_and_seeds_are_independent_of_each_other(method):
    blocks = [
        unit_values(block_cases(seed, block, 200, method, PAPER)).ravel()
        for seed in (0, 1)
        for block in (0, 1)
    ]
    correlation = np.corrcoef(blocks) - np.eye(4)
    assert np.abs(correlation).max() < 5.0 / math.sqrt(blocks[0].size)


def test_first_block_does_not_change_between_releases():
    # A study may be extended years later: the numbers of a seed must not change.
    frame = block_cases(1, 0, 100, "lhs", PAPER)
    assert frame["particle_radius"].iloc[0] == pytest.approx(0.015582455986929752, rel=1e-12)
    assert frame["seed"].iloc[0] == 1018583812506503904


def test_the_table_has_the_agreed_columns_and_types():
    frame = block_cases(1, 3, 5, "lhs", PAPER)
    assert list(frame.columns) == ["case_id", "block", "seed", *SAMPLED_NAMES, "rejected"]
    assert list(frame["case_id"]) == [15, 16, 17, 18, 19]
    assert frame.dtypes[["case_id", "block", "seed"]].tolist() == ["int64", "int32", "int64"]
    assert (frame["block"] == 3).all()
    assert (frame["rejected"] == "").all()


@given(
    st.sampled_from(METHODS),
    st.integers(1, 33),
    st.floats(0.05, 1.0),
    st.floats(0.05, 1.0),
)
@settings(max_examples=40)
def test_values_stay_within_their_bounds(method, cases, one, other):
    low, high = min(one, other), max(one, other)
    frame = block_cases(0, 0, cases, method, {**PAPER, "restitution": (low, high)})
    assert frame["restitution"].between(low, high).all()


def test_equal_bounds_keep_a_quantity_fixed_and_the_others_as_they_were():
    fixed = {**PAPER, "restitution": (0.37, 0.37)}
    free_frame, fixed_frame = (block_cases(1, 0, 20, "lhs", r) for r in (PAPER, fixed))
    assert (fixed_frame["restitution"] == 0.37).all()
    pd.testing.assert_frame_equal(
        free_frame.drop(columns="restitution"), fixed_frame.drop(columns="restitution")
    )


def test_seeds_of_cases_are_distinct_and_fit_a_signed_integer():
    seeds = [case_seed(study, case) for study in range(5) for case in range(1000)]
    assert len(set(seeds)) == len(seeds)
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_unknown_method_is_named_with_what_is_allowed():
    with pytest.raises(
        ValueError, match="method = 'grid' is unknown; allowed: lhs, sobol, uniform"
    ):
        block_cases(0, 0, 5, "grid", PAPER)


@pytest.mark.parametrize(
    ("ranges", "problem"),
    [
        ({"restitution": (0.2, 0.8)}, "missing"),
        ({**PAPER, "colour": (0.0, 1.0)}, r"unknown \['colour'\]"),
        ({**PAPER, "restitution": (0.8, 0.2)}, "the lower not above the upper"),
        ({**PAPER, "restitution": (0.2, math.nan)}, "finite"),
    ],
)
def test_ranges_must_be_complete_and_ordered(ranges, problem):
    with pytest.raises(ValueError, match=problem):
        block_cases(0, 0, 5, "lhs", ranges)


def test_the_papers_ranges_hold_no_inconsistent_case():
    for method in METHODS:
        frame = block_cases(1, 0, 256, method, PAPER, Setup())
        assert (frame["rejected"] == "").all()


def test_corners_of_the_papers_ranges_are_consistent():
    fast = {name: low for name, (low, _) in PAPER.items()}
    assert check_case({**fast, "particle_radius": 0.04}, Setup()) == ""
    slow = {name: high for name, (_, high) in PAPER.items()}
    assert check_case({**slow, "factory_angle": -90.0}, Setup()) == ""


@pytest.mark.parametrize(
    ("values", "setup", "reason"),
    [
        ({"particle_shear_modulus": -1.0}, {}, "particle_shear_modulus = -1 Pa is outside"),
        ({"equipment_poisson_ratio": 0.5}, {}, "equipment_poisson_ratio = 0.5 1 is outside"),
        ({"rolling_friction": -0.1}, {}, "rolling_friction = -0.1 1 is outside"),
        ({"restitution": math.nan}, {}, "restitution must be a finite number"),
        ({"particle_radius": 0.04}, {"plate_width": 0.07},
         "particle of radius 0.04 m is wider than the plate (0.07 m)"),
        ({"plate_angle": 70.0, "factory_angle": -90.0, "particle_radius": 0.04},
         {"fall_height": 0.12}, "the factory patch comes within"),
        ({"particle_shear_modulus": 1e6, "particle_velocity_y": -10.0}, {},
         "too soft for this speed"),
        ({"particle_velocity_y": -10.0}, {"time_step_fraction": 0.4}, "the time step is too long"),
        ({"particle_velocity_y": 0.0}, {"gravity": 0.0}, "neither starts with a velocity"),
    ],
)  # fmt: skip
def test_what_cannot_be_simulated_is_rejected_with_its_reason(values, setup, reason):
    assert reason in check_case({**MIDDLE, **values}, Setup(**setup))


def test_a_set_is_judged_alone_where_no_setup_is_given():
    soft = {**MIDDLE, "particle_shear_modulus": 1e6, "particle_velocity_y": -10.0}
    assert check_case(soft) == ""
    assert check_case(soft, Setup()) != ""


def test_rejected_case_keeps_its_number():
    soft = {**PAPER, "particle_shear_modulus": (1e6, 10e9)}
    narrow = dataclasses.replace(Setup(), plate_width=0.05)
    frame = block_cases(1, 1, 10, "lhs", soft, narrow)
    rejected = frame["rejected"] != ""
    assert 0 < rejected.sum() < 10
    assert list(frame["case_id"]) == list(range(10, 20))
    assert (frame.loc[rejected, "particle_radius"] > 0.025).all()


def test_patch_that_crosses_the_plate_is_rejected():
    crossing = {**MIDDLE, "plate_angle": 0.0, "factory_angle": -90.0}
    assert "within 0 m" in check_case(crossing, Setup(fall_height=0.02, patch_length=0.1))


@pytest.mark.parametrize("angle", [-90.0, -30.0, 0.0, 45.0])
def test_clearance_is_the_distance_of_patch_and_level_plate(angle):
    # Above a level plate the lowest point of the patch matters.
    height, patch, radius = 0.25, 0.1, 0.02
    lowest = height - patch / 2.0 * abs(math.sin(math.radians(angle)))
    values = {**MIDDLE, "plate_angle": 0.0, "factory_angle": angle, "particle_radius": radius}
    drop = lowest - radius
    assert check_case(values, Setup(fall_height=height - drop + 1e-9)) == ""
    assert "closer than the radius" in check_case(values, Setup(fall_height=height - drop - 1e-9))


def test_overlap_limit_is_hertz():
    # A stiff plate and e = 1: d/R = (5 m v^2 / (4 k R^2.5))^0.4 does not depend on R.
    values = {**MIDDLE, "equipment_shear_modulus": 1e12, "particle_poisson_ratio": 0.0,
              "equipment_poisson_ratio": 0.0, "particle_velocity_y": -10.0}  # fmt: skip
    speed_squared = 100.0 + 2.0 * 9.81 * 0.25
    # d = 0.2 R at E* = 2 G: G = 5 pi rho v^2 / (8 * 0.2^2.5)
    limit = 5.0 * math.pi * values["particle_density"] * speed_squared / (8.0 * 0.2**2.5)
    assert check_case({**values, "particle_shear_modulus": limit * 1.001}, Setup()) == ""
    soft = check_case({**values, "particle_shear_modulus": limit * 0.99}, Setup())
    assert "would overlap by 20% of the radius (allowed 20%)" in soft


def test_duration_of_an_impact_in_steps_is_hertz_over_the_rayleigh_time():
    values = {**MIDDLE, "particle_velocity_y": -10.0}
    step = 0.2 * rayleigh_time(
        values["particle_radius"], values["particle_density"],
        values["particle_shear_modulus"], values["particle_poisson_ratio"],
    )  # fmt: skip
    assert check_case(values, Setup(time_step=step)) == ""
    long = check_case(values, Setup(time_step=10.0 * step))
    assert f"(allowed at least {FEWEST_STEPS})" in long


def test_rayleigh_time_of_a_known_particle():
    # R 10 mm, rho 2500, G 6 GPa, nu .25: pi R sqrt(rho/G) / (.1631 nu + .8766)
    assert rayleigh_time(0.01, 2500.0, 6e9, 0.25) == pytest.approx(2.2105e-5, rel=1e-3)
