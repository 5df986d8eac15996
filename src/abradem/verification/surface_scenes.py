"""Surfaces for checks: profiles extruded along z, planes cut into triangles, arcs and drums."""

from __future__ import annotations

import numpy as np

from abradem.dem.surface import Surface, standing_surface


def extruded(profile, width: float, across: int = 1, closed: bool = False) -> Surface:
    """Return the surface that a profile sweeps along z.

    Parameters
    ----------
    profile : array_like, shape (n, 2)
        Points (x, y), m.
    width : float
        Extent along z, from -width/2 to width/2, m.
    across : int
        Number of strips along z.
    closed : bool
        Whether the last point is joined to the first.

    Returns
    -------
    Surface
        Two triangles for each segment and strip.
    """
    profile = np.asarray(profile, dtype=float)
    sides = np.linspace(-0.5 * width, 0.5 * width, across + 1)
    points = [(x, y, z) for x, y in profile for z in sides]
    row = across + 1
    segments = len(profile) if closed else len(profile) - 1
    triangles = []
    for s in range(segments):
        for c in range(across):
            a, b = s * row + c, (s + 1) % len(profile) * row + c
            triangles += [(a, a + 1, b), (a + 1, b + 1, b)]
    return standing_surface(np.array(points), triangles)


def cut_plane(
    length: float, width: float, angle_deg: float, cells: tuple[int, int], irregular: bool = False
) -> Surface:
    """Return the plate as a surface of 2 nx nz triangles.

    Parameters
    ----------
    length, width : float
        Extent along the slope and along z, m.
    angle_deg : float
        Angle of the plate about +z.
    cells : tuple of int
        Numbers (nx, nz) of rectangles along the slope and along z.
    irregular : bool
        Move the inner vertices within the plane at random and halve each cell along a random
        diagonal.

    Returns
    -------
    Surface
    """
    nx, nz = cells
    along, across = np.meshgrid(
        np.linspace(-0.5 * length, 0.5 * length, nx + 1),
        np.linspace(-0.5 * width, 0.5 * width, nz + 1),
        indexing="ij",
    )
    rng = np.random.default_rng(0)
    if irregular:
        for grid, step in ((along, length / nx), (across, width / nz)):
            grid[1:-1, 1:-1] += 0.35 * step * rng.uniform(-1.0, 1.0, (nx - 1, nz - 1))
    angle = np.radians(angle_deg)
    vertices = np.stack([along * np.cos(angle), along * np.sin(angle), across], axis=2)
    number = np.arange((nx + 1) * (nz + 1)).reshape(nx + 1, nz + 1)
    triangles = []
    for i in range(nx):
        for j in range(nz):
            a, b, c, d = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
            if irregular and rng.random() < 0.5:
                triangles += [(a, d, b), (d, c, b)]
            else:
                triangles += [(a, c, b), (a, d, c)]
    return standing_surface(vertices.reshape(-1, 3), triangles)


def room_corner(side: float) -> Surface:
    """Return three square walls of edge length ``side``, m, on the axes' planes from the origin."""
    points = [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 1, 0)]
    triangles = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (0, 5, 4), (0, 4, 6), (0, 6, 1)]
    return standing_surface(side * np.array(points, dtype=float), triangles)


def arc(radius: float, begin_deg: float, end_deg: float, segments: int, width: float) -> Surface:
    """Return a part of a cylinder about the z axis; 0 is its lowest line, angles about +z."""
    angles = np.radians(np.linspace(begin_deg, end_deg, segments + 1))
    # The segments touch the cylinder from outside, in their middle.
    corner = radius / np.cos(0.5 * (angles[1] - angles[0]))
    return extruded(corner * np.stack([np.sin(angles), -np.cos(angles)], axis=1), width)


def drum(radius: float, segments: int, width: float, spin: float, ends: bool = False) -> Surface:
    """Return a cylinder about the z axis that turns with ``spin`` rad/s, open or with its ends."""
    angles = np.arange(segments) * 2.0 * np.pi / segments
    corner = radius / np.cos(np.pi / segments)
    profile = corner * np.stack([np.sin(angles), -np.cos(angles)], axis=1)
    surface = extruded(profile, width, closed=True)
    if ends:
        # The corners alternate between the two ends; a fan about the middle of each closes it.
        corners = surface.vertices
        middles = [(0.0, 0.0, -0.5 * width), (0.0, 0.0, 0.5 * width)]
        fans = [
            (len(corners) + end, 2 * s + end, 2 * (s + 1) % len(corners) + end)
            for s in range(segments)
            for end in (0, 1)
        ]
        surface = standing_surface(
            np.concatenate([corners, middles]), np.concatenate([surface.triangles, fans])
        )
    return surface._replace(angular_velocity=np.array([spin]))


def belt(length: float, width: float, angle_deg: float, speed: float) -> Surface:
    """Return a plane of 2 x 10 x 2 triangles whose surface moves up its slope, m/s."""
    angle = np.radians(angle_deg)
    surface = cut_plane(length, width, angle_deg, (10, 2), irregular=True)
    velocity = speed * np.array([[np.cos(angle), np.sin(angle), 0.0]])
    return surface._replace(velocity=velocity)
