"""Accepted units of quantities, and values with units as text: "20 mm", "45deg", "-5 m/s"."""

from __future__ import annotations

import math
import re

from abradem.quantities import quantity

MM_PER_M = 1e3

UNITS = {
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "1/Pa": {"1/Pa": 1.0, "m2/N": 1.0, "1/GPa": 1e-9},
    "kg/m3": {"kg/m3": 1.0, "g/cm3": 1e3},
    "deg": {"deg": 1.0, "rad": 180.0 / math.pi},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3},
    "kg/s": {"kg/s": 1.0, "g/s": 1e-3},
    "mm/s": {"mm/s": 1.0, "m/s": 1e3, "um/s": 1e-3, "mm/h": 1.0 / 3600.0},
    "1": {"1": 1.0},
}
"""For each unit of `abradem.quantities`, the accepted units and their factors to it."""

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def parse_value(name: str, text: str) -> float:
    """Return the value of a quantity, in its own unit, from text with or without a unit.

    Parameters
    ----------
    name : str
        A quantity of `abradem.quantities`.
    text : str
        For example "20 mm". A number without a unit is in the unit of the quantity.

    Returns
    -------
    float
        The value in the unit of the quantity.

    Raises
    ------
    ValueError
        If the text is not a number, or the unit is not accepted for this quantity.
    """
    own = quantity(name).unit
    found = _NUMBER.fullmatch(text)
    if not found:
        raise ValueError(f"{name} = {text!r} is not a number")
    number, unit = found.groups()
    unit = f"1{unit}" if unit.startswith("/") else unit
    if unit and unit not in UNITS[own]:
        allowed = ", ".join(UNITS[own]) if own != "1" else "none, it is a pure number"
        raise ValueError(f"{name} = {text!r}: unit {unit!r} is unknown here (allowed {allowed})")
    return float(number) * UNITS[own].get(unit, 1.0)
