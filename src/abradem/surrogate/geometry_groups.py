"""Dimensionless groups of a geometry of which numbers were sampled.

A quantity of a geometry has one group, beside those of the jet (`abradem.surrogate.groups`). With
the fall height H and the speed of impact v they are ::

    ln l/H        length, width, radius, pitch, clearance or height, always positive
    x/H           gap or drop, which may be 0 or negative
    phi           angle, rad
    u/v           speed of a belt, whose sign is its direction
    U/v           speed of the rim of a screw, U = 2 pi n R

H is the same length for all cases, as in the group R/H, so that a group varies with its quantity
alone and its coefficient in a power law is the exponent of the quantity.

Only numpy is needed here, as in `abradem.surrogate.groups`, and the functions can be traced.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from abradem.quantities import GEOMETRY_GROUPS, GEOMETRY_NAMES, GEOMETRY_UNITS

_DEGREE = np.pi / 180.0
_PER_MINUTE = 2.0 * np.pi / 60.0


def shape_values(geometry: Mapping | None) -> Mapping[str, Any]:
    """Kind and numbers of a geometry, given whole or as its shape alone; empty for the plate."""
    return {} if geometry is None else geometry.get("shape", geometry)


def numbers_of(geometry: Mapping | None) -> dict[str, float | str]:
    """Numbers of a geometry by their names as quantities, those of `GEOMETRY_NAMES`.

    Parameters
    ----------
    geometry : mapping or None
        Plain values, see `abradem.config.geometry.geometry_dict`; None for the plate.

    Returns
    -------
    dict of str to float or str
        SI units, angles in degrees; a number that is sampled is the name of a quantity.
    """
    shape = shape_values(geometry)
    kind = shape.get("kind")
    if kind == "plates":
        named = {
            f"plate_{place}_{field}": value
            for place, plate in enumerate(shape["plates"], 1)
            for field, value in plate.items()
        }
    else:
        named = {f"{kind}_{field}": value for field, value in shape.items()}
    return {name: named[name] for name in GEOMETRY_NAMES if name in named}


def places_of(geometry: Mapping | None) -> dict[str, str]:
    """What the names of the quantities of a part begin with, by the name of the part.

    Parts without a name are left out.
    """
    shape = shape_values(geometry)
    return {
        plate["name"]: f"plate_{place}"
        for place, plate in enumerate(shape.get("plates", ()), 1)
        if plate.get("name")
    }


def sampled_names(geometry: Mapping | None) -> tuple[str, ...]:
    """Names of the quantities of a geometry that are sampled, in the order of `GEOMETRY_NAMES`."""
    return tuple(name for name, value in numbers_of(geometry).items() if value == name)


def geometry_group_names(geometry: Mapping | None) -> tuple[str, ...]:
    """Names of the groups of `geometry_columns`, in their order."""
    return tuple(GEOMETRY_GROUPS[name] for name in sampled_names(geometry))


def geometry_columns(
    values: Mapping, geometry: Mapping | None, height: float, squared: Any
) -> list:
    """Groups of the quantities of a geometry that are sampled, one array each.

    Parameters
    ----------
    values : mapping of str to array, shape (n,)
        Quantities in the units of `abradem.quantities`, angles in degrees.
    geometry : mapping or None
        See `numbers_of`.
    height : float
        Fall height H, m.
    squared : array, shape (n,)
        Square of the speed of impact v, m2/s2.

    Returns
    -------
    list of array, shape (n,)
        Dimensionless, angles in rad.
    """
    numbers = numbers_of(geometry)
    found = []
    for name in sampled_names(geometry):
        value, unit = values[name], GEOMETRY_UNITS[name]
        if unit == "deg":
            found.append(_DEGREE * value)
        elif unit == "m/s":
            found.append(value / np.sqrt(squared))
        elif unit == "rev/min":
            # Of a screw, the only kind that turns and is no file.
            radius = numbers["screw_radius"]
            radius = values[radius] if isinstance(radius, str) else radius
            found.append(_PER_MINUTE * value * radius / np.sqrt(squared))
        elif GEOMETRY_GROUPS[name].startswith("log_"):
            found.append(np.log(value / height))
        else:
            found.append(value / height)
    return found
