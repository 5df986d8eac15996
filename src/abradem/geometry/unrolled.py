"""Surfaces that are bent about z only, as plates and arcs, laid out flat."""

from __future__ import annotations

import numpy as np

from abradem.dem.surface import Surface

STRAIGHT = 1e-9
"""Largest z component of the normals of a part that can be laid out."""


def unrolled_part(surface: Surface, part: int) -> np.ndarray | None:
    """Return the corners of the cells of a part on a flat map, or None.

    A part can be laid out if it is a line in the plane of x and y, swept along z. The map keeps
    lengths and areas.

    Parameters
    ----------
    surface : Surface
    part : int
        Number of the part.

    Returns
    -------
    ndarray, shape (t, 3, 2), or None
        For each cell of the part, in order, s and z of its corners, m; s is the distance along the
        line from its higher end. None if the part is not such a surface.
    """
    chosen = surface.triangles[surface.part == part]
    corners = surface.vertices[chosen]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if np.any(np.abs(across[:, 2]) > STRAIGHT * np.linalg.norm(across, axis=1)):
        return None
    flat = corners[:, :, :2].reshape(-1, 2)
    extent = float(np.ptp(surface.vertices, axis=0).max())
    grid = np.round(flat / (1e-7 * extent)).astype(np.int64)
    _, first, point = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    places, point = flat[first], point.reshape(-1, 3)
    distance = _distances(places, point)
    if distance is None:
        return None
    return np.stack([distance[point], corners[:, :, 2]], axis=-1)


def _distances(places: np.ndarray, point: np.ndarray) -> np.ndarray | None:
    """Distance of each point of an open line from its higher end; None if it is not one."""
    ends = np.sort(point[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    steps = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    neighbours: list[list[int]] = [[] for _ in places]
    for a, b in steps:
        neighbours[a].append(b)
        neighbours[b].append(a)
    single = [p for p, near in enumerate(neighbours) if len(near) == 1]
    if len(single) != 2 or any(len(near) > 2 for near in neighbours):
        return None
    here = max(single, key=lambda p: (places[p, 1], places[p, 0]))
    distance = np.full(len(places), np.nan)
    distance[here], before = 0.0, -1
    while True:
        ahead = [p for p in neighbours[here] if p != before]
        if not ahead:
            return None if np.isnan(distance).any() else distance
        before, here = here, ahead[0]
        distance[here] = distance[before] + np.hypot(*(places[here] - places[before]))
