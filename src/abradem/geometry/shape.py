"""Triangles with named parts: what generators and mesh files give, and how it is divided."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class GeometryError(ValueError):
    """A geometry that cannot be used, in one line: what, which value, what is allowed."""


class Shape(NamedTuple):
    """A triangulated surface with named parts.

    Attributes
    ----------
    vertices : ndarray, shape (v, 3)
        m; y points up.
    triangles : ndarray of int, shape (t, 3)
        Vertices of each triangle; the normal is (b - a) x (c - a).
    part : ndarray of int, shape (t,)
        Number of the part of each triangle.
    names : tuple of str
        Names of the parts.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    part: np.ndarray
    names: tuple[str, ...]


def cross_products(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return (b - a) x (c - a) of each triangle, shape (t, 3), m2: twice the area vector."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def areas(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the area of each triangle, shape (t,), m2."""
    return 0.5 * np.linalg.norm(cross_products(vertices, triangles), axis=1)


def unit_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the unit normal of each triangle, shape (t, 3)."""
    across = cross_products(vertices, triangles)
    return across / np.linalg.norm(across, axis=1, keepdims=True)


def largest_extent(vertices: np.ndarray) -> float:
    """Return the largest extent along the axes, m."""
    return float(np.ptp(vertices, axis=0).max())


def centres(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the centroid of each triangle, shape (t, 3), m."""
    return vertices[triangles].mean(axis=1)


def combined(shapes: list[Shape]) -> Shape:
    """Return several shapes as one; parts of the same name stay one part.

    Vertices of different shapes are not joined: see `welded`.
    """
    names = tuple(dict.fromkeys(name for shape in shapes for name in shape.names))
    vertices, triangles, parts, first = [], [], [], 0
    for shape in shapes:
        vertices.append(shape.vertices)
        triangles.append(shape.triangles + first)
        first += len(shape.vertices)
        parts.append(np.array([names.index(name) for name in shape.names])[shape.part])
    return Shape(np.concatenate(vertices), np.concatenate(triangles), np.concatenate(parts), names)


WELD = 1e-7
"""Distance, as a share of the extent, within which vertices are one: the rounding of the 32-bit
numbers of an STL file."""


def welded(shape: Shape) -> Shape:
    """Return the shape with vertices within `WELD` of the extent as one, in their first order.

    Contacts on a seam need to know which triangles meet there.
    """
    extent = largest_extent(shape.vertices)
    grid = np.round(shape.vertices / (WELD * extent)).astype(np.int64)
    _, first, inverse = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(order.size)
    return shape._replace(
        vertices=shape.vertices[first[order]], triangles=rank[inverse.ravel()][shape.triangles]
    )


def degenerate(shape: Shape) -> np.ndarray:
    """Return which triangles have no area, shape (t,) of bool.

    They are those whose height over their longest edge is at most `WELD` of the extent: the
    corners of a triangle without area are not exactly on a line once they are rounded.
    """
    corners = shape.vertices[shape.triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    extent = largest_extent(shape.vertices)
    return 2.0 * areas(shape.vertices, shape.triangles) <= WELD * extent * edges


def given_twice(shape: Shape) -> np.ndarray:
    """Return which triangles have the vertices of an earlier one, shape (t,) of bool."""
    corners = np.sort(shape.triangles, axis=1)
    _, first = np.unique(corners, axis=0, return_index=True)
    found = np.ones(len(corners), dtype=bool)
    found[first] = False
    return found


def selected(shape: Shape, chosen: np.ndarray) -> Shape:
    """Return the shape with the chosen triangles alone, shape (t,) of bool."""
    return shape._replace(triangles=shape.triangles[chosen], part=shape.part[chosen])


MOST_ROUNDS = 40
"""Most halvings of an edge; more would be a facet size of nothing."""


def divided(shape: Shape, longest: float, most: int) -> Shape:
    """Return the shape with triangles divided until no edge is longer than ``longest``.

    Every edge that is too long is halved, in all triangles that share it, so that neighbours
    still meet vertex to vertex. The pieces of a triangle fill it: areas are kept to rounding.

    Parameters
    ----------
    shape : Shape
    longest : float
        Longest edge, m.
    most : int
        Most triangles.

    Raises
    ------
    GeometryError
        If there would be more triangles.
    """
    vertices, triangles, part = shape.vertices, shape.triangles, shape.part
    for _ in range(MOST_ROUNDS):
        ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
        edges, place = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
        length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
        # The tolerance keeps an edge that has the length to rounding.
        long = length > longest * (1.0 + 1e-9)
        if not long.any():
            return Shape(vertices, triangles, part, shape.names)
        if len(triangles) + long.sum() > most:
            extent = largest_extent(shape.vertices)
            raise GeometryError(
                f"facets of {longest / np.sqrt(2.0):g} m divide the surface, {extent:.4g} m large, "
                f"into more than {most} triangles (allowed: larger facets)"
            )
        middle = np.full(len(edges), -1)
        middle[long] = len(vertices) + np.arange(long.sum())
        halves = 0.5 * (vertices[edges[long, 0]] + vertices[edges[long, 1]])
        vertices = np.concatenate([vertices, halves])
        triangles, part = _split(vertices, triangles, part, middle[place.reshape(-1, 3)])
    raise GeometryError(f"facets of {longest / np.sqrt(2.0):g} m are too small for the surface")


def _split(vertices, triangles, part, middle):
    """Split triangles at the middles of their edges, shape (t, 3), -1 for a whole edge."""
    # Turned so that the patterns of one and of two halved edges begin with a halved edge whose
    # predecessor is whole.
    count = (middle >= 0).sum(axis=1)
    begin = np.zeros(len(triangles), dtype=np.int64)
    for corner in range(3):
        starts = (middle[:, corner] >= 0) & (middle[:, corner - 1] < 0)
        begin[starts & (count < 3)] = corner
    turn = (begin[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles, turn, axis=1).T
    p, q, r = np.take_along_axis(middle, turn, axis=1).T

    def pieces(chosen, *corners):
        return [np.column_stack(corner)[chosen] for corner in corners]

    new = [np.column_stack([a, b, c])[count == 0]]
    rows = [np.flatnonzero(count == 0)]
    one, two, three = (count == number for number in (1, 2, 3))
    for piece in pieces(one, (a, p, c), (p, b, c)):
        new.append(piece)
        rows.append(np.flatnonzero(one))
    # The quadrilateral a p q c of two halved edges is divided along its shorter diagonal.
    safe_p, safe_q = np.where(two, p, 0), np.where(two, q, 0)
    to_q = np.linalg.norm(vertices[a] - vertices[safe_q], axis=1)
    to_c = np.linalg.norm(vertices[safe_p] - vertices[c], axis=1)
    from_a = two & (to_q <= to_c)
    from_p = two & ~(to_q <= to_c)
    for chosen, corners in (
        (two, [(p, b, q)]),
        (from_a, [(a, p, q), (a, q, c)]),
        (from_p, [(a, p, c), (p, q, c)]),
        (three, [(a, p, r), (p, b, q), (r, q, c), (p, q, r)]),
    ):
        for piece in pieces(chosen, *corners):
            new.append(piece)
            rows.append(np.flatnonzero(chosen))
    order = np.argsort(np.concatenate(rows), kind="stable")
    return np.concatenate(new)[order], part[np.concatenate(rows)[order]]
