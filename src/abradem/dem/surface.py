"""A triangulated surface, in place of the plate: plain data, SI units, no numba.

A surface consists of triangles, each of which is a wear cell, in named parts. A part can carry
particles like a belt, or turn about an axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

CELL_SUMS = (
    "impacts", "impact_speed", "impact_angle", "normal_work", "tangential_work", "normal_impulse"
)  # fmt: skip
"""What is summed up per cell beside the wear: number of impacts, their speeds (m/s) and their
angles from the normal (deg), the work that the normal and the tangential contact force exchange
with the particles (J), each step counted with its absolute value, and the normal impulse (N s)."""


class Surface(NamedTuple):
    """A triangulated surface in named parts; contacts act on both sides of a triangle.

    Attributes
    ----------
    vertices : ndarray, shape (v, 3)
        m.
    triangles : ndarray of int, shape (t, 3)
        Vertices a, b, c of each triangle; the normal is along (b - a) x (c - a).
    part : ndarray of int, shape (t,)
        Part of each triangle.
    part_names : tuple of str, length p
    velocity : ndarray, shape (p, 3)
        Velocity of the surface of each part, as of a belt, m/s; the part itself stays where it
        is. At a contact only the tangential component acts.
    axis_point, axis_direction : ndarray, shape (p, 3)
        Axis about which a part turns; a point, m, and a direction of any length.
    angular_velocity : ndarray, shape (p,)
        Rotation of each part about its axis, right-handed, rad/s; 0: it does not turn.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    part: np.ndarray
    part_names: tuple[str, ...]
    velocity: np.ndarray
    axis_point: np.ndarray
    axis_direction: np.ndarray
    angular_velocity: np.ndarray


class Feed(NamedTuple):
    """The factory patch of a simulation with a surface: a parallelogram of particle centres.

    Attributes
    ----------
    centre : tuple of float
        m.
    along, across : tuple of float
        The two edges of the patch, as vectors, m.
    direction : tuple of float
        Direction of the velocity at the release, of any length; the speed is the magnitude of
        ``particle_velocity_y`` of the case.
    """

    centre: tuple[float, float, float]
    along: tuple[float, float, float]
    across: tuple[float, float, float]
    direction: tuple[float, float, float] = (0.0, -1.0, 0.0)


def standing_surface(vertices, triangles, name: str = "surface") -> Surface:
    """Return a surface of one part that does not move.

    Parameters
    ----------
    vertices : array_like, shape (v, 3)
        m.
    triangles : array_like of int, shape (t, 3)
    name : str
        Name of the part.

    Returns
    -------
    Surface
    """
    triangles = np.asarray(triangles, dtype=np.int64)
    nothing = np.zeros((1, 3))
    return Surface(
        vertices=np.asarray(vertices, dtype=float),
        triangles=triangles,
        part=np.zeros(len(triangles), np.int64),
        part_names=(name,),
        velocity=nothing,
        axis_point=nothing,
        axis_direction=np.array([[0.0, 0.0, 1.0]]),
        angular_velocity=np.zeros(1),
    )


def cell_areas(surface: Surface) -> np.ndarray:
    """Return the area of each triangle, m2, shape (t,)."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def check_surface(surface: Surface) -> None:
    """Raise if the arrays of a surface do not fit each other or hold what no simulation can use.

    Raises
    ------
    ValueError
        With the field, the value and what is allowed.
    """
    parts, cells = len(surface.part_names), len(surface.triangles)
    shapes = {
        "vertices": (len(surface.vertices), 3),
        "triangles": (cells, 3),
        "part": (cells,),
        "velocity": (parts, 3),
        "axis_point": (parts, 3),
        "axis_direction": (parts, 3),
        "angular_velocity": (parts,),
    }
    for name, shape in shapes.items():
        found = np.asarray(getattr(surface, name))
        if found.shape != shape:
            raise ValueError(f"surface.{name} has the shape {found.shape}, not {shape}")
        if not np.isfinite(found).all():
            raise ValueError(f"surface.{name} must be finite numbers")
    if not cells:
        raise ValueError("surface.triangles is empty; at least one triangle is needed")
    for name, most in (("triangles", len(surface.vertices)), ("part", parts)):
        found = np.asarray(getattr(surface, name))
        if found.min() < 0 or found.max() >= most:
            raise ValueError(
                f"surface.{name} refers to {found.min()} to {found.max()}; "
                f"allowed are 0 to {most - 1}"
            )
    areas = cell_areas(surface)
    if not areas.min() > 0.0:
        raise ValueError(f"triangle {int(areas.argmin())} of the surface has no area")
    for part, name in enumerate(surface.part_names):
        if surface.angular_velocity[part] != 0.0:
            if not np.any(surface.axis_direction[part]):
                raise ValueError(f"part {name!r} turns, but its axis_direction is 0")
            if np.any(surface.velocity[part]):
                raise ValueError(f"part {name!r} has a velocity and turns; allowed is one of them")


def check_feed(feed: Feed) -> None:
    """Raise if a feed has a value that no simulation can use.

    Raises
    ------
    ValueError
        With the field, the value and what is allowed.
    """
    for name, vector in feed._asdict().items():
        if len(vector) != 3 or not all(math.isfinite(number) for number in vector):
            raise ValueError(f"feed.{name} = {vector!r} must be three finite numbers")
    if not any(feed.direction):
        raise ValueError("feed.direction is 0; it must point somewhere")
