"""Flat parts of a surface, and parts that are bent about z only, such as arcs, laid out flat."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dem.surface import Surface
from abradem.geometry.shape import cross_products, largest_extent

FLAT = 1e-6
"""Largest distance from a plane of the vertices of a flat part, as a share of the extent of the
surface: above the rounding of a mesh file."""

STRAIGHT = 1e-9
"""Largest z component of the normals of a part that is bent about z only."""


class FlatPart(NamedTuple):
    """A part laid out; lengths and areas are kept.

    Attributes
    ----------
    corners : ndarray, shape (t, 3, 2)
        For each cell of the part, in order, s and the coordinate across of its corners, m; s is
        the distance from the higher end.
    across : {"x", "z", "w"}
        The coordinate across: x or z of the surface, or for other directions a level coordinate w
        that begins at 0.
    """

    corners: np.ndarray
    across: str


def unrolled_part(surface: Surface, part: int) -> FlatPart | None:
    """Lay out a part of a surface.

    That is possible for a flat part, and for a line in the plane of x and y that is swept along z.

    Parameters
    ----------
    surface : Surface
    part : int
        Number of the part.

    Returns
    -------
    FlatPart or None
        None if the part is not such a surface.
    """
    triangles = surface.triangles[surface.part == part]
    corners, extent = surface.vertices[triangles], largest_extent(surface.vertices)
    across = cross_products(surface.vertices, triangles)
    found = _on_plane(corners, across, extent)
    return _along_line(corners, across, extent) if found is None else found


def _on_plane(corners: np.ndarray, across: np.ndarray, extent: float) -> FlatPart | None:
    """Lay out triangles that are all in one plane."""
    normal = across[np.argmax(np.linalg.norm(across, axis=1))]
    normal = normal / np.linalg.norm(normal)
    points = corners - corners[0, 0]
    if np.abs(points @ normal).max() > FLAT * extent:
        return None
    level = np.array([normal[2], 0.0, -normal[0]])
    if np.linalg.norm(level) <= FLAT:
        level = np.array([0.0, 0.0, 1.0])
    level /= np.linalg.norm(level)
    level *= np.sign(level[np.argmax(np.abs(level))])
    down = np.cross(level, normal)
    # On a level plane s is against x.
    down *= -np.sign(down[1] if abs(down[1]) > FLAT else down[0])
    s, w = corners @ down, corners @ level
    name = next((name for name, axis in (("x", 0), ("z", 2)) if level[axis] >= 1.0 - FLAT), "w")
    return FlatPart(np.stack([s - s.min(), w - (w.min() if name == "w" else 0.0)], axis=-1), name)


def _along_line(corners: np.ndarray, across: np.ndarray, extent: float) -> FlatPart | None:
    """Lay out triangles that are a line in the plane of x and y, swept along z."""
    if np.any(np.abs(across[:, 2]) > STRAIGHT * np.linalg.norm(across, axis=1)):
        return None
    flat = corners[:, :, :2].reshape(-1, 2)
    grid = np.round(flat / (1e-7 * extent)).astype(np.int64)
    _, first, point = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    places, point = flat[first], point.reshape(-1, 3)
    distance = _distances(places, point)
    if distance is None:
        return None
    return FlatPart(np.stack([distance[point], corners[:, :, 2]], axis=-1), "z")


def _distances(places: np.ndarray, point: np.ndarray) -> np.ndarray | None:
    """Distance of each point of an open line from its higher end; None if it is not one."""
    ends = np.sort(point[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    steps = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    steps = steps[~_passing(places, steps)]
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


def _passing(places: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return which steps between points pass another point, shape (n,) of bool.

    So do edges of a triangle beside one that is divided further.
    """
    begin = places[steps[:, 0], None]
    along = places[steps[:, 1], None] - begin
    length = np.linalg.norm(along, axis=2)
    arm = places - begin
    share = (arm * along).sum(axis=2) / length**2
    beside = np.abs(arm[..., 0] * along[..., 1] - arm[..., 1] * along[..., 0]) / length
    within = (share > FLAT) & (share < 1.0 - FLAT)
    return (within & (beside <= FLAT * length)).any(axis=1)
