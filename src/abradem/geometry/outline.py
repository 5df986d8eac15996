"""Lines that show the shape of a surface: its rims and creases."""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.surface import Surface

CREASE = math.cos(math.radians(25.0))
"""Cosine of the angle between cells from which on their common edge is a line."""


def outline(surface: Surface, corners: np.ndarray) -> np.ndarray:
    """Return the ends of the rims of the parts and of their creases.

    Parameters
    ----------
    surface : Surface
    corners : ndarray, shape (t, 3, 3)
        Where the corners of its triangles are, m.

    Returns
    -------
    ndarray, shape (n, 2, 3)
        Of each line the two ends, m. A smooth closed surface has none.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    ends = np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    keyed = np.column_stack([np.repeat(surface.part, 3), ends])
    _, first, place, count = np.unique(
        keyed, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    face = np.arange(len(ends)) // 3
    order = np.argsort(place.ravel(), kind="stable")
    starts = np.concatenate([[0], np.cumsum(count)])[:-1]
    one, other = order[starts], order[starts + np.minimum(count - 1, 1)]
    bend = np.abs(np.einsum("ij,ij->i", normal[face[one]], normal[face[other]]))
    chosen = first[(count == 1) | (count > 2) | (bend < CREASE)]
    side = chosen % 3
    return np.stack([corners[face[chosen], side], corners[face[chosen], (side + 1) % 3]], axis=1)
