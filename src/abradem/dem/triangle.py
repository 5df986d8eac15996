"""The nearest point of a triangle (Ericson 2005, Real-Time Collision Detection, section 5.1.5)."""

from __future__ import annotations

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.vectors import dot, fma

SIDE = 10
"""Numbers that describe a side of a triangle, see `mesh.Mesh.sides`."""

FACE, VERTEX = -1, 3
"""Feature of a triangle with the nearest point: `FACE`, side k, or `VERTEX` + k."""


@kernel(inline=True)
def side_vector(sides, i, k, at):
    """Vector of three of the numbers that describe side k of triangle i, from ``at`` on."""
    return sides[i, k, at], sides[i, k, at + 1], sides[i, k, at + 2]


@kernel(inline=True)
def nearest_on_triangle(sides, normals, i, x, y, z):
    """Return squared distance, feature, position along its side, and height over the plane.

    ``sides`` and ``normals`` are those of `mesh.Mesh`; lengths are in m.
    """
    height = dot(
        (x - sides[i, 0, 0], y - sides[i, 0, 1], z - sides[i, 0, 2]),
        (normals[i, 0], normals[i, 1], normals[i, 2]),
    )
    feature, place, least = FACE, 0.0, np.inf
    for k in range(3):
        arm = (x - sides[i, k, 0], y - sides[i, k, 1], z - sides[i, k, 2])
        beside = dot(arm, side_vector(sides, i, k, 3))
        if beside < 0.0:
            # Outside this side: the nearest point is on it or on another such side.
            along = dot(arm, side_vector(sides, i, k, 6))
            on = min(max(along, 0.0), sides[i, k, 9])
            off = along - on
            distance2 = fma(beside, beside, off * off)
            if distance2 < least:
                least, place = distance2, on
                feature = k
                if off < 0.0:
                    feature = VERTEX + k
                elif off > 0.0:
                    feature = VERTEX + (k + 1) % 3
    if feature == FACE:
        least = 0.0
    return fma(height, height, least), feature, place, height
