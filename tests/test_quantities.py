"""The table of quantities: completeness, consistency and checking of values."""

from __future__ import annotations

import dataclasses
import math

import pytest

from abradem import quantities
from abradem.dem.model import Case
from abradem.quantities import (
    DERIVED,
    FEATURE_NAMES,
    QUANTITIES,
    SAMPLED,
    SAMPLED_NAMES,
    TARGET,
    check_value,
    quantity,
)


def test_symbols_run_from_x1_to_x21():
    assert [row.symbol for row in QUANTITIES] == [f"X{number}" for number in range(1, 22)]


def test_fourteen_quantities_are_sampled_and_six_derived():
    assert (len(SAMPLED), len(DERIVED), len(FEATURE_NAMES)) == (14, 6, 20)
    assert TARGET.symbol == "X21" and TARGET.name == "wear_total_mean"


def test_names_are_unique():
    assert len({row.name for row in QUANTITIES}) == len(QUANTITIES)
    assert len({row.config_key for row in SAMPLED}) == len(SAMPLED)


@pytest.mark.parametrize("row", SAMPLED, ids=lambda row: row.name)
def test_paper_range_lies_within_the_limits(row):
    low, high = row.limits
    assert low <= row.paper_range[0] < row.paper_range[1] <= high


@pytest.mark.parametrize("row", [*DERIVED, TARGET], ids=lambda row: row.name)
def test_what_is_not_sampled_has_no_range(row):
    assert row.paper_range == row.limits == ()


@pytest.mark.parametrize("row", SAMPLED, ids=lambda row: row.name)
def test_key_of_the_configuration_tells_its_unit_where_it_is_not_si(row):
    scales = {"_gpa": ("GPa", 1e9), "_mm": ("mm", 1e-3), "": (row.unit, 1.0)}
    unit, factor = scales[row.config_suffix]
    assert (row.config_unit, row.config_factor) == (unit, factor)
    assert row.config_key == row.name + row.config_suffix


def test_a_case_holds_the_sampled_quantities_in_the_order_of_the_table():
    names = [field.name for field in dataclasses.fields(Case)]
    assert names == [*SAMPLED_NAMES, "seed"]


@pytest.mark.parametrize("row", SAMPLED, ids=lambda row: row.name)
def test_limits_belong_to_what_is_possible(row):
    low, high = row.limits
    assert check_value(row.name, low) is None
    assert check_value(row.name, high) is None
    assert row.name in check_value(row.name, math.nextafter(low, -math.inf))
    assert row.name in check_value(row.name, math.nextafter(high, math.inf))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, True, "0.5", None])
def test_what_is_no_finite_number_is_refused(value):
    assert (
        check_value("restitution", value) == f"restitution must be a finite number, got {value!r}"
    )


def test_quantities_are_found_by_name():
    assert quantity("particle_radius").symbol == "X15"
    with pytest.raises(KeyError, match="unknown quantity 'radius'; known: particle_youngs_modulus"):
        quantity("radius")


def test_gravity_is_the_standard_one():
    assert quantities.GRAVITY == 9.81
