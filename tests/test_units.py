"""Units: every way to write one, against the independent package pint, and what is refused."""

import math

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abradem.quantities import SAMPLED
from abradem.units import (
    ACCEPTED,
    SYMBOLS,
    UnitError,
    conversion,
    convert,
    has_unit,
    parse_quantity,
    parse_unit,
    parse_value,
)

PINT = pint.UnitRegistry(cache_folder=None)


def by_pint(unit, wanted):
    """Factor from one unit to another; pint has no m3 and takes Nm for nanometre."""
    texts = [text.replace("m3", "m^3").replace("m2", "m^2").replace("Nm", "N m")
             for text in (unit, wanted)]  # fmt: skip
    return PINT.Quantity(1.0, PINT.parse_units(texts[0])).to(PINT.parse_units(texts[1])).magnitude


WAYS = [
    ("kg/m³", "kg/m3"), ("kg/m^3", "kg/m3"), ("kg m^-3", "kg/m3"), ("kg·m⁻³", "kg/m3"),
    ("kg m⁻³", "kg/m3"), ("g/cm³", "kg/m3"), ("g/cm3", "kg/m3"), ("t/m³", "kg/m3"),
    ("lb/ft^3", "kg/m3"), ("kg/(m m m)", "kg/m3"), ("kg/m/m/m", "kg/m3"),
    ("1/Pa", "1/Pa"), ("Pa^-1", "1/Pa"), ("Pa⁻¹", "1/Pa"), ("m²/N", "1/Pa"), ("m^2/N", "1/Pa"),
    ("1/GPa", "1/Pa"), ("GPa^-1", "1/Pa"), ("mm³/(N m)", "1/Pa"), ("mm^3/(N*m)", "1/Pa"),
    ("mm³/N/m", "1/Pa"), ("mm²/N", "1/Pa"), ("1/psi", "1/Pa"),
    ("km/h", "m/s"), ("cm/s", "m/s"), ("m s^-1", "m/s"), ("ft/s", "m/s"), ("in/min", "m/s"),
    ("µm", "m"), ("um", "m"), ("μm", "m"), ("nm", "m"), ("in", "m"), ("ft", "m"), ("dm", "m"),
    ("N/mm²", "Pa"), ("kN/m²", "Pa"), ("bar", "Pa"), ("psi", "Pa"), ("kg/(m s²)", "Pa"),
    ("rad", "deg"), ("mrad", "deg"), ("degree", "deg"), ("°", "deg"),
    ("t/h", "kg/s"), ("kg/min", "kg/s"), ("g/s", "kg/s"), ("mm/h", "mm/s"), ("µm/s", "mm/s"),
]  # fmt: skip


@pytest.mark.parametrize(("unit", "wanted"), WAYS)
def test_every_way_to_write_a_unit_has_the_factor_of_pint(unit, wanted):
    assert conversion(unit, wanted) == pytest.approx(by_pint(unit, wanted), rel=1e-14)
    assert parse_quantity(f"3 {unit}", wanted) == pytest.approx(3.0 * conversion(unit, wanted))


@pytest.mark.parametrize("symbol", sorted(set(SYMBOLS) - {"Nm"}))
def test_every_symbol_is_that_of_pint(symbol):
    factor, powers = SYMBOLS[symbol]
    name = {"rev": "revolution"}.get(symbol, symbol)
    base = PINT.Quantity(1.0, PINT.parse_units(name)).to_base_units()
    dimensions = dict(base.dimensionality)
    names = ("[mass]", "[length]", "[time]")
    assert [dimensions.get(name, 0) for name in names] == list(powers[:3])
    assert float(factor) == pytest.approx(base.magnitude, rel=1e-14)


def test_the_units_that_messages_name_are_accepted():
    for wanted, units in ACCEPTED.items():
        for unit in units:
            assert conversion(unit, wanted) > 0.0


def test_newton_metre_is_no_nanometre():
    assert conversion("mm3/Nm", "1/Pa") == conversion("mm3/(N m)", "1/Pa") == 1e-9
    assert conversion("nm", "m") == 1e-9


@pytest.mark.parametrize(
    ("text", "wanted", "value"),
    [
        ("45°", "deg", 45.0), ("45 °", "deg", 45.0), ("−5 m/s", "m/s", -5.0), ("–5", "m/s", -5.0),
        ("+.5 cm", "m", 0.005), ("5. mm", "m", 0.005), ("7mm", "m", 0.007), ("2e1 mm", "m", 0.02),
        ("1.5×10⁻⁹ 1/Pa", "1/Pa", 1.5e-9), ("1.5*10^-9", "1/Pa", 1.5e-9), ("2 /Pa", "1/Pa", 2.0),
        ("18 km/h", "m/s", 5.0), ("2.65\u00a0g/cm³", "kg/m3", 2650.0), (" 3 ", "1", 3.0),
    ],
)  # fmt: skip
def test_values_with_units_are_read(text, wanted, value):
    assert parse_quantity(text, wanted) == value


@pytest.mark.parametrize(
    ("text", "wanted", "words"),
    [
        ("20,5 mm", "m", "has a decimal comma"), ("20,5", "m", "has a decimal comma"),
        ("1,000,000", "Pa", "separators of thousands"), ("1 000 000", "Pa", "of thousands"),
        ("1'000'000", "Pa", "separators of thousands"), ("1_000", "Pa", "of thousands"),
        ("nan", "m", "is not a number"), ("inf", "m", "is not a number"), ("", "m", "not a number"),
        ("mm", "m", "is not a number"), ("٣", "m", "is not a number"), ("--5", "m", "not a number"),
        ("1e999", "m", "is not a finite number"), ("1e99999999 m", "m", "is not a finite number"),
        ("1*10^99999999", "m", "is not a finite number"), ("1" * 5000, "m", "is not a number"),
        ("10 gpa", "Pa", "did you mean GPa"), ("50 %", "1", "pure number"),
        ("3 mm/s", "m", "another dimension"), ("3 mm³/N m", "1/Pa", "another dimension"),
        ("0x10", "m", "unit 'x10' is unknown"), ("5 m/", "m", "is unknown"),
        ("5 m^", "m", "is unknown"), ("5 (m", "m", "is unknown"), ("5 m)", "m", "is unknown"),
        ("5 m^99999999", "m", "is unknown"), ("5 //m", "m", "is unknown"), ("5 5", "m", "not a"),
    ],
)  # fmt: skip
def test_what_is_no_quantity_is_refused(text, wanted, words):
    with pytest.raises(ValueError, match=words):
        parse_quantity(text, wanted)


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e200, max_value=1e200))
def test_a_number_is_read_exactly(value):
    assert parse_quantity(repr(value), "m") == value


@given(st.integers(-(10**9), 10**9), st.sampled_from(["mm", "um", "cm"]))
def test_a_value_with_a_unit_is_the_nearest_number(value, unit):
    nearest = value / {"mm": 10**3, "um": 10**6, "cm": 10**2}[unit]
    assert parse_quantity(f"{value} {unit}", "m") == nearest
    assert convert(np.array([float(value)]), unit, "m")[0] == nearest


@given(st.text(max_size=30))
def test_any_text_is_a_unit_or_a_refusal(text):
    try:
        unit = parse_unit(text)
    except UnitError:
        return
    assert unit.factor > 0 and math.isfinite(float(unit.factor))


@pytest.mark.parametrize("row", SAMPLED, ids=lambda row: row.name)
def test_a_number_without_a_unit_is_in_that_of_the_quantity(row):
    assert parse_value(row.name, "0.25") == 0.25
    with pytest.raises(ValueError, match=f"{row.name} = 'x' is not a number"):
        parse_value(row.name, "x")


def test_a_unit_behind_a_number_is_seen():
    assert has_unit("5 mm") and has_unit("5mm") and has_unit("−5°")
    assert not has_unit("5") and not has_unit("mm") and not has_unit("x5")
