"""Units that are understood beside our own, and values as text: "20 mm", "45deg", "-5 m/s"."""

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
"""For each of our units those that are understood, and the factor to ours."""

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def parse_value(name: str, text: str) -> float:
    """The value of a quantity from text with or without a unit, in the quantity's own unit.

    Parameters
    ----------
    name : str
        A quantity of `abradem.quantities`.
    text : str
        Such as "20 mm"; without a unit it is the quantity's own.

    Raises
    ------
    ValueError
        If it is no number or the unit is none of this quantity; one line.
    """
    own = quantity(name).unit
    found = _NUMBER.fullmatch(text)
    if not found:
        raise ValueError(f"{name} = {text!r} is no number")
    number, unit = found.groups()
    unit = f"1{unit}" if unit.startswith("/") else unit
    if unit and unit not in UNITS[own]:
        allowed = ", ".join(UNITS[own]) if own != "1" else "none, it is a pure number"
        raise ValueError(f"{name} = {text!r}: unit {unit!r} is unknown here (allowed {allowed})")
    return float(number) * UNITS[own].get(unit, 1.0)
