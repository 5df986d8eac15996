"""A transfer chute: a hood that catches a stream, a box with sloping walls, and a spoon."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.geometry.shape import Shape, combined, welded
from abradem.geometry.shapes import grid, swept


class ChuteSize(NamedTuple):
    """Dimensions of a transfer chute, m.

    Attributes
    ----------
    width : float
        Inner width of the chute along z.
    drop : float
        Height of the hood above the spoon.
    hood_radius, spoon_radius : float
        Radii of the curved plates.
    """

    width: float = 0.4
    drop: float = 0.5
    hood_radius: float = 0.5
    spoon_radius: float = 0.4


HOOD_SLOPES = (15.0, 80.0)
SPOON_SLOPES = (75.0, 15.0)
"""Slopes, deg, at both ends of the curved plates: the hood turns a stream that arrives along -x
downwards, the spoon turns it from the vertical to a belt that runs along -x."""


def transfer_chute(size: ChuteSize | None = None, facet: float = 0.05) -> Shape:
    """Return hood, back, sides and spoon, the parts of those names, with the spoon's end at 0.

    Parameters
    ----------
    size : ChuteSize, optional
    facet : float
        Largest edge of a facet, m.
    """
    size = size or ChuteSize()
    spoon = _bend(size.spoon_radius, SPOON_SLOPES, 1.0, facet)
    spoon -= spoon[-1]
    top = spoon[0] + np.array([0.0, size.drop])
    # The stream meets the inner side of the hood, which bends down over it.
    hood = _bend(size.hood_radius, HOOD_SLOPES, -1.0, facet)
    width_of_shaft = 0.5 * size.width
    hood += top - np.array([width_of_shaft, 0.0]) - hood[-1]
    back = np.linspace(spoon[0], top, math.ceil(size.drop / facet) + 1)
    shapes = [
        swept(hood, size.width, facet, "hood"),
        swept(back, size.width, facet, "back"),
        swept(spoon, size.width, facet, "spoon"),
    ]
    front = np.linspace(hood[-1], spoon[0] - np.array([width_of_shaft, 0.0]), len(back))[::-1]
    for z in (-0.5 * size.width, 0.5 * size.width):
        shapes += [
            _between(back, front, z, facet),
            _between(spoon, spoon + np.array([0.0, 0.5 * width_of_shaft]), z, facet),
        ]
    return welded(combined(shapes))


def _bend(radius: float, slopes: tuple[float, float], side: float, facet: float) -> np.ndarray:
    """Polyline (x, y) of a circle between two slopes; hollow from above for ``side`` 1."""
    first, last = np.radians(slopes)
    count = math.ceil(abs(last - first) * radius / facet)
    angles = np.linspace(first, last, count + 1)
    return side * radius * np.column_stack([np.sin(angles), -np.cos(angles)])


def _between(first: np.ndarray, last: np.ndarray, z: float, facet: float) -> Shape:
    """Side wall at z between two polylines of as many points."""
    widest = float(np.linalg.norm(last - first, axis=1).max())
    share = np.linspace(0.0, 1.0, max(1, math.ceil(widest / facet)) + 1)[None, :, None]
    points = np.empty((len(first), share.size, 3))
    points[:, :, :2] = (1.0 - share) * first[:, None, :] + share * last[:, None, :]
    points[:, :, 2] = z
    return grid(points, "sides")
