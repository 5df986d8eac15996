"""Declaration of the configuration: every key with its default, unit and allowed values."""

from __future__ import annotations

import datetime
import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationInfo,
    WithJsonSchema,
    create_model,
    field_validator,
)

from abradem import quantities
from abradem.config.batches import batches_of_block
from abradem.config.quantity_texts import material_meant, of_material, read_quantity
from abradem.config.scalars import STUDY_NAME, number_meant, written, yaml_float
from abradem.quantities import MOST_PLATES, SAMPLED, STATISTICS, WEAR_MEASURES, Quantity
from abradem.words.labels import LABELS

_URL = r"^https://[A-Za-z0-9._~:/?#\[\]@!$&'()*+,;=%-]+$"
"""An address in the characters of RFC 3986; others are written as %XX."""

_BIDIRECTIONAL = {*range(0x202A, 0x202F), *range(0x2066, 0x206A)}
"""Characters that turn the direction of the text that follows."""


def _check_text(value: str) -> str:
    if not value.strip():
        raise ValueError("must not be empty")
    for char in value:
        if unicodedata.category(char) in ("Cc", "Cs", "Zl", "Zp") or ord(char) in _BIDIRECTIONAL:
            raise ValueError(f"contains the control character U+{ord(char):04X}")
    return value


_DAY = r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$"


def _check_day(value: str) -> str:
    if not re.fullmatch(_DAY, value):
        raise ValueError("has the wrong form")
    try:
        datetime.date.fromisoformat(value)
    except ValueError:
        raise ValueError("there is no such day") from None
    return value


Day = Annotated[
    str, AfterValidator(_check_day), WithJsonSchema({"type": "string", "pattern": _DAY})
]
Text = Annotated[
    str, AfterValidator(_check_text), WithJsonSchema({"type": "string", "pattern": r"\S"})
]
"""A name, a title or a path: one line with something in it."""


class Section(BaseModel):
    # Strict: a number in quotes is a mistake, and true is not 1.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, value: Any, info: ValidationInfo) -> Any:
        """Read "2 cm" as a number in the unit of its key."""
        extra = cls.model_fields[str(info.field_name)].json_schema_extra
        unit = extra.get("unit", "") if isinstance(extra, dict) else ""
        return read_quantity(value, str(unit))


def _key(default: Any, description: str, *, unit: str = "", allowed: str = "", **bounds) -> Any:
    """Return a field with its help text, its unit and, if bounds do not suffice, its limits."""
    given = {"unit": unit, "allowed": allowed}
    extra: dict[str, Any] = {name: text for name, text in given.items() if text}
    return Field(default, description=description, json_schema_extra=extra or None, **bounds)


def _range_field(row: Quantity) -> tuple[Any, Any]:
    """Return annotation and field for the range of a quantity, in the unit of its key."""
    low, high = (_from_si(row, bound) for bound in row.limits)

    def check(value: Any) -> tuple[float, float]:
        bounds = value if isinstance(value, (list, tuple)) else [value, value]
        if len(bounds) != 2:
            raise ValueError("must be one number or two, [lower bound, upper bound]")
        found = [of_material(bound, row.name) for bound in bounds]
        bounds = [
            bound if of is None else _from_si(row, of)
            for bound, of in zip(bounds, found, strict=True)
        ]
        for bound in bounds:
            if material := material_meant(bound, row.name):
                raise ValueError(f"must be a number; did you mean {material}?")
            _require_number(bound, low, high)
            if not low <= bound <= high:
                raise ValueError(f"{number_text(bound)} is out of range{_unit_slip(row, bounds)}")
        if bounds[0] > bounds[1]:
            raise ValueError("lower bound must not exceed the upper bound")
        return float(bounds[0]), float(bounds[1])

    number = {"type": "number", "minimum": low, "maximum": high}
    pair = {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    annotation = Annotated[Any, PlainValidator(check), WithJsonSchema({"anyOf": [number, pair]})]
    unit = "" if row.config_unit == "1" else row.config_unit
    default = tuple(_from_si(row, bound) for bound in row.paper_range)
    help_text = f"{row.symbol}, {LABELS[row.name].long_name}."
    return annotation, _key(default, help_text, unit=unit, allowed=interval_text(low, high, unit))


def interval_text(low: float, high: float, unit: str = "", above: bool = False) -> str:
    first = f"above {number_text(low)} up to" if above else f"{number_text(low)} ..."
    return f"{first} {number_text(high)}{f' {unit}' if unit else ''}"


def number_text(value: float) -> str:
    return str(value) if isinstance(value, int) else yaml_float(f"{value:g}")


def _from_si(row: Quantity, value: float) -> float:
    """Return ``value`` in the unit of its key, without the rounding error of 40e-3 / 1e-3."""
    return float(f"{value / row.config_factor:.12g}")


def to_si(row: Quantity, value: float) -> float:
    """Return ``value`` of the configuration in the unit of the quantity in tables."""
    if row.config_factor < 1.0:
        # 7 / 1000 is the double nearest to 0.007; 7 * 1e-3 need not be.
        return value / round(1.0 / row.config_factor)
    return value * row.config_factor


def _unit_slip(row: Quantity, bounds: Sequence[float]) -> str:
    """Return a hint if ``bounds`` are plausible in the SI unit instead of the unit of the key."""
    low, high = row.limits
    if not row.config_suffix or not all(
        isinstance(bound, (int, float)) and low <= bound <= high for bound in bounds
    ):
        return ""
    meant = ", ".join(number_text(_from_si(row, bound)) for bound in bounds)
    return f"; the key is in {row.config_unit}, for values in {row.unit} write [{meant}]"


def _require_number(value: Any, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(not_a_number(value, "a number", low, high))
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("must be a finite number")


def not_a_number(
    value: Any, wanted: str, low: float = -math.inf, high: float = math.inf, above: bool = False
) -> str:
    """Return why ``value`` is not a number, with a hint if it looks like one.

    The number of the hint is accepted: it is within the bounds, and YAML reads it as a number.

    Parameters
    ----------
    value
    wanted : str
        ``a number``, ``a whole number`` or ``auto or a whole number``.
    low, high : float
        Bounds of the key.
    above : bool
        Whether the lower bound itself is not allowed.
    """
    whole = "whole" in wanted
    if isinstance(value, float) and whole and value.is_integer():
        meant: int | float | None = int(value)
    else:
        meant = number_meant(value) if isinstance(value, str) else None
    if meant is None:
        if isinstance(value, str) and number_meant(value.replace(",", ".", 1)) is not None:
            return f"must be {wanted}, with a decimal point instead of a comma"
        return f"must be {wanted}"
    if not low <= meant <= high or (above and meant == low):
        return f"must be {wanted} in the allowed range"
    if whole and not isinstance(meant, int):
        return f"must be {wanted}"
    if not isinstance(value, str):
        return f"must be {wanted}; write {meant}"
    same = value.strip() == written(meant, isinstance(meant, int))
    if same:
        return f"must be {wanted}, not text; write it without quotes"
    return f"must be {wanted}; YAML reads this as text, write {written(meant, whole)}"


_FIELDS: dict[str, Any] = {row.config_key: _range_field(row) for row in SAMPLED}
_RANGES: Any = create_model("Ranges", __base__=Section, **_FIELDS)


class Ranges(_RANGES):
    """Ranges of the 14 sampled quantities.

    Each is [lower bound, upper bound], or one number for a fixed quantity. A number may have a
    unit (``2 cm``), and the name of a material, such as ``granite``, stands for its value
    (``abradem predict --help`` lists them). The default of each key is the range of the paper.
    """


class Sampling(Section):
    """Which parameter sets are simulated."""

    method: Literal["lhs", "sobol", "uniform"] = _key(
        "lhs",
        "How the parameter sets of a block are drawn: Latin hypercube (covers the range of each "
        "quantity evenly), scrambled Sobol sequence (fills the space evenly, best with 2^n cases "
        "in total) or independent uniform random numbers.",
    )
    blocks: int = _key(
        2,
        "Number of blocks. More blocks add cases; all existing cases stay the same.",
        ge=1,
        le=10_000,
    )
    cases_per_block: int = _key(
        100,
        "Cases in one block. If it is changed, all blocks are drawn again; to enlarge a study, add "
        "blocks instead.",
        ge=1,
        le=100_000,
    )
    ranges: Ranges = Field(
        default_factory=Ranges, description="Ranges of the 14 sampled quantities."
    )


class PlateKeys(Section):
    """The plate: a flat rectangle, tilted about its centre by the plate angle."""

    length_mm: float = _key(300.0, "Extent along the slope.", unit="mm", gt=0.0, le=100_000.0)
    width_mm: float = _key(300.0, "Extent across the slope.", unit="mm", gt=0.0, le=100_000.0)
    facet_size_mm: float = _key(
        10.0,
        "Largest edge of a wear facet; the plate is divided into equal facets. Unless "
        "wear_rate.element_size_mm is given, the maximum and the 99th percentile depend on it.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )


_EXTENT_MM = 100_000.0
"""Largest length of a geometry, mm."""


def _number_or_range(low: float, high: float, above: bool = False) -> Any:
    """Return the type of a number that a range of two numbers samples."""

    def check(value: Any) -> float | tuple[float, float]:
        bounds = value if isinstance(value, (list, tuple)) else [value]
        if len(bounds) not in (1, 2):
            raise ValueError("must be one number or two, [lower bound, upper bound]")
        for bound in bounds:
            _require_number(bound, low, high)
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
    return _key(default, description, unit=unit, allowed=allowed)


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
            _require_number(one, -1e4, 1e4)
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
        _require_number(one, -most, most)
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

    file: Text | None = _key(
        None, "The mesh.", allowed="the path of a file, .stl, .obj or .ply, or null"
    )
    unit: Literal["mm", "cm", "m", "in"] = _key("mm", "Unit of the coordinates in the file.")
    up: Literal["x", "y", "z"] = _key("z", "Axis of the file that points up.")
    repair: bool = _key(
        False,
        "Whether triangles without area or given twice are left out; otherwise they are an error.",
        allowed="true or false",
    )
    offset_mm: _Vector = _key(
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

    kind: Literal["plate", "plates", "arc", "mesh", "screw"] = _key(
        "plate",
        "plate: a flat rectangle, simulation.plate. plates: a chain of them. arc: a curved chute. "
        "mesh: a file. screw: a screw conveyor.",
    )
    plates: Annotated[Any, PlainValidator(_check_chain), _OBJECTS] = _key(
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
    moving: Annotated[Any, PlainValidator(_check_moving), _OBJECTS] = _key(
        [],
        "What parts of a mesh do: a belt has a surface velocity, another part turns.",
        allowed="a list of {part, belt_m_s: [x, y, z]} or {part, rev_per_min, axis_point_mm: "
        "[x, y, z], axis: [x, y, z]}",
    )
    factory_centre_mm: _Place = _key(
        None,
        "Centre of the factory patch, which is level; null: fall_height_mm above the first plate, "
        "the upper part of the arc, the middle of the mesh or the closed end of the screw.",
        unit="mm",
        allowed="[x, y, z] or null",
    )
    jet_direction: _Vector = _key(
        [0.0, -1.0, 0.0],
        "Direction of the velocity at the release; the speed is that of particle_velocity_y.",
        allowed="[x, y, z]",
    )
    removal_box_mm: _Box = _key(
        None,
        "Corners of the box outside which particles are removed; null: below the lowest point, "
        "removal_depth_mm.",
        unit="mm",
        allowed="[[x, y, z], [x, y, z]] or null",
    )


class Factory(Section):
    """Release of the particles: position and rate."""

    patch_length_mm: float = _key(
        300.0,
        "Extent of the patch of particle centres along its slope.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    patch_width_mm: float = _key(
        300.0,
        "Extent of the patch of particle centres across its slope.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    fall_height_mm: float = _key(
        475.0,
        "Height of the centre of the patch above the centre of the plate at a factory angle of 0.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    angle_acts: Literal["tilt", "level", "arc"] = _key(
        "arc",
        "How the factory angle acts. tilt: the patch is tilted about its centre, so the jet "
        "narrows. level: the patch stays level, and the angle does nothing. arc: the level patch "
        "is lower by arc_radius times 1 - cos(factory angle).",
    )
    arc_radius_mm: float = _key(
        310.0, "Radius of the arc, for angle_acts: arc alone.", unit="mm", ge=0.0, le=100_000.0
    )
    feed: Literal["mass", "number"] = _key(
        "mass", "Which rate is prescribed: mass per time or particles per time."
    )
    mass_rate_kg_s: float | None = _key(
        45.0, "Mass rate for feed: mass, otherwise null.", unit="kg/s", gt=0.0, le=1e6
    )
    number_rate_per_s: float | None = _key(
        None, "Particle rate for feed: number, otherwise null.", unit="1/s", gt=0.0, le=1e9
    )
    attempts: int = _key(
        1, "Random places on the patch that are tried for a particle.", ge=1, le=10_000
    )
    unplaced: Literal["wait", "skip"] = _key(
        "skip",
        "What becomes of a particle that overlaps others at all places tried. wait: it is tried "
        "again a little later, before those that follow. skip: it is left out, and its share of "
        "the feed is lost.",
    )


class Contact(Section):
    """Options of the contact law that the paper does not specify."""

    normal: Literal["exact_e", "nominal_clipped", "nominal_attractive"] = _key(
        "exact_e",
        "exact_e: never attractive, and an isolated impact rebounds at exactly e. "
        "nominal_clipped: the textbook damping, clipped so that it is never attractive. "
        "nominal_attractive: the textbook damping, which is attractive at the end of a contact.",
    )
    tangential: Literal["incremental", "displacement"] = _key(
        "incremental",
        "incremental: the spring force is accumulated step by step. displacement: it is the "
        "stiffness times the accumulated displacement, as documented for one commercial code.",
    )
    tangential_damping: Literal["capped", "none", "uncapped"] = _key(
        "capped",
        "capped: Coulomb's law limits the sum of spring and damping force. uncapped: it limits "
        "only the spring force. none: no tangential damping.",
    )


class PairInteraction(Section):
    """Contact between particles, if it differs from the contact between particle and plate."""

    restitution: float = _key(..., "Coefficient of restitution.", ge=0.05, le=1.0)
    static_friction: float = _key(..., "Coefficient of static friction.", ge=0.0, le=2.0)
    rolling_friction: float = _key(..., "Coefficient of rolling friction.", ge=0.0, le=1.0)


class Stop(Section):
    """Stop rule: when a simulation ends."""

    window_s: float = _key(
        2.0,
        "Steady time over which the wear of the facets is recorded; also the shortest steady time "
        "that is simulated.",
        unit="s",
        gt=0.0,
        le=10_000.0,
    )
    max_time_s: float = _key(
        8.0, "Longest simulated time of a case.", unit="s", gt=0.0, le=100_000.0
    )
    target_stderr: float = _key(
        0.2,
        "A case ends when its mean `total` rate is known to this relative standard error.",
        gt=0.0,
        le=1.0,
    )
    sample_interval_s: float = _key(
        0.02, "Time between samples of the worn volume.", unit="s", gt=0.0, le=100.0
    )


class Export(Section):
    """Snapshots of positions, velocities, contact forces and wear; large files, off by default."""

    cases: list[Annotated[int, Field(ge=0)]] = _key(
        [],
        "Cases to export; nothing is exported if the list is empty.",
        allowed="a list of case numbers from 0",
    )
    interval_s: float = _key(0.01, "Simulated time between snapshots.", unit="s", gt=0.0, le=1000.0)


def _check_cases_per_job(value: Any) -> str | int:
    if value == "auto":
        return value
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(not_a_number(value, "auto or a whole number", 1, 100_000))
    if not 1 <= value <= 100_000:
        raise ValueError("is out of range")
    return value


class Simulation(Section):
    """All settings of a simulation that are not sampled."""

    cases_per_job: Annotated[
        str | int,
        PlainValidator(_check_cases_per_job),
        WithJsonSchema(
            {"anyOf": [{"const": "auto"}, {"type": "integer", "minimum": 1, "maximum": 100_000}]}
        ),
    ] = _key(
        "auto",
        "Number of cases that one job simulates. Starting a job takes seconds, so several cases "
        "share a job; with 1 each case has its own job.",
        allowed="auto or 1 ... 100000",
    )
    stepping: Literal["islands", "synchronous"] = _key(
        "islands",
        "Time stepping: islands skips the time in which nothing touches, synchronous steps every "
        "particle in every step. Both give bitwise equal results.",
    )
    threads: int = _key(
        1,
        "Threads of one simulation, for a machine with more cores than jobs: they share the "
        "particles of crowds. Results do not depend on it, and a change repeats nothing. Leave 1 "
        "where the jobs of a study fill the cores; a geometry other than the plate always uses 1.",
        ge=1,
        le=64,
    )
    time_step_rayleigh_fraction: float = _key(
        0.2,
        "Time step as a fraction of the Rayleigh time of the particle. With 0.15 an impact near "
        "5 m/s takes about 21 steps; the bias of total is at most 0.8 % averaged over the impact "
        "angle and at most 3 % at a single angle, with the paper's 0.2 1.3 % and 5 %. A case "
        "whose first impact the step biases by more than 5 % is refused.",
        ge=0.001,
        le=0.4,
    )
    plate: PlateKeys = Field(default_factory=PlateKeys, description="The plate.")
    geometry: GeometryKeys = Field(
        default_factory=GeometryKeys, description="What the particles wear."
    )
    factory: Factory = Field(
        default_factory=Factory, description="Release of the particles: position and rate."
    )
    removal_depth_mm: float = _key(
        100.0,
        "Depth below the lowest point of the plate at which particles are removed.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    gravity: float = _key(
        quantities.GRAVITY, "Gravitational acceleration, downwards.", unit="m/s2", ge=0.0, le=1000.0
    )
    contact: Contact = Field(default_factory=Contact, description="Options of the contact law.")
    pair_interaction: PairInteraction | None = _key(
        None, "Contact between particles; null: the sampled values of particle and plate apply."
    )
    stop: Stop = Field(default_factory=Stop, description="When a simulation ends.")
    max_failed_share: float = _key(
        0.2,
        "Largest share of cases that may fail or be rejected; above it no data set is written. "
        "failures.parquet lists the reason for each case.",
        ge=0.0,
        le=1.0,
    )
    export: Export = Field(default_factory=Export, description="Snapshots of selected cases.")


class WearRate(Section):
    """Wear rates and their quality, from the worn volume over time."""

    min_batches: int = _key(
        20,
        "Smallest number of equal batches for a rate and its standard error; twice as many "
        "are used where the samples suffice.",
        ge=20,
        le=10_000,
    )
    footprint_share: float = _key(
        0.95,
        "The footprint is the smallest set of elements with this share of the wear.",
        gt=0.0,
        le=1.0,
    )
    element_size_mm: float | None = _key(
        30.0,
        "Edge of the elements of the statistics worn, footprint, p99 and max: a whole number of "
        "facets, and a whole part of the plate. null: the facets.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    good_r2: float = _key(
        0.95,
        "A series counts as good if the R2 of its straight line is at least this.",
        ge=0.0,
        le=1.0,
    )


class Features(Section):
    """The derived quantities."""

    damping_coefficient: Literal["table", "printed"] = _key(
        "table",
        "Formula of X20. table: 2 sqrt(5/6) xi sqrt(m k) with k = 4/3 E* R, as in the data of the "
        "paper (negative). printed: -2 sqrt(m k_n) ln e / sqrt(ln^2 e + pi^2), as printed in the "
        "paper.",
    )


_TARGETS = tuple(
    f"wear_{measure}_{statistic}" for measure in WEAR_MEASURES for statistic in STATISTICS
)


class Penalised(Section):
    """Lasso and ridge.

    As published, the penalties are given below; leakage-free, they are cross-validated.
    """

    lasso_alpha: float = _key(0.1, "Penalty of the lasso as published.", gt=0.0, le=1e6)
    ridge_alpha: float = _key(1.0, "Penalty of the ridge as published.", gt=0.0, le=1e6)
    path_points: int = _key(40, "Number of penalties tried on each path.", ge=5, le=1000)


class Selection(Section):
    """Selection of the input features of the networks."""

    features: int = _key(12, "Number of selected features.", ge=2, le=20)


class Trees(Section):
    """Decision tree and random forest."""

    max_depth: int = _key(49, "Largest depth in the curve of score over depth.", ge=1, le=100)
    forest_trees: int = _key(100, "Number of trees in the forest.", ge=1, le=10_000)


class GaAnn(Section):
    """Networks with an architecture that is found by a genetic search."""

    population: int = _key(10, "Networks per generation.", ge=2, le=1000)
    generations: int = _key(25, "Generations per search.", ge=1, le=10_000)
    min_layers: int = _key(2, "Smallest number of hidden layers.", ge=1, le=20)
    max_layers: int = _key(6, "Largest number of hidden layers.", ge=1, le=20)
    min_neurons: int = _key(10, "Smallest number of neurons per layer.", ge=1, le=10_000)
    max_neurons: int = _key(500, "Largest number of neurons per layer.", ge=1, le=10_000)
    selection: Literal["tournament", "roulette"] = _key(
        "tournament",
        "Selection of parents: tournament takes the best of a few random networks, roulette "
        "draws with a probability proportional to the fitness.",
    )
    tournament_size: int = _key(3, "Networks per tournament.", ge=1, le=1000)
    crossover: float = _key(0.9, "Probability that two parents exchange layers.", ge=0.0, le=1.0)
    mutation: float = _key(
        0.2,
        "Probability that one layer of a child and its start weights change.",
        ge=0.0,
        le=1.0,
    )
    mutation_size: float = _key(
        0.2, "Largest relative change of the number of neurons in that layer.", gt=0.0, le=1.0
    )
    elites: int = _key(1, "Number of best networks that are kept unchanged.", ge=0, le=999)
    weights: Literal["seed", "inherited"] = _key(
        "seed",
        "Start weights of a child: random from a seed, or the trained weights of its first "
        "parent, as far as the layers overlap.",
    )
    epochs: int = _key(20, "Epochs of a training during the search.", ge=1, le=100_000)
    batch: int = _key(32, "Rows per mini-batch during the search.", ge=1, le=1_000_000)
    final_epochs: int = _key(60, "Epochs of a training of the best network.", ge=1, le=100_000)
    final_batch: int = _key(50, "Rows per mini-batch for the best network.", ge=1, le=1_000_000)
    learning_rate: float = _key(0.001, "Learning rate of the optimiser (Adam).", gt=0.0, le=1.0)
    validation_share: float = _key(
        0.25,
        "Share of the training rows that the fitness is computed on (leakage-free).",
        ge=0.05,
        le=0.9,
    )
    retrainings: int = _key(
        10, "Trainings of the best network from different start weights.", ge=1, le=1000
    )
    searches: int = _key(
        5,
        "Number of leakage-free searches, each in the training rows of a different split, which "
        "take that many times as long as one; at most one for each of learning.repeats splits. On "
        "all other splits the network found by the first search is trained and scored.",
        ge=1,
        le=1000,
    )
    device: Literal["cpu", "cuda"] = _key(
        "cpu",
        "Device for the training of networks: cpu trains one per core, cuda trains batches of "
        "networks on a GPU.",
    )


class Physical(Section):
    """Physics-informed models of the wear number on dimensionless groups, and their intervals."""

    boosting_trees: int = _key(400, "Number of boosted trees.", ge=1, le=100_000)
    boosting_depth: int = _key(4, "Largest depth of a boosted tree.", ge=1, le=50)
    networks: int = _key(4, "Networks in the ensemble.", ge=1, le=1000)
    network_steps: int = _key(
        1000, "Number of mini-batches that each network is trained on.", ge=1, le=10_000_000
    )
    interval_folds: int = _key(
        10,
        "Folds for the calibration and the test of the prediction intervals.",
        ge=2,
        le=1000,
    )
    target_repeats: int = _key(
        5,
        "Random splits for the scores of every target, and number of permutations.",
        ge=1,
        le=10_000,
    )
    curve_repeats: int = _key(10, "Random splits for the learning curve.", ge=1, le=10_000)
    sobol_points: int = _key(
        2048,
        "Number of base points for the Sobol indices.",
        ge=8,
        le=2**20,
        allowed="a power of two from 8 to 1048576",
    )


class Noise(Section):
    """Repeated simulations with other seeds, for the random part of a simulated wear rate."""

    cases: int = _key(
        10, "Number of repeated cases, among those with large particles.", ge=1, le=10_000
    )
    replicates: int = _key(8, "Simulations of each of these cases.", ge=1, le=10_000)


class SurrogateModel(Section):
    """The small network that `abradem predict` uses."""

    points: int = _key(
        20_000,
        "Number of points at which it is trained on the Gaussian process.",
        ge=100,
        le=10_000_000,
    )
    hidden: list[Annotated[int, Field(ge=1, le=10_000)]] = _key(
        [64, 64],
        "Number of neurons in each hidden layer.",
        allowed="a list of numbers from 1 to 10000",
        min_length=1,
        max_length=10,
    )
    epochs: int = _key(40, "Epochs of the training.", ge=1, le=100_000)
    timed_cases: int = _key(
        5,
        "Cases that are simulated again to compare the run times of engine and network.",
        ge=1,
        le=10_000,
    )


class Learning(Section):
    """Models of the data set, each as published and leakage-free (docs/learning.md)."""

    target: Literal[_TARGETS] = _key(  # type: ignore[valid-type]  # names of a table
        "wear_friction_p99", "Column of the data set to predict."
    )
    part: Text | None = _key(
        None,
        "Named part of simulation.geometry whose wear the models explain, such as a plate of a "
        "chain or a solid of a mesh; null: the whole surface. The rates of a part have no standard "
        "error.",
        allowed="the name of a part or null",
    )
    test_share: float = _key(
        0.2, "Share of the cases held out as test set of each fit (leakage-free).", ge=0.05, le=0.9
    )
    repeats: int = _key(
        20, "Number of random training/test splits for the scores of a model.", ge=1, le=10_000
    )
    folds: int = _key(5, "Folds of the cross-validation in the training rows.", ge=2, le=1000)
    confidence: float = _key(0.95, "Confidence level of all intervals.", ge=0.5, le=0.9999)
    bootstrap: int = _key(
        2000,
        "Bootstrap samples of the test rows for the interval of a single split.",
        ge=100,
        le=1_000_000,
    )
    fresh_blocks: int = _key(
        0,
        "Blocks of cases simulated for the test of the prediction intervals alone, and seen by no "
        "model; 0: none. Two blocks of 100 cases tell shares of regions apart.",
        ge=0,
        le=1000,
    )
    penalised: Penalised = Field(default_factory=Penalised, description="Lasso and ridge.")
    selection: Selection = Field(
        default_factory=Selection, description="Selection of the input features of the networks."
    )
    trees: Trees = Field(default_factory=Trees, description="Decision tree and random forest.")
    ga_ann: GaAnn = Field(
        default_factory=GaAnn,
        description="Networks with an architecture that is found by a genetic search.",
    )
    physical: Physical = Field(
        default_factory=Physical,
        description="Physics-informed models on dimensionless groups (docs/physical.md).",
    )
    noise: Noise = Field(
        default_factory=Noise, description="Repeated simulations for the random part of a rate."
    )
    surrogate: SurrogateModel = Field(
        default_factory=SurrogateModel, description="The model that `abradem predict` uses."
    )


def _check_columns(value: Any) -> dict[str, str | list[str]]:
    if not isinstance(value, Mapping):
        raise ValueError("must map names of quantities to columns of the table")
    for name, column in value.items():
        pair = isinstance(column, (list, tuple))
        parts = column if pair else [column]
        if not all(isinstance(part, str) and part for part in parts) or (pair and len(parts) != 2):
            raise ValueError(f"{name}: must be a column name, or [column, unit]")
        for part in (str(name), *parts):
            _check_text(part)
    return {str(name): column for name, column in value.items()}


_COLUMNS_SCHEMA = WithJsonSchema(
    {
        "type": "object",
        "additionalProperties": {
            "anyOf": [
                {"type": "string"},
                {
                    "type": "array",
                    "items": {"type": "string"},
                    "minItems": 2,
                    "maxItems": 2,
                },
            ]
        },
    }
)


def _check_search(value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError("must map keys of simulation to what they may be")
    return {str(key): _in_units(str(key), values) for key, values in value.items()}


def _in_units(names: str, values: Any) -> Any:
    """Return what the keys of a search may be, with texts that have a unit as numbers."""
    keys = [key.strip() for key in names.split(",")]
    units = {_unit_of(key) for key in keys}
    given = values if isinstance(values, Mapping) else {"": values}
    try:
        read = {name: read_quantity(one, next(iter(units))) for name, one in given.items()}
    except ValueError as error:
        raise ValueError(f"{names}: {error}") from None
    if len(units) > 1 and read != given:
        raise ValueError(f"{names}: keys of different units share a value, give it without a unit")
    return read if isinstance(values, Mapping) else read[""]


def _unit_of(key: str) -> str:
    """Return the unit of a dotted key of `simulation`; "" if it has none or is unknown."""
    _, *path = key.split(".")
    section: Any = Simulation
    unit = ""
    for part in path:
        field = getattr(section, "model_fields", {}).get(part)
        if field is None:
            return ""
        extra = field.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        kinds = (field.annotation, *get_args(field.annotation))
        section = next((kind for kind in kinds if hasattr(kind, "model_fields")), None)
    return unit


_SEARCH_SCHEMA = WithJsonSchema(
    {"type": "object", "additionalProperties": {"anyOf": [{"type": "array"}, {"type": "object"}]}}
)


STATED, UNKNOWN = "stated", "unknown"


class Dataset(Section):
    """Your own table instead of simulations."""

    external: Text | None = _key(
        None,
        "CSV or Parquet file. Learning, figures and report then use this table, and nothing is "
        "simulated. With null the data set is simulated.",
        allowed="the path of a file or null",
    )
    columns: Annotated[Any, PlainValidator(_check_columns), _COLUMNS_SCHEMA] = _key(
        {},
        "Column of the table for each quantity with a different column name, or [column, unit] if "
        "the unit differs too. The names and units of the published table of the paper are known.",
        allowed="{name: column} or {name: [column, unit]}",
    )
    jet: Literal["stated", "unknown"] = _key(
        UNKNOWN,
        "Whether simulation.plate, simulation.factory (feed, patch, fall height) and "
        "simulation.gravity are those of the table. Unknown: the models use them as a reference "
        "alone, and the surrogate says so.",
    )
    rate: Literal["stated", "unknown"] = _key(
        UNKNOWN,
        "Whether learning.target says what the wear rate of the table is: its measure and its "
        "place on the plate. Unknown: figures and predictions do not name them.",
    )


class Calibration(Section):
    """A search for the set-ups that explain a table of wear rates, instead of a study.

    The other keys give what is known of the set-up.
    """

    table: str | None = _key(
        None,
        "CSV or Parquet file with the sampled quantities and a wear rate; null: no search.",
        allowed="the path of a file or null",
    )
    columns: Annotated[Any, PlainValidator(_check_columns), _COLUMNS_SCHEMA] = _key(
        {},
        "Columns of the table with other names, as for dataset.columns.",
        allowed="{name: column} or {name: [column, unit]}",
    )
    target: Literal[_TARGETS] = _key(  # type: ignore[valid-type]  # names of a table
        quantities.TARGET.name, "Column of the table to explain."
    )
    search: Annotated[Any, PlainValidator(_check_search), _SEARCH_SCHEMA] = _key(
        {},
        "What is unknown: for each key of simulation (or keys, separated by commas, that share a "
        "value) a list of values, or bounds with a scale (linear or log).",
        allowed="{key: [value, value]} or {key: {from: low, to: high, scale: log}}",
    )
    element_sizes_mm: list[Annotated[float, Field(gt=0.0, le=100_000.0)]] = _key(
        [10.0, 20.0, 30.0, 50.0],
        "Edges of the elements of the statistics; all are tried, from one simulation.",
        allowed="a list of whole multiples of the facets",
        min_length=1,
    )
    constant: bool = _key(
        False,
        "true: set-ups are judged after a constant factor is fitted; false: without one.",
        allowed="true or false",
    )
    least_radius_mm: float = _key(
        0.0, "Rows with smaller particles are left out.", unit="mm", ge=0.0, le=100.0
    )
    leave_out: list[Annotated[int, Field(ge=0)]] = _key(
        [],
        "Rows that are left out, by case_id or, without that column, by their number from 0: those "
        "known to be wrong.",
        allowed="a list of whole numbers from 0 on",
    )
    held_out_every: int = _key(
        4,
        "Every so many rows, in the order of their wear rate, one is held out; 0: none.",
        ge=0,
        le=1000,
    )
    trials: int = _key(64, "Number of set-ups drawn.", ge=1, le=100_000)
    keep: float = _key(0.25, "Share of the set-ups that goes on to the next rung.", gt=0.0, le=1.0)
    rows: list[Annotated[int, Field(ge=4, le=1_000_000)]] = _key(
        [16, 40, 1_000_000],
        "Rows of the table in each rung; more than there are: all.",
        allowed="a list of whole numbers from 4 on",
        min_length=1,
    )
    replicates: list[Annotated[int, Field(ge=1, le=1000)]] = _key(
        [2, 2, 4],
        "Simulations of each row in each rung, with different seeds.",
        allowed="a list of whole numbers, as many as rows",
        min_length=1,
    )


class Typical(Section):
    """The representative case in figures: the middle of all ranges, except for these values.

    With a geometry a value outside its range gives way to the middle of the range.
    """

    plate_angle: float = _key(35.0, "Plate angle.", unit="deg", ge=-90.0, le=90.0)
    factory_angle: float = _key(-30.0, "Factory angle.", unit="deg", ge=-90.0, le=90.0)
    particle_radius_mm: float = _key(15.0, "Particle radius.", unit="mm", ge=0.1, le=100.0)
    particle_velocity_y: float = _key(
        -3.0, "Particle velocity (vertical).", unit="m/s", ge=-30.0, le=0.0
    )
    duration_s: float = _key(
        2.0, "Simulated time at which the set-up is drawn.", unit="s", gt=0.0, le=1000.0
    )
    interval_s: float = _key(0.02, "Simulated time between snapshots.", unit="s", gt=0.0, le=1000.0)


class Angles(Section):
    """Wear depth over time for several plate and factory angles.

    All other quantities are those of `figures.typical`.
    """

    plate: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = _key(
        [0.0, 15.0, 30.0, 45.0, 60.0, 70.0],
        "Plate angles, deg.",
        unit="deg",
        allowed="a list of angles from -90 to 90",
        min_length=1,
        max_length=20,
    )
    factory: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = _key(
        [-90.0, -60.0, -30.0, 0.0],
        "Factory angles, deg.",
        unit="deg",
        allowed="a list of angles from -90 to 90",
        min_length=1,
        max_length=20,
    )
    duration_s: float = _key(5.0, "Simulated time of each case.", unit="s", gt=0.0, le=10_000.0)


class Movie(Section):
    """The movie of `snakemake movie`, with several plates side by side, or a geometry.

    All other quantities are those of `figures.typical`.
    """

    plate_angles: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = _key(
        [60.0, 40.0, 30.0],
        "Plate angles, deg, from left to right.",
        unit="deg",
        allowed="a list of 1 to 4 angles from -90 to 90",
        min_length=1,
        max_length=4,
    )
    duration_s: float = _key(4.0, "Simulated time.", unit="s", gt=0.0, le=1000.0)
    slow_motion: float = _key(2.0, "Seconds of movie per simulated second.", gt=0.0, le=1000.0)
    frames_per_second: int = _key(25, "Frames per second of movie.", ge=1, le=120)
    panel_pixels: int = _key(640, "Width of the panel of each plate.", ge=100, le=4000)


class Figures(Section):
    """The figures of the report."""

    formats: Annotated[list[Literal["pdf", "png"]], Field(min_length=1)] = _key(
        ["pdf", "png"], "File formats; the report shows png.", allowed="a list of pdf and png"
    )
    series_cases: Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1)] = _key(
        [0, 1, 2, 3, 4, 5],
        "Cases for which the wear depth is plotted over time.",
        allowed="a list of case numbers from 0",
    )
    typical: Typical = Field(
        default_factory=Typical, description="The representative case in figures."
    )
    angles: Angles = Field(
        default_factory=Angles, description="Curves for several plate and factory angles."
    )
    movie: Movie = Field(default_factory=Movie, description="The movie of snakemake movie.")


class Publish(Section):
    """Metadata that `snakemake publish` adds to the data set."""

    title: Text | None = _key(
        None, "Title; null: derived from the name of the study.", allowed="null or text"
    )
    creators: Annotated[list[Text], Field(min_length=1)] = _key(
        ["abradem developers"], "Creators of the data set.", allowed="a list of names"
    )
    version: str = _key(
        "1.0.0",
        "Version of the data set.",
        allowed="1.0.0, 1.0.1, 2.0.0 ...",
        pattern=r"^[0-9]{1,6}\.[0-9]{1,6}\.[0-9]{1,6}$",
    )
    date: Day | None = _key(
        None,
        "Date of publication; null: the date on which the data set was written.",
        allowed='null or a date in quotes, "2026-01-31"',
    )
    url: str | None = _key(
        None,
        "Address of the published data set, such as https://doi.org/...",
        allowed="null or an address that begins with https://",
        pattern=_URL,
    )
    series: bool = _key(
        True,
        "Whether to include the series, maps and runs of every case, which are larger than the "
        "data set.",
        allowed="true or false",
    )


class Config(Section):
    """A study. `read_config` also checks conditions that involve several keys."""

    study: str = _key(
        ...,
        "Name of the study; its results are in results/<study>/.",
        allowed="letters, digits, _ and -, beginning with a letter or digit, at most 64",
        pattern=STUDY_NAME,
    )
    seed: int = _key(
        1,
        "Seed of all random numbers; the same seed gives the same results.",
        ge=0,
        le=2**63 - 1,
    )
    sampling: Sampling = Field(
        default_factory=Sampling, description="Which parameter sets are simulated."
    )
    simulation: Simulation = Field(
        default_factory=Simulation, description="All settings that are not sampled."
    )
    wear_rate: WearRate = Field(
        default_factory=WearRate, description="Wear rates and their quality."
    )
    dataset: Dataset = Field(
        default_factory=Dataset, description="Your own table instead of simulations."
    )
    features: Features = Field(default_factory=Features, description="The derived quantities.")
    learning: Learning = Field(default_factory=Learning, description="Models of the data set.")
    calibration: Calibration = Field(
        default_factory=Calibration, description="Search for the set-up that explains a table."
    )
    figures: Figures = Field(default_factory=Figures, description="The figures of the report.")
    publish: Publish = Field(
        default_factory=Publish, description="Metadata of the published data set."
    )

    @property
    def cases(self) -> int:
        """Number of cases of the study."""
        return self.sampling.blocks * self.sampling.cases_per_block

    @property
    def batches(self) -> list[tuple[int, int]]:
        """First case and last case plus one of each batch of a block, see `config.batches`."""
        return batches_of_block(self.sampling.cases_per_block, self.simulation.cases_per_job)

    @property
    def jobs(self) -> int:
        """Number of simulation jobs: the batches of all blocks."""
        return self.sampling.blocks * len(self.batches)

    @property
    def threads(self) -> int:
        """Number of threads of a simulation job; with a geometry one, as the engine uses one."""
        return self.simulation.threads if self.simulation.geometry.kind == "plate" else 1
