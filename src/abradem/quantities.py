"""The one table of quantities: what each is called, in which unit, and within which limits.

Everything that names, checks, converts, labels or plots a quantity reads this table.
Symbols X1..X20 and the target X21, and the paper's ranges, follow the study that the
default configuration repeats.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

GRAVITY = 9.81
"""Gravitational acceleration, m/s2; it acts along -y."""

WEAR_MEASURES = ("total", "sliding", "friction")
"""The three wear measures of Archard's "normal force times sliding distance"."""

STATISTICS = ("mean", "footprint", "p99", "max")
"""The statistics over the plate's facets that a wear measure is reduced to."""


@dataclass(frozen=True)
class Quantity:
    """One row of the table.

    Attributes
    ----------
    symbol : str
        X1..X21.
    name : str
        Column name; SI unless the name says otherwise.
    unit : str
        Unit of the column, "1" where dimensionless.
    kind : {"sampled", "derived", "target"}
    paper_range : tuple of float or None
        Lower and upper bound in the default study, in ``unit`` (sampled only).
    limits : tuple of float or None
        What is physically possible and the engine can simulate, in ``unit``, inclusive
        (sampled only).
    config_suffix : str
        Suffix of the key in the configuration, "" where it is in ``unit``.
    config_factor : float
        Value in the configuration times this is the value in ``unit``.
    """

    symbol: str
    name: str
    unit: str
    kind: str
    paper_range: tuple[float, float] | None = None
    limits: tuple[float, float] | None = None
    config_suffix: str = ""
    config_factor: float = 1.0

    @property
    def config_key(self) -> str:
        """Key of the range in the configuration, with its unit where that is not SI."""
        return self.name + self.config_suffix

    @property
    def config_unit(self) -> str:
        """Unit of the value in the configuration."""
        return {"_gpa": "GPa", "_mm": "mm", "_deg": "deg"}.get(self.config_suffix, self.unit)


def _sampled(symbol, name, unit, paper_range, limits, suffix="", factor=1.0):
    return Quantity(symbol, name, unit, "sampled", paper_range, limits, suffix, factor)


_GIGA = 1e9
_MILLI = 1e-3

# Limits of restitution: the damping that gives exactly e grows without bound as e -> 0,
# and the impact becomes too stiff for the step; see dem/damping.py.
QUANTITIES: tuple[Quantity, ...] = (
    Quantity("X1", "particle_youngs_modulus", "Pa", "derived"),
    _sampled(
        "X2", "particle_shear_modulus", "Pa",
        (2e9, 10e9), (1e6, 1e12), "_gpa", _GIGA,
    ),
    _sampled(
        "X3", "particle_poisson_ratio", "1",
        (0.2, 0.35), (0.0, 0.499),
    ),
    _sampled(
        "X4", "particle_density", "kg/m3",
        (2000.0, 4000.0), (10.0, 25000.0),
    ),
    Quantity("X5", "equipment_youngs_modulus", "Pa", "derived"),
    _sampled(
        "X6", "equipment_shear_modulus", "Pa",
        (10e9, 100e9), (1e6, 1e12), "_gpa", _GIGA,
    ),
    _sampled(
        "X7", "equipment_poisson_ratio", "1",
        (0.2, 0.35), (0.0, 0.499),
    ),
    _sampled(
        "X8", "equipment_density", "kg/m3",
        (6000.0, 8000.0), (10.0, 25000.0),
    ),
    _sampled(
        "X9", "restitution", "1", (0.2, 0.8), (0.05, 1.0)
    ),
    _sampled(
        "X10", "rolling_friction", "1",
        (0.01, 0.1), (0.0, 1.0),
    ),
    _sampled(
        "X11", "static_friction", "1",
        (0.4, 0.55), (0.0, 2.0),
    ),
    _sampled(
        "X12", "archard_constant", "1/Pa",
        (1e-10, 1e-8), (1e-16, 1e-4),
    ),
    _sampled("X13", "plate_angle", "deg", (0.0, 70.0), (-90.0, 90.0)),
    _sampled(
        "X14", "factory_angle", "deg", (-90.0, 0.0), (-90.0, 90.0)
    ),
    _sampled(
        "X15", "particle_radius", "m",
        (5e-3, 40e-3), (1e-4, 0.1), "_mm", _MILLI,
    ),
    _sampled(
        "X16", "particle_velocity_y", "m/s",
        (-10.0, 0.0), (-30.0, 0.0),
    ),
    Quantity(
        "X17", "effective_youngs_modulus", "Pa", "derived"
    ),
    Quantity("X18", "effective_shear_modulus", "Pa", "derived"),
    Quantity("X19", "damping_ratio", "1", "derived"),
    Quantity("X20", "damping_coefficient", "kg/s", "derived"),
    Quantity("X21", "wear_total_mean", "mm/s", "target"),
)  # fmt: skip

SAMPLED: tuple[Quantity, ...] = tuple(q for q in QUANTITIES if q.kind == "sampled")
DERIVED: tuple[Quantity, ...] = tuple(q for q in QUANTITIES if q.kind == "derived")
TARGET: Quantity = QUANTITIES[-1]
FEATURE_NAMES: tuple[str, ...] = tuple(q.name for q in QUANTITIES[:-1])
SAMPLED_NAMES: tuple[str, ...] = tuple(q.name for q in SAMPLED)

_BY_NAME = {q.name: q for q in QUANTITIES}


def quantity(name: str) -> Quantity:
    """Return the row of the table called ``name``; raises KeyError with the allowed names."""
    try:
        return _BY_NAME[name]
    except KeyError:
        raise KeyError(f"no quantity {name!r}; known are {', '.join(_BY_NAME)}") from None


def check_value(name: str, value: float) -> str | None:
    """Say in one line why ``value`` (in the table's unit) is impossible, or return None."""
    row = quantity(name)
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
        return f"{name} must be a finite number, got {value!r}"
    low, high = row.limits
    if not low <= value <= high:
        return f"{name} = {value:g} {row.unit} is outside [{low:g}, {high:g}] {row.unit}"
    return None


def wear_column(measure: str, statistic: str) -> str:
    """Name of the depth rate of a wear measure and a statistic over the plate."""
    return f"wear_{measure}_{statistic}"


WEAR_COLUMNS: tuple[str, ...] = tuple(
    wear_column(measure, statistic) for measure in WEAR_MEASURES for statistic in STATISTICS
)
