"""Which quantities varied: float noise, dependence on others, and few rows."""

import numpy as np
import pytest
from tables import drawn

from abradem.dataset.variation import (
    HELD_FIXED,
    NOT_IDENTIFIED,
    VARIED,
    held_fixed,
    nothing_varies,
    scales_of,
    settled,
    variation,
)
from abradem.quantities import FEATURE_NAMES, SAMPLED, SAMPLED_NAMES


def says(table, names=SAMPLED_NAMES):
    found = variation(table[list(names)].to_numpy(dtype=float), names)
    return dict(zip(names, found, strict=True))


def test_independent_draws_all_vary():
    table = drawn(60)
    assert set(says(table).values()) == {VARIED}
    values = table[list(FEATURE_NAMES)].to_numpy(dtype=float)
    assert set(variation(values, FEATURE_NAMES, linear=True)) == {VARIED}
    # The damping ratio is a function of the restitution.
    lost = {name for name, kind in says(table, FEATURE_NAMES).items() if kind == NOT_IDENTIFIED}
    assert lost == {"restitution", "damping_ratio"}


@pytest.mark.parametrize("name", SAMPLED_NAMES)
@pytest.mark.parametrize("noise", [0.0, 1e-16, 1e-12, 1e-8])
def test_a_constant_with_float_noise_was_held_fixed(name, noise):
    row = next(row for row in SAMPLED if row.name == name)
    for value in {row.paper_range[0], row.paper_range[1], max(row.limits[0], 0.0)}:
        size = abs(value) or scales_of([name])[0]
        values = value + noise * size * np.random.default_rng(0).uniform(-1.0, 1.0, 60)
        found = says(drawn(60).assign(**{name: values}))
        assert found.pop(name) == HELD_FIXED
        assert set(found.values()) == {VARIED}


@pytest.mark.parametrize("name", SAMPLED_NAMES)
def test_a_small_step_on_purpose_is_no_noise(name):
    row = next(row for row in SAMPLED if row.name == name)
    values = row.paper_range[1] or -row.paper_range[0]
    values = values * (1.0 + 1e-4 * (np.arange(60) % 2 - 1.0))
    assert says(drawn(60).assign(**{name: values}))[name] == VARIED


@pytest.mark.parametrize(
    "law",
    [
        lambda r: 100.0 * r + 3.0,
        lambda r: -7.0 * r,
        lambda r: r**-2,
        lambda r: 1.0 / (1.0 + np.exp(-40.0 * r)),
        lambda r: 100.0 * r + 1e-13 * np.arange(len(r)),
    ],
)
def test_quantities_that_vary_together_are_not_identified(law):
    table = drawn(60)
    table["particle_density"] = law(table["particle_radius"])
    found = says(table)
    together = {"particle_density", "particle_radius"}
    assert {name for name, kind in found.items() if kind == NOT_IDENTIFIED} == together
    assert {found[name] for name in set(found) - together} == {VARIED}


def test_three_quantities_may_depend_on_each_other_in_no_pair():
    table = drawn(60)
    table["restitution"] = 0.1 + table["static_friction"] + 2.0 * table["rolling_friction"]
    lost = {name for name, kind in says(table).items() if kind == NOT_IDENTIFIED}
    assert lost == {"restitution", "static_friction", "rolling_friction"}


def test_as_many_quantities_as_rows_are_not_identified():
    assert set(says(drawn(14)).values()) == {NOT_IDENTIFIED}


def test_features_held_fixed_lose_their_noise_and_the_others_nothing():
    table = drawn(30).assign(plate_angle=1e-17 * np.arange(30))
    values = table[list(FEATURE_NAMES)].to_numpy(dtype=float)
    found = settled(values, scales_of(FEATURE_NAMES))
    angle = FEATURE_NAMES.index("plate_angle")
    assert np.ptp(found[:, angle]) == 0.0
    np.testing.assert_array_equal(np.delete(found, angle, 1), np.delete(values, angle, 1))
    assert list(np.flatnonzero(held_fixed(found))) == [angle]


def test_a_study_in_which_nothing_varies_is_recognised():
    ranges = {row.name: [row.paper_range[0]] * 2 for row in SAMPLED}
    assert nothing_varies(ranges)
    assert not nothing_varies({**ranges, "restitution": [0.5, 0.6]})
