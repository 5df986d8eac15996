"""A scene in three dimensions as one page: particles and wear, played and turned offline.

The page holds the snapshots of a case. Its parts are in ``scene_page``; they are drawn by
plotly.js, which the package plotly brings, with WebGL.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import to_hex

from abradem.dem.model import Setup
from abradem.dem.surface import Surface
from abradem.figures.render import Patch, patch_corners
from abradem.figures.wear_colours import NO_WEAR, scale_top, wear_colours
from abradem.geometry.build import prepared
from abradem.geometry.turning import turning_parts
from abradem.report.page_data import stored, whole_page
from abradem.report.page_files import SCENE_FILES
from abradem.report.vtk import plate_facets
from abradem.wear.depths import cell_depth_frames, depth_frames

MOST_BYTES = 3_000_000
"""Largest size of the snapshots in the page, before base64; frames are left out evenly beyond."""

MARGIN = 0.15
"""Space around surface and factory in which particles are drawn, relative to their extent."""

_PER_PARTICLE, _PER_CELL = 16, 4


def scene_page(
    particles: pd.DataFrame,
    wear: pd.DataFrame,
    study: str,
    case: Mapping[str, float],
    setup: Mapping[str, Any],
    measure: str,
) -> str:
    """The page as HTML.

    Parameters
    ----------
    particles, wear : pandas.DataFrame
        Snapshots from `abradem.simulation.snapshots`.
    study : str
    case, setup : mapping
        Plain values of `Case` and `Setup`.
    measure : str
        Wear measure.
    """
    data = scene_data(particles, wear, study, case, Setup.from_dict(setup), measure)
    return whole_page(f"Particles and wear: {study}", SCENE_FILES, data, [["page.js"]])


def scene_data(
    particles: pd.DataFrame,
    wear: pd.DataFrame,
    study: str,
    case: Mapping[str, float],
    setup: Setup,
    measure: str,
) -> dict[str, Any]:
    """What the page knows; see `scene_page`. Lengths in m, depths in mm, times in s.

    Places and depths have single precision. Of many snapshots some are left out, evenly, but
    never the last.
    """
    setup = prepared(setup, case)
    surface, feed = setup.surface, setup.feed
    turning: list[dict[str, Any]] = []
    if surface is None or feed is None:
        vertices, quads = plate_facets(case["plate_angle"], setup)
        triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
        times, depth = depth_frames(wear, case, setup, measure)
        height, tilt = setup.patch_place(case["factory_angle"])
        factory = Patch(setup.patch_length, setup.patch_width, height, tilt).corners()
    else:
        vertices, triangles, turning = _moving(surface)
        times, depth = cell_depth_frames(wear, case, surface, measure)
        factory = patch_corners(feed)
    depth = depth.reshape(len(times), -1)
    kept = kept_frames(len(times), _PER_PARTICLE * len(particles) + _PER_CELL * depth.size)
    by_time = dict(tuple(particles.groupby("time")))
    shown = [by_time.get(time, particles.iloc[:0]) for time in times[kept]]
    rows = pd.concat(shown)
    return {
        "study": study,
        "about": _about(case, surface is None),
        "measure": measure,
        "snapshots": len(times),
        "times": stored(times[kept]),
        "counts": stored(np.array([len(frame) for frame in shown], dtype=float)),
        "places": stored(rows[["x", "y", "z"]].to_numpy(dtype=np.float32)),
        "identities": stored(rows["particle"].to_numpy(dtype=np.float32)),
        "radius": float(case["particle_radius"]),
        "vertices": stored(np.asarray(vertices, dtype=np.float32)),
        "triangles": stored(np.asarray(triangles, dtype=float)),
        # Walls of a geometry do not hide what is behind them.
        "see_through": surface is not None,
        "turning": turning,
        "cell": "facets" if surface is None else "cells",
        "depth": stored(depth[kept].astype(np.float32)),
        "top": scale_top(depth[-1]),
        "colours": [to_hex(colour) for colour in wear_colours()(np.linspace(0.0, 1.0, 64))],
        "no_wear": NO_WEAR.lower(),
        "factory": factory.tolist(),
        "box": _box(np.concatenate([vertices, factory])),
    }


def _moving(surface: Surface) -> tuple[np.ndarray, np.ndarray, list[dict[str, Any]]]:
    """Vertices, which no two motions share, triangles, and what turns with its vertices."""
    parts = turning_parts(surface)
    motions = [
        (float(surface.angular_velocity[part]), tuple(map(float, surface.axis_point[part])),
         tuple(map(float, surface.axis_direction[part])))
        for part in parts
    ]  # fmt: skip
    kinds = list(dict.fromkeys(motions))
    motion_of_part = np.zeros(len(surface.part_names), dtype=np.int64)
    for part, motion in zip(parts, motions, strict=True):
        motion_of_part[part] = 1 + kinds.index(motion)
    motion_of_corner = np.repeat(motion_of_part[surface.part][:, None], 3, axis=1)
    pairs, corners = np.unique(
        np.stack([surface.triangles, motion_of_corner], axis=-1).reshape(-1, 2),
        axis=0, return_inverse=True,
    )  # fmt: skip
    turning = [
        {
            "spin": spin,
            "point": list(point),
            "direction": (np.array(direction) / np.linalg.norm(direction)).tolist(),
            "vertices": np.flatnonzero(pairs[:, 1] == 1 + kind).tolist(),
        }
        for kind, (spin, point, direction) in enumerate(kinds)
    ]
    return surface.vertices[pairs[:, 0]], corners.reshape(-1, 3), turning


def kept_frames(count: int, size: int) -> np.ndarray:
    """Numbers of the frames that the page holds: every n-th, counted from the last."""
    every = max(1, math.ceil(size / MOST_BYTES))
    return np.arange(count)[::-1][::every][::-1]


def _box(points: np.ndarray) -> list[list[float]]:
    """Lowest and highest corner of the box that is drawn, m."""
    low, high = points.min(axis=0), points.max(axis=0)
    space = MARGIN * float((high - low).max())
    return [(low - space).tolist(), (high + space).tolist()]


def _about(case: Mapping[str, float], plate: bool) -> str:
    angle = f"plate at {case['plate_angle']:.4g}°, " if plate else ""
    speed = abs(case["particle_velocity_y"])
    factory = f", factory at {case['factory_angle']:.4g}°" if plate else ""
    return (
        f"{angle}particles of {1e3 * case['particle_radius']:.4g} mm radius at {speed:.4g} m/s"
        f"{factory}"
    )
