"""Descriptions of geometries: what a user gives, checked, and the triangles that it stands for.

Each kind has ``shape(size)``, its triangles with facets of at most ``size``, ``motions()``, what
moves, and ``target(shape)``, the point (x, z) above which the factory is by default.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from abradem.geometry import shapes
from abradem.geometry.mesh_files import read_mesh
from abradem.geometry.screw import ScrewSize, screw
from abradem.geometry.shape import GeometryError, Shape
from abradem.geometry.shapes import Rectangle

LARGEST = 100.0
"""Largest length, m."""


def _check(where: str, value, least: float, most: float, above: bool = False) -> None:
    fine = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (fine and least <= value <= most) or (above and value == least):
        low = "above " if above else ""
        raise GeometryError(f"{where} = {value!r} (allowed {low}{least:g} ... {most:g})")


@dataclass(frozen=True)
class Motion:
    """What a part of a geometry does; the geometry keeps its shape.

    Parameters
    ----------
    part : str
    belt : tuple of float
        Velocity of the surface, as of a belt, m/s.
    revolutions : float
        Rotation about the axis, right-handed, rev/min.
    axis_point, axis : tuple of float
        A point of the axis, m, and its direction.
    """

    part: str
    belt: tuple[float, float, float] = (0.0, 0.0, 0.0)
    revolutions: float = 0.0
    axis_point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self):
        for name in ("belt", "axis_point", "axis"):
            vector = getattr(self, name)
            if len(vector) != 3:
                raise GeometryError(f"motion.{name} = {vector!r} (allowed: three numbers)")
            for number in vector:
                _check(f"motion.{name}", number, -LARGEST, LARGEST)
        _check("motion.revolutions", self.revolutions, -1e4, 1e4)
        if self.revolutions and not any(self.axis):
            raise GeometryError(f"motion.axis = {self.axis!r} (allowed: a direction)")


@dataclass(frozen=True)
class Plates:
    """A chain of plates; the centre of the first is the origin."""

    plates: tuple[Rectangle, ...]

    def __post_init__(self):
        if not self.plates:
            raise GeometryError("plates: there is none (allowed: at least one)")
        for place, plate in enumerate(self.plates):
            where = f"plates[{place}]"
            _check(f"{where}.length", plate.length, 0.0, LARGEST, above=True)
            _check(f"{where}.width", plate.width, 0.0, LARGEST, above=True)
            _check(f"{where}.angle", plate.angle, -180.0, 180.0)
            _check(f"{where}.gap", plate.gap, -LARGEST, LARGEST)
            _check(f"{where}.drop", plate.drop, -LARGEST, LARGEST)
            _check(f"{where}.belt", plate.belt, -LARGEST, LARGEST)
        if len(set(self.names())) < len(self.plates):
            raise GeometryError(f"plates: two have one name, {', '.join(self.names())}")

    def names(self) -> list[str]:
        """Return the names of the plates."""
        return [plate.name or f"plate_{place + 1}" for place, plate in enumerate(self.plates)]

    def shape(self, size: float) -> Shape:
        """Return the triangles, with facets of at most ``size``, m."""
        return shapes.plates(self.plates, size)

    def motions(self) -> list[Motion]:
        """Return the belts."""
        return [
            Motion(name, belt=_along(plate.angle, plate.belt))
            for plate, name in zip(self.plates, self.names(), strict=True)
            if plate.belt
        ]

    def target(self, shape: Shape) -> tuple[float, float]:
        """Return the centre of the first plate."""
        return 0.0, 0.0


@dataclass(frozen=True)
class Arc:
    """A curved chute, see `abradem.geometry.shapes.arc_chute`; its first end is the origin.

    Parameters
    ----------
    radius : float
        m.
    begin, end : float
        Angles of the slope at its ends, deg.
    width : float
        m.
    """

    radius: float
    begin: float
    end: float
    width: float

    def __post_init__(self):
        _check("arc.radius", self.radius, 0.0, LARGEST, above=True)
        _check("arc.width", self.width, 0.0, LARGEST, above=True)
        _check("arc.begin", self.begin, -90.0, 90.0)
        _check("arc.end", self.end, -90.0, 90.0)

    def shape(self, size: float) -> Shape:
        """Return the triangles, with facets of at most ``size``, m."""
        return shapes.arc_chute(self.radius, self.begin, self.end, self.width, size)

    def motions(self) -> list[Motion]:
        """Return nothing: an arc stands still."""
        return []

    def target(self, shape: Shape) -> tuple[float, float]:
        """Return a quarter of the horizontal extent from the higher end."""
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        ends = shape.vertices[[0, -1]]
        top = ends[np.argmax(ends[:, 1]), 0]
        other = low[0] if abs(top - high[0]) < abs(top - low[0]) else high[0]
        return float(0.75 * top + 0.25 * other), 0.0


@dataclass(frozen=True)
class MeshFile:
    """A mesh file, see `abradem.geometry.mesh_files.read_mesh`.

    Parameters
    ----------
    file : str
    unit : {"mm", "cm", "m", "in"}
    up : {"x", "y", "z"}
        Axis of the file that points up.
    repair : bool
        Whether triangles without area or given twice are left out.
    offset : tuple of float
        Added to all positions, after the rotation that makes y point up, m.
    moving : tuple of Motion
    """

    file: str
    unit: str = "mm"
    up: str = "z"
    repair: bool = False
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    moving: tuple[Motion, ...] = ()

    def __post_init__(self):
        if len(self.offset) != 3:
            raise GeometryError(f"mesh.offset = {self.offset!r} (allowed: three numbers)")
        for number in self.offset:
            _check("mesh.offset", number, -1e4, 1e4)

    def shape(self, size: float) -> Shape:
        """Return the triangles of the file; `abradem.geometry.build` divides them."""
        shape = read_mesh(self.file, self.unit, self.up, self.repair)
        return shape._replace(vertices=shape.vertices + np.array(self.offset, dtype=float))

    def motions(self) -> list[Motion]:
        """Return what moves."""
        return list(self.moving)

    def target(self, shape: Shape) -> tuple[float, float]:
        """Return the middle of the box around the mesh."""
        middle = 0.5 * (shape.vertices.min(axis=0) + shape.vertices.max(axis=0))
        return float(middle[0]), float(middle[2])


@dataclass(frozen=True)
class Screw(ScrewSize):
    """A screw conveyor along x that conveys to x = 0, see `abradem.geometry.screw`.

    Parameters
    ----------
    revolutions : float
        rev/min.
    """

    revolutions: float

    def __post_init__(self):
        for name in ("length", "radius", "shaft_radius", "pitch", "rim"):
            _check(f"screw.{name}", getattr(self, name), 0.0, LARGEST, above=True)
        _check("screw.clearance", self.clearance, 0.0, LARGEST)
        _check("screw.revolutions", self.revolutions, -1e4, 1e4)

    def shape(self, size: float) -> Shape:
        """Return the triangles, with facets of at most ``size``, m."""
        return screw(self, size)

    def motions(self) -> list[Motion]:
        """Return the rotation of flight and shaft about x."""
        return [
            Motion(part, revolutions=self.revolutions, axis=(1.0, 0.0, 0.0))
            for part in ("flight", "shaft")
        ]

    def target(self, shape: Shape) -> tuple[float, float]:
        """Return the axis, a pitch from the closed end."""
        return self.length - min(self.pitch, 0.5 * self.length), 0.0


def _along(angle: float, speed: float) -> tuple[float, float, float]:
    """Velocity along a plate of an angle (deg), m/s."""
    radians = math.radians(angle)
    return -speed * math.cos(radians), -speed * math.sin(radians), 0.0


Geometry = Plates | Arc | MeshFile | Screw

KINDS = {"plates": Plates, "arc": Arc, "mesh": MeshFile, "screw": Screw}


def geometry_of(values: Mapping) -> Geometry:
    """Return the geometry for a mapping of its fields to plain values, and its ``kind``.

    Raises
    ------
    GeometryError
        With one line for what is unknown, missing or out of range.
    """
    values = dict(values)
    kind = values.pop("kind", None)
    if kind not in KINDS:
        raise GeometryError(f"geometry kind = {kind!r} (allowed: {', '.join(KINDS)})")
    if kind == "plates":
        chain = values.get("plates", ())
        values["plates"] = tuple(
            _filled(Rectangle, f"plates[{k}]", row) for k, row in enumerate(chain)
        )
    if kind == "mesh":
        values["offset"] = tuple(values.get("offset", (0.0, 0.0, 0.0)))
        values["moving"] = tuple(_filled(Motion, "moving", row) for row in values.get("moving", ()))
    return _filled(KINDS[kind], kind, values)


def _filled(kind, where: str, values: Mapping):
    fields = {field.name: field for field in dataclasses.fields(kind)}
    unknown = [name for name in values if name not in fields]
    missing = [
        name
        for name, field in fields.items()
        if name not in values and field.default is dataclasses.MISSING
    ]
    if unknown or missing:
        problems = [f"{name} is unknown" for name in unknown]
        problems += [f"{name} is missing" for name in missing]
        raise GeometryError(f"{where}: {', '.join(problems)} (allowed: {', '.join(fields)})")
    return kind(**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()})
