"""Where the factory is above a geometry, and whether its jet meets it."""

from __future__ import annotations

import itertools
import math

import numpy as np

from abradem.dem.surface import Feed
from abradem.geometry.shape import GeometryError, Shape

SAMPLES = 5
"""Particles along each edge of the patch whose paths are looked at."""

PIECES = 60
"""Straight pieces of a path."""


def height_below(shape: Shape, x: float, z: float) -> float:
    """Return the height of the highest point of the shape on the vertical line at (x, z), m.

    It is -inf if the line misses the shape.
    """
    a, b, c = (shape.vertices[shape.triangles[:, corner]] for corner in range(3))

    def area(p, q):
        return p[0] * q[1] - p[1] * q[0]

    at = np.array([x, z])
    pa, pb, pc = ((corner[:, [0, 2]] - at).T for corner in (a, b, c))
    u, v, w = area(pb, pc), area(pc, pa), area(pa, pb)
    total = u + v + w
    tiny = 1e-12 * np.abs(total).max()
    inside = (np.abs(total) > tiny) & (
        ((u >= -tiny) & (v >= -tiny) & (w >= -tiny)) | ((u <= tiny) & (v <= tiny) & (w <= tiny))
    )
    if not inside.any():
        return -math.inf
    y = (u * a[:, 1] + v * b[:, 1] + w * c[:, 1])[inside] / total[inside]
    return float(y.max())


def feed_above(
    shape: Shape,
    target: tuple[float, float],
    height: float,
    length: float,
    width: float,
    centre: tuple[float, float, float] | None = None,
    direction: tuple[float, float, float] = (0.0, -1.0, 0.0),
) -> Feed:
    """Return the factory patch above a shape: level, its length along x and its width along z.

    Parameters
    ----------
    shape : Shape
    target : tuple of float
        The point (x, z) above which the patch is, m.
    height : float
        Of the patch above the shape there, m.
    length, width : float
        Of the patch, m.
    centre : tuple of float, optional
        Centre of the patch, m; replaces target and height.
    direction : tuple of float
        Of the velocity of the particles.

    Raises
    ------
    GeometryError
        If there is no surface below the target.
    """
    if centre is None:
        top = height_below(shape, *target)
        if not math.isfinite(top):
            raise GeometryError(
                f"there is no surface below the factory at x = {target[0]:g} m, z = "
                f"{target[1]:g} m (allowed: a place above the geometry, factory_centre_mm)"
            )
        centre = (target[0], top + height, target[1])
    return Feed(centre, (length, 0.0, 0.0), (0.0, 0.0, width), direction)


def check_box(feed: Feed, box: tuple) -> None:
    """Raise if the factory is not inside the box outside which particles are removed.

    Parameters
    ----------
    feed : Feed
    box : tuple of tuple of float
        Lowest and highest corner, m.

    Raises
    ------
    GeometryError
        With the corner of the patch that is outside.
    """
    low, high = (np.array(corner, dtype=float) for corner in box)
    for one, other in itertools.product((-0.5, 0.5), repeat=2):
        corner = np.array(feed.centre) + one * np.array(feed.along) + other * np.array(feed.across)
        if np.any(corner < low) or np.any(corner > high):
            place = ", ".join(f"{number:.4g}" for number in corner)
            raise GeometryError(
                f"the corner ({place}) m of the factory is outside the removal box, so its "
                "particles would be removed at once (allowed: a box that holds the factory)"
            )


def check_jet(shape: Shape, feed: Feed, speed: float, gravity: float) -> None:
    """Raise if no particle of the factory would meet the shape.

    Parameters
    ----------
    shape : Shape
    feed : Feed
    speed : float
        Of the particles at their release, m/s.
    gravity : float
        m/s2, along -y.

    Raises
    ------
    GeometryError
        With the place of the factory and the box around the shape.
    """
    share = np.linspace(-0.5, 0.5, SAMPLES)
    along, across = np.meshgrid(share, share, indexing="ij")
    starts = (
        np.array(feed.centre)
        + along.reshape(-1, 1) * np.array(feed.along)
        + across.reshape(-1, 1) * np.array(feed.across)
    )
    velocity = speed * np.array(feed.direction) / np.linalg.norm(feed.direction)
    corners = shape.vertices[shape.triangles]
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    for start in starts:
        path = _path(start, velocity, gravity, low, high)
        if path is not None and _meets(path, corners):
            return
    box = " x ".join(f"{a:.4g} ... {b:.4g}" for a, b in zip(low, high, strict=True))
    place = ", ".join(f"{number:.4g}" for number in feed.centre)
    raise GeometryError(
        f"the jet from ({place}) m misses the geometry, which is in x, y, z = {box} m (allowed: a "
        "factory whose particles meet it)"
    )


def _path(start, velocity, gravity, low, high) -> np.ndarray | None:
    """Points of the parabola until it is below the shape, or has passed it, shape (n, 3)."""
    extent = float(np.linalg.norm(np.maximum(high, start) - np.minimum(low, start)))
    if gravity > 0.0:
        fall = velocity[1] ** 2 + 2.0 * gravity * (start[1] - low[1] + 1e-6 * extent)
        if fall < 0.0:
            return None
        last = (velocity[1] + math.sqrt(fall)) / gravity
    elif np.any(velocity):
        last = 2.0 * extent / float(np.linalg.norm(velocity))
    else:
        return None
    time = np.linspace(0.0, last, PIECES + 1)[:, None]
    return start + time * velocity - 0.5 * gravity * time**2 * np.array([0.0, 1.0, 0.0])


def _meets(path: np.ndarray, corners: np.ndarray) -> bool:
    """Whether a polyline crosses a triangle (Moeller & Trumbore 1997, J. Graph. Tools 2:21)."""
    a = corners[:, 0]
    edge_1, edge_2 = corners[:, 1] - a, corners[:, 2] - a
    for start, end in itertools.pairwise(path):
        ray = end - start
        p = np.cross(ray, edge_2)
        det = np.einsum("ij,ij->i", edge_1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = start - a
            u = np.einsum("ij,ij->i", s, p) / det
            q = np.cross(s, edge_1)
            v = q @ ray / det
            t = np.einsum("ij,ij->i", edge_2, q) / det
            inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9) & (t >= 0.0) & (t <= 1.0)
        if inside.any():
            return True
    return False
