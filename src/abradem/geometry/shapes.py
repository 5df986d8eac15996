"""Surfaces by a few numbers: chains of plates and circular arcs.

An angle is that of `abradem.dem.model.Case`, a right-hand rotation about +z: a positive one lifts
the +x side. So a chain runs downwards along -x for positive angles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abradem.geometry.shape import GeometryError, Shape, combined, welded


@dataclass(frozen=True)
class Rectangle:
    """A plate of a chain.

    Parameters
    ----------
    length, width : float
        Along the slope and along z, m.
    angle : float
        deg; the plate runs from its first end along (-cos, -sin).
    gap : float
        Horizontal distance of its first end from the last end of the plate before, along the
        direction in which that one runs, m.
    drop : float
        Height of the last end of the plate before above its first end, m.
    belt : float
        Speed of its surface in the direction in which it runs, m/s.
    name : str
        By default plate_1, plate_2, ...
    """

    length: float
    width: float
    angle: float
    gap: float = 0.0
    drop: float = 0.0
    belt: float = 0.0
    name: str = ""


def plates(chain: Sequence[Rectangle], size: float) -> Shape:
    """Return a chain of plates; the centre of the first is the origin.

    Parameters
    ----------
    chain : sequence of Rectangle
    size : float
        Largest edge of a facet, m; a facet is two triangles.
    """
    if not chain:
        raise GeometryError("a chain of plates needs at least one plate")
    shapes = []
    along = _direction(chain[0].angle)
    begin = -0.5 * chain[0].length * along
    for place, plate in enumerate(chain):
        if place:
            side = math.copysign(1.0, along[0]) if along[0] != 0.0 else 1.0
            begin = begin + np.array([side * plate.gap, -plate.drop])
            along = _direction(plate.angle)
        end = begin + plate.length * along
        count = max(1, math.ceil(plate.length / size - 1e-9))
        share = np.linspace(0.0, 1.0, count + 1)[:, None]
        line = (1.0 - share) * begin + share * end
        if along[0] > 0.0:
            # From its last end, so that the normal points upwards.
            line = line[::-1]
        shapes.append(swept(line, plate.width, size, plate.name or f"plate_{place + 1}"))
        begin = end
    return welded(combined(shapes))


def _direction(angle: float) -> np.ndarray:
    """Unit vector (x, y) in which a plate of an angle (deg) runs."""
    return -np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])


def arc_chute(radius: float, begin: float, end: float, width: float, size: float) -> Shape:
    """Return a curved chute: a part of a cylinder about an axis along z.

    Its slope is ``begin`` at its first end, which is the origin, and ``end`` at its last. It is
    hollow as seen from above, like a spoon, if the angle falls, and a hump if it rises.

    Parameters
    ----------
    radius : float
        m.
    begin, end : float
        Angles of the slope, deg; in between, points are at ``radius (sin, -cos)`` of the slope
        from the axis (a hump: the opposite).
    width : float
        Along z, m.
    size : float
        Largest edge of a facet, m. The area is that of the facets, whose corners are on the
        cylinder.
    """
    if begin == end:
        raise GeometryError(f"an arc needs two angles that differ (both are {begin:g} deg)")
    turn = math.radians(abs(end - begin))
    # Chords of 2 r sin(turn / 2n), at most as long as a facet and never coarser than 5 degrees.
    finest = 2.0 * math.asin(min(1.0, 0.5 * size / radius))
    count = max(1, math.ceil(turn / min(finest, math.radians(5.0)) - 1e-9))
    slopes = np.radians(np.linspace(begin, end, count + 1))
    side = 1.0 if begin > end else -1.0
    line = side * radius * np.column_stack([np.sin(slopes), -np.cos(slopes)])
    return swept(line - line[0], width, size, "arc")


def swept(line: np.ndarray, width: float, size: float, name: str) -> Shape:
    """Return a polyline in the plane z = 0, swept along z over ``width`` about that plane.

    The normals of a line that runs along -x point upwards.

    Parameters
    ----------
    line : ndarray, shape (n, 2)
        x and y, m.
    width, size : float
        m; strips along z are at most ``size`` wide.
    name : str
    """
    count = max(1, math.ceil(width / size - 1e-9))
    z = width * (np.arange(count + 1) / count - 0.5)
    points = np.empty((len(line), count + 1, 3))
    points[:, :, :2] = line[:, None, :]
    points[:, :, 2] = z
    return grid(points, name)


def grid(points: np.ndarray, name: str) -> Shape:
    """Return a grid of points, shape (n, m, 3), as 2 (n - 1) (m - 1) triangles of one part.

    The normal is (step along the first axis) x (step along the second axis).
    """
    rows, columns = points.shape[:2]
    i, j = (index.ravel() for index in np.indices((rows - 1, columns - 1)))
    first = i * columns + j
    a, b, c, d = first, first + 1, first + columns + 1, first + columns
    # Alternating diagonals, so that the pattern has no direction.
    even = ((i + j) % 2 == 0)[:, None]
    low = np.where(even, np.column_stack([a, c, b]), np.column_stack([a, d, b]))
    high = np.where(even, np.column_stack([a, d, c]), np.column_stack([b, d, c]))
    triangles = np.stack([low, high], axis=1).reshape(-1, 3)
    return Shape(
        points.reshape(-1, 3).astype(float),
        triangles.astype(np.int64),
        np.zeros(len(triangles), dtype=np.int64),
        (name,),
    )
