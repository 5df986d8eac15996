"""Conversion of `simulation.geometry` to plain values in SI units, and its sampled ranges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from abradem.config.declaration import Config
from abradem.config.geometry_keys import GeometryKeys


def geometry_dict(config: Config) -> dict | None:
    """Return the geometry as plain JSON values, SI units; None for the plate.

    ``shape`` has the fields of `abradem.geometry.kinds`. A number that is sampled is the name of
    its column in the table of cases.
    """
    keys = config.simulation.geometry
    if keys.kind == "plate":
        return None
    box = keys.removal_box_mm
    return {
        "shape": {"kind": keys.kind, **_shape(keys)},
        "centre": _metres(keys.factory_centre_mm),
        "direction": list(keys.jet_direction),
        "removal_box": None if box is None else [_metres(corner) for corner in box],
    }


def geometry_ranges(config: Config) -> dict[str, list[float]]:
    """Return {column: [lower, upper]} of the sampled quantities of the geometry, SI units."""
    return {
        column: [bound / factor for bound in value]
        for column, value, factor in _numbers(config.simulation.geometry)
        if isinstance(value, (tuple, list))
    }


def _numbers(keys: GeometryKeys) -> Iterator[tuple[str, Any, float]]:
    """Yield column, value of the configuration and factor of each number that may be a range."""
    if keys.kind == "plates":
        for place, plate in enumerate(keys.plates):
            for name, value in plate.items():
                if name != "name" and value != "plate_angle":
                    field, factor = _field(name)
                    yield f"plate_{place + 1}_{field}", value, factor
    elif keys.kind in ("arc", "screw"):
        for name, value in getattr(keys, keys.kind).model_dump().items():
            field, factor = _field(name)
            yield f"{keys.kind}_{field}", value, factor


def _field(name: str) -> tuple[str, float]:
    """Return the name of a key without its unit, and the number of its units in the SI unit."""
    if name == "rev_per_min":
        return "revolutions", 1.0
    if name == "belt_m_s":
        return "belt", 1.0
    if name.endswith("_mm"):
        return name.removesuffix("_mm"), 1000.0
    return name, 1.0


def _shape(keys: GeometryKeys) -> dict:
    if keys.kind == "mesh":
        mesh = keys.mesh
        return {
            "file": mesh.file, "unit": mesh.unit, "up": mesh.up, "repair": mesh.repair,
            "offset": _metres(mesh.offset_mm), "moving": [_motion(one) for one in keys.moving],
        }  # fmt: skip
    found = {
        column: column if isinstance(value, (tuple, list)) else value / factor
        for column, value, factor in _numbers(keys)
    }
    if keys.kind != "plates":
        return {column.removeprefix(f"{keys.kind}_"): one for column, one in found.items()}
    chain: list[dict] = []
    for place, plate in enumerate(keys.plates):
        begin = f"plate_{place + 1}_"
        fixed = {name: plate[name] for name in ("name", "angle") if name in plate}
        numbers = {c.removeprefix(begin): v for c, v in found.items() if c.startswith(begin)}
        chain.append({**fixed, **numbers})
    return {"plates": chain}


def _motion(keys: dict) -> dict:
    motion = {"part": keys["part"]}
    names = {"belt_m_s": "belt", "rev_per_min": "revolutions", "axis": "axis"}
    motion |= {field: keys[name] for name, field in names.items() if name in keys}
    if "axis_point_mm" in keys:
        motion["axis_point"] = _metres(keys["axis_point_mm"])
    return motion


def _metres(vector) -> list[float] | None:
    return None if vector is None else [number / 1000.0 for number in vector]
