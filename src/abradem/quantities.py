"""Table of all quantities: name, unit and limits.

All code that names, checks, converts, labels or plots a quantity uses this table. The symbols
X1..X20, the target X21 and the ranges are those of the paper, which the default configuration
reproduces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

GRAVITY = 9.81
"""Gravitational acceleration, m/s2; it acts along -y."""

WEAR_MEASURES = ("total", "sliding", "friction")
"""The three wear measures, each a form of "normal force times sliding distance" (Archard 1953,
J. Appl. Phys. 24:981)."""

STATISTICS = ("mean", "worn", "footprint", "p99", "max")
"""The statistics of a wear measure over the elements of the plate: facets, or squares of facets."""


@dataclass(frozen=True)
class Quantity:
    """One row of the table.

    Attributes
    ----------
    symbol : str
        X1..X21; others for quantities of a geometry.
    name : str
        Column name; SI unless the name says otherwise.
    unit : str
        Unit of the column, "1" if dimensionless.
    kind : {"sampled", "derived", "target", "geometry"}
    paper_range : tuple of float
        Lower and upper bound in the default study, in ``unit`` (sampled only).
    limits : tuple of float
        Range of values that are physically possible and that the engine can simulate, in
        ``unit``, inclusive (sampled and geometry).
    config_suffix : str
        Suffix of the key in the configuration, "" if the key is in ``unit``.
    config_factor : float
        Factor from the unit of the key in the configuration to ``unit``.
    """

    symbol: str
    name: str
    unit: str
    kind: str
    paper_range: tuple[float, ...] = ()
    limits: tuple[float, ...] = ()
    config_suffix: str = ""
    config_factor: float = 1.0

    @property
    def config_key(self) -> str:
        """Key of the range in the configuration, with a suffix for a unit that is not SI."""
        return self.name + self.config_suffix

    @property
    def config_unit(self) -> str:
        """Unit of the value in the configuration."""
        return {"_gpa": "GPa", "_mm": "mm", "_deg": "deg"}.get(self.config_suffix, self.unit)


def _sampled(symbol, name, unit, paper_range, limits, suffix="", factor=1.0):
    return Quantity(symbol, name, unit, "sampled", paper_range, limits, suffix, factor)


_GIGA = 1e9
_MILLI = 1e-3

# Lower limit of the restitution: the damping for an exact rebound grows without bound for
# e -> 0, and the impact becomes too stiff for the time step; see dem/damping.py.
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


MOST_PLATES = 8
"""Largest number of plates of a chain."""

_EXTENT, _SMALLEST = 100.0, 1e-6
"""Largest length of a geometry and smallest one that is above 0, m."""

# Unit, limits and name of the dimensionless group of a number of a geometry, see
# `abradem.surrogate.geometry_groups`.
_SIZE = ("m", (_SMALLEST, _EXTENT), "log_{}")
_OFFSET = ("m", (-_EXTENT, _EXTENT), "{}_ratio")
_SLOPE = ("deg", (-90.0, 90.0), "{}")

_TURN = ("deg", (-180.0, 180.0), "{}")
_BELT = ("m/s", (-_EXTENT, _EXTENT), "{}_ratio")

# Symbol and kind of each number of a geometry.
_GEOMETRY: dict[str, tuple[str, tuple[str, tuple[float, float], str]]] = {
    **{
        f"plate_{place}_{name}": (f"{symbol}{place}", kind)
        for place in range(1, MOST_PLATES + 1)
        for name, symbol, kind in (
            ("length", "l", _SIZE), ("width", "b", _SIZE), ("angle", "phi", _TURN),
            ("gap", "x", _OFFSET), ("drop", "h", _OFFSET), ("belt", "u", _BELT),
        )
    },
    "arc_radius": ("Ra", _SIZE), "arc_begin": ("a0", _SLOPE), "arc_end": ("a1", _SLOPE),
    "arc_width": ("ba", _SIZE),
    "screw_length": ("ls", _SIZE), "screw_radius": ("Rs", _SIZE),
    "screw_shaft_radius": ("rs", _SIZE), "screw_pitch": ("ps", _SIZE),
    "screw_clearance": ("cs", _SIZE), "screw_rim": ("hs", _SIZE),
    "screw_revolutions": ("ns", ("rev/min", (-1e4, 1e4), "{}_ratio")),
}  # fmt: skip

GEOMETRY_UNITS: dict[str, str] = {name: unit for name, (_, (unit, _, _)) in _GEOMETRY.items()}
"""Quantities of a geometry that may be sampled, with their units: columns of the cases."""

GEOMETRY_NAMES: tuple[str, ...] = tuple(GEOMETRY_UNITS)

GEOMETRY_GROUPS: dict[str, str] = {
    name: group.format(name) for name, (_, (_, _, group)) in _GEOMETRY.items()
}
"""Name of the dimensionless group of each quantity of a geometry: ``log_`` for the logarithm of a
length, ``_ratio`` for a ratio that may be 0 or negative, the quantity itself for an angle."""


def wear_column(measure: str, statistic: str) -> str:
    """Return the column name of the wear depth rate for a wear measure and a statistic."""
    return f"wear_{measure}_{statistic}"


WEAR_COLUMNS: tuple[str, ...] = tuple(
    wear_column(measure, statistic) for measure in WEAR_MEASURES for statistic in STATISTICS
)


def wear_parts(column: str) -> tuple[str, str]:
    """Return measure and statistic of a wear depth rate; raise KeyError for another column."""
    if column not in WEAR_COLUMNS:
        raise KeyError(f"{column!r} is no wear rate; known: {', '.join(WEAR_COLUMNS)}")
    _, measure, statistic = column.split("_")
    return measure, statistic


# Every wear rate is the target X21 of the study that predicts it.
_BY_NAME: dict[str, Quantity] = {
    **{q.name: q for q in QUANTITIES},
    **{
        name: Quantity(
            symbol,
            name,
            unit,
            "geometry",
            limits=limits,
            config_suffix="_mm" if unit == "m" else "",
            config_factor=_MILLI if unit == "m" else 1.0,
        )
        for name, (symbol, (unit, limits, _)) in _GEOMETRY.items()
    },
    **{column: replace(TARGET, name=column) for column in WEAR_COLUMNS},
}


def quantity(name: str) -> Quantity:
    """Return the row of the table with this name; raise KeyError with the known names if none.

    A wear rate has the row of the target X21.
    """
    try:
        return _BY_NAME[name]
    except KeyError:
        raise KeyError(f"unknown quantity {name!r}; known: {', '.join(_BY_NAME)}") from None


def check_value(name: str, value: float) -> str | None:
    """Return one line on why ``value`` (in the unit of the table) is invalid, or None."""
    row = quantity(name)
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
        return f"{name} must be a finite number, got {value!r}"
    low, high = row.limits
    if not low <= value <= high:
        return f"{name} = {value:g} {row.unit} is outside [{low:g}, {high:g}] {row.unit}"
    return None


def impossible(name: str, value: float, where: str = "") -> str | None:
    """Return one line on why a value is impossible, with what is allowed, or None.

    Parameters
    ----------
    name : str
        A sampled quantity.
    value : float
        In the unit of the table.
    where : str
        Place of the value, such as " in row 3".
    """
    row = quantity(name)
    low, high = row.limits
    if low <= value <= high:
        return None
    unit = "" if row.unit == "1" else f" {row.unit}"
    sense = "; down is negative" if name == "particle_velocity_y" else ""
    return (
        f"{name} = {value:g}{unit}{where} is impossible (allowed {low:g} ... {high:g}{unit}{sense})"
    )


def stderr_column(rate: str) -> str:
    """Return the column name of the standard error of a wear depth rate, given by its column."""
    return f"{rate}_stderr"


STDERR_COLUMNS: tuple[str, ...] = tuple(map(stderr_column, WEAR_COLUMNS))
