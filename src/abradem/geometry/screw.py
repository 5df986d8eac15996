"""A screw conveyor: a helical flight on a shaft, in a trough."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abradem.geometry.shape import GeometryError, Shape, combined, degenerate, selected, welded
from abradem.geometry.shapes import grid


@dataclass(frozen=True)
class ScrewSize:
    """Dimensions of a screw conveyor; its axis is the x axis.

    Parameters
    ----------
    length : float
        From one end of the flight to the other, m.
    radius, shaft_radius : float
        Outer radius of the flight, and radius of the shaft, m.
    pitch : float
        Advance of the flight in a turn, m.
    clearance : float
        Between the flight and the trough, m.
    rim : float
        Height of the walls of the trough above the axis, m.
    """

    length: float
    radius: float
    shaft_radius: float
    pitch: float
    clearance: float
    rim: float


def screw(size: ScrewSize, facet: float) -> Shape:
    """Return flight, shaft and trough, the parts of those names.

    The flight is right-handed, at the angle ``2 pi x / pitch`` about +x (from y to z). A positive
    rotation about +x moves it along -x by the pitch in a turn, so that it conveys towards x = 0,
    where the trough is open; a wall closes it at the other end.

    Parameters
    ----------
    size : ScrewSize
    facet : float
        Largest edge of a facet, m.
    """
    if not 0.0 < size.shaft_radius < size.radius:
        raise GeometryError(
            f"the radius of the shaft, {size.shaft_radius:g} m, must be less than that of the "
            f"flight, {size.radius:g} m"
        )
    inner = size.radius + size.clearance
    turn = 2.0 * math.pi * size.length / size.pitch
    # A coarse facet would make the round flight scrape the trough or leave a gap.
    step = min(facet / inner, math.radians(15.0))
    count = math.ceil(turn / step)
    angle = np.linspace(0.0, turn, count + 1)
    radii = np.linspace(
        size.shaft_radius,
        size.radius,
        max(1, math.ceil((size.radius - size.shaft_radius) / facet)) + 1,
    )
    flight = np.stack(
        [
            np.repeat(size.length * angle[:, None] / turn, radii.size, axis=1),
            np.cos(angle)[:, None] * radii,
            np.sin(angle)[:, None] * radii,
        ],
        axis=-1,
    )
    around = np.linspace(0.0, 2.0 * math.pi, max(12, math.ceil(2.0 * math.pi / step)) + 1)
    stations = np.linspace(0.0, size.length, math.ceil(size.length / facet) + 1)
    shaft = _along(stations, size.shaft_radius * np.column_stack([np.cos(around), np.sin(around)]))
    profile = _profile(inner, size.rim, facet, step)
    trough = _along(stations, profile)
    shapes = [
        grid(flight, "flight"),
        grid(shaft, "shaft"),
        grid(trough, "trough"),
        _end(size.length, profile, size.rim, facet),
    ]
    return welded(combined(shapes))


def _along(stations: np.ndarray, profile: np.ndarray) -> np.ndarray:
    """Points of a profile (y, z) at stations along x, shape (stations, profile, 3)."""
    points = np.empty((stations.size, len(profile), 3))
    points[:, :, 0] = stations[:, None]
    points[:, :, 1:] = profile
    return points


def _profile(inner: float, rim: float, facet: float, step: float) -> np.ndarray:
    """Profile of the trough: a half circle below the axis and a wall up to the rim each side."""
    angles = np.linspace(math.pi, 2.0 * math.pi, math.ceil(math.pi / step) + 1)
    # y is up: the half circle runs from z = -inner below the axis to z = +inner.
    bend = inner * np.column_stack([np.sin(angles), np.cos(angles)])
    heights = np.linspace(0.0, rim, max(1, math.ceil(rim / facet)) + 1)[1:]
    first = np.column_stack([heights[::-1], np.full(heights.size, -inner)])
    last = np.column_stack([heights, np.full(heights.size, inner)])
    return np.concatenate([first, bend, last])


def _end(x: float, profile: np.ndarray, rim: float, facet: float) -> Shape:
    """Wall at an end of the trough: strips between mirrored points of the profile."""
    half = (len(profile) + 1) // 2
    left, right = profile[:half], profile[::-1][:half]
    columns = max(1, math.ceil(np.ptp(profile[:, 1]) / facet))
    share = np.linspace(0.0, 1.0, columns + 1)[None, :, None]
    points = np.empty((half, columns + 1, 3))
    points[:, :, 0] = x
    points[:, :, 1:] = (1.0 - share) * left[:, None, :] + share * right[:, None, :]
    shape = grid(points, "trough")
    # The lowest strip may end in a point, where triangles have no area.
    return selected(shape, ~degenerate(shape))
