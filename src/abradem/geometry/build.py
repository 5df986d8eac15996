"""From a description of a geometry to the surface and the factory of the engine."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from abradem.dem.model import Setup
from abradem.dem.surface import Feed, Surface, cell_areas
from abradem.geometry.feed import check_box, check_jet, feed_above
from abradem.geometry.kinds import Geometry, MeshFile, Motion, geometry_of
from abradem.geometry.mesh_files import units_between
from abradem.geometry.shape import GeometryError, Shape, divided

MOST_CELLS = 200_000
"""Most wear cells of a surface."""


def surface_of(geometry: Geometry, size: float) -> Surface:
    """Return the surface of a geometry, whose triangles are its wear cells.

    Parameters
    ----------
    geometry : Geometry
    size : float
        Size of a facet, m. No edge of a cell is longer than the diagonal of a square of that size.

    Raises
    ------
    GeometryError
        If the file cannot be used, a part that moves is unknown, or there would be too many cells.
    """
    return _remembered(_surface, geometry, size)


def _shape(geometry: Geometry, size: float, stamp: tuple) -> Shape:
    return geometry.shape(size)


def _surface(geometry: Geometry, size: float, stamp: tuple) -> Surface:
    shape = divided(_remembered(_shape, geometry, size), math.sqrt(2.0) * size, MOST_CELLS)
    return moving(shape, geometry.motions())


_MEMORY = {make: lru_cache(maxsize=4)(make) for make in (_shape, _surface)}
"""The last shapes and surfaces; the cases of a study often have the same."""


def _remembered(make: Callable, geometry: Geometry, size: float) -> Any:
    try:
        hash(geometry)
    except TypeError:
        # Made in Python, with a list in place of a tuple.
        return make(geometry, size, ())
    return _MEMORY[make](geometry, size, _stamp(geometry))


def _stamp(geometry: Geometry) -> tuple:
    """What tells versions of the file of a geometry apart, or ()."""
    if isinstance(geometry, MeshFile) and (path := Path(geometry.file)).is_file():
        state = path.stat()
        return state.st_mtime_ns, state.st_size
    return ()


def moving(shape: Shape, motions: list[Motion]) -> Surface:
    """Return the surface of a shape whose parts move.

    Raises
    ------
    GeometryError
        If a motion names an unknown part.
    """
    count = len(shape.names)
    velocity, point, axis = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    axis[:, 2] = 1.0
    turning = np.zeros(count)
    for motion in motions:
        if motion.part not in shape.names:
            raise GeometryError(
                f"motion: there is no part {motion.part!r} (allowed: {', '.join(shape.names)})"
            )
        part = shape.names.index(motion.part)
        velocity[part], point[part], axis[part] = motion.belt, motion.axis_point, motion.axis
        turning[part] = 2.0 * math.pi * motion.revolutions / 60.0
    return Surface(
        shape.vertices, shape.triangles, shape.part, shape.names, velocity, point, axis, turning
    )


def shape_of(surface: Surface) -> Shape:
    """Return the triangles of a surface without its motion."""
    return Shape(surface.vertices, surface.triangles, surface.part, surface.part_names)


def worn_area(setup: Setup) -> float:
    """Return the area of the plate, or of the surface in its place, m2."""
    return setup.plate_area if setup.surface is None else float(cell_areas(setup.surface).sum())


def check_particle(shape: Shape, radius: float, geometry: Geometry) -> None:
    """Raise if a particle is wider than the geometry.

    Raises
    ------
    GeometryError
        With the radius and the largest that is allowed: half of the second largest extent. Of a
        mesh file also the units with which the particle would fit.
    """
    _, extent, largest = (float(one) for one in np.sort(np.ptp(shape.vertices, axis=0)))
    if 2.0 * radius > extent:
        hint = ""
        if isinstance(geometry, MeshFile):
            fits = units_between(extent, largest, geometry.unit, 2.0 * radius)
            hint = f"; {geometry.file} was read with unit {geometry.unit}" + (
                f", is its unit {fits}?" if fits else ""
            )
        raise GeometryError(
            f"a particle of radius {radius:g} m is wider than the geometry, {extent:.4g} m "
            f"(allowed up to {0.5 * extent:.4g} m){hint}"
        )


def prepared(setup: Setup, values: Mapping[str, float]) -> Setup:
    """Return the set-up of a case with the surface and the factory of its geometry.

    Parameters
    ----------
    setup : Setup
        Without a geometry, or with a surface already, it is returned as it is.
    values : mapping
        Quantities of the case: plate_angle, deg, particle_radius, m, particle_velocity_y, m/s, and
        those of the geometry that are sampled.

    Raises
    ------
    GeometryError
        If the geometry cannot be used, a particle is wider than it, or the jet misses it.
    """
    if setup.geometry is None or setup.surface is not None:
        return setup
    geometry, feed, box = _placed(setup, values)
    return replace(
        setup,
        surface=surface_of(geometry, setup.facet_size),
        feed=feed,
        removal_box=None if box is None else tuple(tuple(corner) for corner in box),
    )


def factory_of(setup: Setup, values: Mapping[str, float]) -> Feed:
    """Return the factory of a case on a geometry, see `prepared`; the surface is not made."""
    return _placed(setup, values)[1]


def geometry_described(setup: Setup, values: Mapping[str, float]) -> Geometry:
    """Return the geometry of a set-up with the values of a case for its sampled quantities.

    Raises
    ------
    GeometryError
        If it cannot be used.
    """
    given = setup.geometry
    described = given.get("shape", given) if isinstance(given, Mapping) else given
    if isinstance(described, Mapping):
        return geometry_of(filled_in(described, values))
    if not isinstance(described, Geometry):
        raise GeometryError(
            f'geometry = {described!r} (allowed: a mapping such as {{"kind": "mesh", "file": '
            '"chute.stl"})'
        )
    return described


def _placed(setup: Setup, values: Mapping[str, float]) -> tuple[Geometry, Feed, Any]:
    """Geometry, factory and removal box of a case, which fit each other."""
    options: Mapping[str, Any] = setup.geometry if isinstance(setup.geometry, Mapping) else {}
    geometry = geometry_described(setup, values)
    coarse = _remembered(_shape, geometry, setup.facet_size)
    check_particle(coarse, values["particle_radius"], geometry)
    feed = feed_above(
        coarse,
        geometry.target(coarse),
        setup.fall_height,
        setup.patch_length,
        setup.patch_width,
        None if options.get("centre") is None else tuple(options["centre"]),
        tuple(options.get("direction") or (0.0, -1.0, 0.0)),
    )
    check_jet(coarse, feed, abs(values["particle_velocity_y"]), setup.gravity)
    box = options.get("removal_box")
    if box is not None:
        check_box(feed, box)
    return geometry, feed, box


def mesh_file(given) -> str | None:
    """Return the path of the mesh file of a geometry as plain values, or None."""
    if not isinstance(given, Mapping):
        return None
    shape = given.get("shape", given)
    return shape.get("file") if shape.get("kind") == "mesh" else None


def case_surface(setup: Setup, values: Mapping[str, float]) -> Surface:
    """Return the surface of a case whose set-up has a geometry, see `prepared`.

    Raises
    ------
    GeometryError
        As `prepared`, or if the set-up has a plate.
    """
    surface = prepared(setup, values).surface
    if surface is None:
        raise GeometryError("the set-up has a plate (allowed: a geometry)")
    return surface


TEXTS = ("kind", "file", "unit", "up", "name", "part")
"""Fields of a geometry that are words; another text is the name of a quantity of the case."""


def filled_in(described: Mapping, values: Mapping[str, float]) -> dict:
    """Return the fields of a geometry with the values of the case for names of its quantities.

    Raises
    ------
    GeometryError
        If the case has no such quantity.
    """

    def filled(name, value):
        if isinstance(value, Mapping):
            return {inner: filled(inner, one) for inner, one in value.items()}
        if isinstance(value, (list, tuple)):
            return [filled(name, one) for one in value]
        if not isinstance(value, str) or name in TEXTS:
            return value
        if value not in values:
            raise GeometryError(f"{name}: the case has no quantity {value!r}")
        return float(values[value])

    return filled("", described)
