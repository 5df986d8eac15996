"""Where the triangles of a surface are at a time, as parts of it turn."""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.surface import Surface


def corners_at(surface: Surface, time: float) -> np.ndarray:
    """Return the corners of the triangles of a surface at a time.

    A part turns by the angular velocity times the time about its axis (formula of Rodrigues); a
    belt stays where it is.

    Parameters
    ----------
    surface : Surface
    time : float
        s.

    Returns
    -------
    ndarray, shape (t, 3, 3)
        For each triangle the positions of its corners, m.
    """
    corners = surface.vertices[surface.triangles]
    for part in turning_parts(surface):
        chosen = surface.part == part
        corners[chosen] = turned_about(
            corners[chosen],
            surface.axis_point[part],
            surface.axis_direction[part],
            float(surface.angular_velocity[part]) * time,
        )
    return corners


def turning_parts(surface: Surface) -> list[int]:
    """Return the numbers of the parts that turn."""
    return [int(part) for part in np.flatnonzero(surface.angular_velocity)]


def turned_about(points: np.ndarray, centre, direction, angle: float) -> np.ndarray:
    """Return points (..., 3) turned by an angle (rad), right-handed, about an axis."""
    axis = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    arm = points - np.asarray(centre, dtype=float)
    along = (arm @ axis)[..., None] * axis
    across = np.cross(np.broadcast_to(axis, arm.shape), arm)
    return centre + along + math.cos(angle) * (arm - along) + math.sin(angle) * across
