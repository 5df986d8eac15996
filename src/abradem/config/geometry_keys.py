"""Keys of `simulation.geometry`: what the particles wear."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, WithJsonSchema

from abradem.config.fields import Section, Text, interval_text, number_text, require_number, setting
from abradem.config.quantity_texts import read_quantity
from abradem.quantities import MOST_PLATES

_EXTENT_MM = 100_000.0

"""Largest length of a geometry, mm."""


def _number_or_range(low: float, high: float, above: bool = False) -> Any:
    """Return the type of a number that a range of two numbers samples."""

    def check(value: Any) -> float | tuple[float, float]:
        bounds = value if isinstance(value, (list, tuple)) else [value]
        if len(bounds) not in (1, 2):
            raise ValueError("must be one number or two, [lower bound, upper bound]")
        for bound in bounds:
            require_number(bound, low, high)
            if not low <= bound <= high or (above and bound == low):
                raise ValueError(f"{number_text(bound)} is out of range")
        if bounds[0] > bounds[-1]:
            raise ValueError("lower bound must not exceed the upper bound")
        first, last = float(bounds[0]), float(bounds[-1])
        return first if first == last else (first, last)

    least = "exclusiveMinimum" if above else "minimum"
    number = {"type": "number", least: low, "maximum": high}
    pair = {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    return Annotated[Any, PlainValidator(check), WithJsonSchema({"anyOf": [number, pair]})]


_LENGTH = _number_or_range(0.0, _EXTENT_MM, above=True)


def _geometry_key(default: float, description: str, unit: str, low: float, high: float) -> Any:
    allowed = f"{interval_text(low, high, unit, above=low == 0.0)}, or a range that is sampled"
    return setting(default, description, unit=unit, allowed=allowed)


_PLATE_KEYS = {
    "length_mm": (_LENGTH, "mm"),
    "width_mm": (_number_or_range(0.0, _EXTENT_MM, above=True), "mm"),
    "angle": (_number_or_range(-180.0, 180.0), "deg"),
    "gap_mm": (_number_or_range(-_EXTENT_MM, _EXTENT_MM), "mm"),
    "drop_mm": (_number_or_range(-_EXTENT_MM, _EXTENT_MM), "mm"),
    "belt_m_s": (_number_or_range(-100.0, 100.0), "m/s"),
}

"""Keys of a plate of a chain beside its name: type and unit."""


def _check_chain(value: Any) -> list[dict]:
    if not isinstance(value, list) or len(value) > MOST_PLATES:
        raise ValueError(f"must be a list of at most {MOST_PLATES} plates")
    return [_checked_plate(f"plate {place + 1}", plate) for place, plate in enumerate(value)]


def _checked_plate(where: str, plate: Any) -> dict:
    if not isinstance(plate, Mapping):
        raise ValueError(f"{where}: must be keys with values")
    unknown = [name for name in plate if name not in (*_PLATE_KEYS, "name")]
    if unknown:
        raise ValueError(f"{where}: unknown key {unknown[0]}")
    missing = [name for name in ("length_mm", "width_mm", "angle") if name not in plate]
    if missing:
        raise ValueError(f"{where}: {missing[0]} is missing")
    found: dict = {}
    for name, one in plate.items():
        if name == "name":
            if not isinstance(one, str) or not re.fullmatch(r"[A-Za-z0-9_-]{1,40}", one):
                raise ValueError(f"{where}: name: must be letters, digits, _ and -")
            found[name] = one
        elif name == "angle" and one == "plate_angle":
            found[name] = one
        else:
            annotation, unit = _PLATE_KEYS[name]
            check = annotation.__metadata__[0].func
            try:
                found[name] = check(read_quantity(one, unit))
            except ValueError as error:
                raise ValueError(f"{where}: {name}: {error}") from None
    return found


_MOTION_KEYS = {"belt_m_s": 100.0, "axis_point_mm": _EXTENT_MM, "axis": 1e6}

"""Vectors of a motion, and the largest magnitude of a component."""


def _check_moving(value: Any) -> list[dict]:
    if not isinstance(value, list):
        raise ValueError("must be a list of motions")
    return [_checked_motion(f"motion {place + 1}", one) for place, one in enumerate(value)]


def _checked_motion(where: str, motion: Any) -> dict:
    if not isinstance(motion, Mapping) or not isinstance(motion.get("part"), str):
        raise ValueError(f"{where}: must name its part")
    found: dict = {"part": motion["part"]}
    for name, one in motion.items():
        if name == "rev_per_min":
            require_number(one, -1e4, 1e4)
            if not -1e4 <= one <= 1e4:
                raise ValueError(f"{where}: {name}: {number_text(one)} is out of range")
            found[name] = float(one)
        elif name in _MOTION_KEYS:
            found[name] = _checked_vector(f"{where}: {name}", one, _MOTION_KEYS[name])
        elif name != "part":
            raise ValueError(f"{where}: unknown key {name}")
    return found


def _checked_vector(where: str, value: Any, most: float) -> list[float]:
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ValueError(f"{where}: must be three numbers, [x, y, z]")
    for one in value:
        require_number(one, -most, most)
        if not -most <= one <= most:
            raise ValueError(f"{where}: {number_text(one)} is out of range")
    return [float(one) for one in value]


def _check_vector(value: Any) -> list[float]:
    return _checked_vector("vector", value, _EXTENT_MM)


def _check_place(value: Any) -> list[float] | None:
    return None if value is None else _check_vector(value)


def _check_box(value: Any) -> list[list[float]] | None:
    if value is None:
        return None
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError("must be two corners, [[x, y, z], [x, y, z]]")
    low, high = (_check_vector(corner) for corner in value)
    if not all(a < b for a, b in zip(low, high, strict=True)):
        raise ValueError("the first corner must be lower than the second in x, y and z")
    return [low, high]


_VECTOR = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}

_OBJECTS = WithJsonSchema({"type": "array", "items": {"type": "object"}})

_Place = Annotated[
    Any, PlainValidator(_check_place), WithJsonSchema({"anyOf": [_VECTOR, {"type": "null"}]})
]

_Vector = Annotated[Any, PlainValidator(_check_vector), WithJsonSchema(_VECTOR)]

_Box = Annotated[
    Any,
    PlainValidator(_check_box),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "array", "items": _VECTOR, "minItems": 2, "maxItems": 2},
                {"type": "null"},
            ]
        }
    ),
]


class ArcKeys(Section):
    """A curved chute, for kind: arc. Its slope goes from one angle to the other."""

    radius_mm: _LENGTH = _geometry_key(400.0, "Radius.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]
    begin: _number_or_range(-90.0, 90.0) = _geometry_key(  # type: ignore[valid-type]
        80.0, "Slope at the first end, the origin.", "deg", -90.0, 90.0
    )
    end: _number_or_range(-90.0, 90.0) = _geometry_key(  # type: ignore[valid-type]
        10.0, "Slope at the last end; below begin: a spoon, above: a hump.", "deg", -90.0, 90.0
    )
    width_mm: _LENGTH = _geometry_key(300.0, "Extent across the slope.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]


class MeshKeys(Section):
    """A mesh file, for kind: mesh. Named solids of an STL file are its parts."""

    file: Text | None = setting(
        None, "The mesh.", allowed="the path of a file, .stl, .obj or .ply, or null"
    )
    unit: Literal["mm", "cm", "m", "in"] = setting("mm", "Unit of the coordinates in the file.")
    up: Literal["x", "y", "z"] = setting("z", "Axis of the file that points up.")
    repair: bool = setting(
        False,
        "Whether triangles without area or given twice are left out; otherwise they are an error.",
        allowed="true or false",
    )
    offset_mm: _Vector = setting(
        [0.0, 0.0, 0.0], "Added to all positions once y points up.", unit="mm", allowed="[x, y, z]"
    )


class ScrewKeys(Section):
    """A screw conveyor along x in a trough, for kind: screw. It conveys to its open end, x = 0."""

    length_mm: _LENGTH = _geometry_key(400.0, "Length.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]
    radius_mm: _LENGTH = _geometry_key(75.0, "Radius of the flight.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]
    shaft_radius_mm: _LENGTH = _geometry_key(20.0, "Radius of the shaft.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]
    pitch_mm: _LENGTH = _geometry_key(100.0, "Advance in a turn.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]
    clearance_mm: _LENGTH = _geometry_key(5.0, "Between flight and trough.", "mm", 0.0, _EXTENT_MM)  # type: ignore[valid-type]
    rim_mm: _LENGTH = _geometry_key(  # type: ignore[valid-type]
        100.0, "Height of the walls of the trough above the axis.", "mm", 0.0, _EXTENT_MM
    )
    rev_per_min: _number_or_range(-1e4, 1e4) = _geometry_key(  # type: ignore[valid-type]
        60.0, "Speed of the screw.", "rev/min", -1e4, 1e4
    )


class GeometryKeys(Section):
    """What the particles wear: the plate, or another surface.

    With another surface, facet_size_mm, patch_length_mm, patch_width_mm and fall_height_mm keep
    their meaning, and the factory angle none, so it is held at 0, and so is the plate angle if no
    plate of a chain takes it. Numbers of a chain, an arc and a screw may be ranges, which are
    sampled.
    """

    kind: Literal["plate", "plates", "arc", "mesh", "screw"] = setting(
        "plate",
        "plate: a flat rectangle, simulation.plate. plates: a chain of them. arc: a curved chute. "
        "mesh: a file. screw: a screw conveyor.",
    )
    plates: Annotated[Any, PlainValidator(_check_chain), _OBJECTS] = setting(
        [],
        "Plates of the chain. The centre of the first is the origin. A plate runs from its first "
        "end along (-cos angle, -sin angle), so that positive angles below 90 run down along -x; "
        "angle: plate_angle is the sampled plate angle. gap_mm (along the direction of the plate "
        "before) and drop_mm (down) lie between its first end and the last end of the plate "
        "before; belt_m_s is the speed of its surface along it.",
        allowed="a list of {length_mm, width_mm, angle, gap_mm, drop_mm, belt_m_s, name}",
    )
    arc: ArcKeys = Field(default_factory=ArcKeys, description="The arc.")
    mesh: MeshKeys = Field(default_factory=MeshKeys, description="The mesh.")
    screw: ScrewKeys = Field(default_factory=ScrewKeys, description="The screw.")
    moving: Annotated[Any, PlainValidator(_check_moving), _OBJECTS] = setting(
        [],
        "What parts of a mesh do: a belt has a surface velocity, another part turns.",
        allowed="a list of {part, belt_m_s: [x, y, z]} or {part, rev_per_min, axis_point_mm: "
        "[x, y, z], axis: [x, y, z]}",
    )
    factory_centre_mm: _Place = setting(
        None,
        "Centre of the factory patch, which is level; null: fall_height_mm above the first plate, "
        "the upper part of the arc, the middle of the mesh or the closed end of the screw.",
        unit="mm",
        allowed="[x, y, z] or null",
    )
    jet_direction: _Vector = setting(
        [0.0, -1.0, 0.0],
        "Direction of the velocity at the release; the speed is that of particle_velocity_y.",
        allowed="[x, y, z]",
    )
    removal_box_mm: _Box = setting(
        None,
        "Corners of the box outside which particles are removed; null: below the lowest point, "
        "removal_depth_mm.",
        unit="mm",
        allowed="[[x, y, z], [x, y, z]] or null",
    )
