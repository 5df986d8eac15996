"""Wear depth of all facets at the times of the snapshots."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.dem.surface import Surface, cell_areas
from abradem.units import MM_PER_M


def depth_frames(
    wear: pd.DataFrame, case: Mapping[str, float], setup: Setup, measure: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the wear depth of all facets at the times of the snapshots.

    The depth is W J / A, with the cumulative work J of a facet and its area A (Archard 1953,
    J. Appl. Phys. 24:981).

    Parameters
    ----------
    wear : pandas.DataFrame
        Snapshots written by `abradem.simulation.snapshots`, for an Archard constant of 1.
    case : mapping
        Contains ``archard_constant`` W, 1/Pa.
    setup : Setup
    measure : str
        One of `abradem.quantities.WEAR_MEASURES`.

    Returns
    -------
    times : ndarray, shape (n,)
        s.
    depth : ndarray, shape (n, nx, nz)
        mm, along the length and the width of the plate.
    """
    nx, nz = setup.facets
    times, worn = _in_order(wear, nx * nz, measure)
    per_work = MM_PER_M * case["archard_constant"] * nx * nz / setup.plate_area
    return times, per_work * worn.reshape(len(times), nx, nz)


def cell_depth_frames(
    wear: pd.DataFrame, case: Mapping[str, float], surface: Surface, measure: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the wear depth of all cells of a surface at the times of the snapshots.

    As `depth_frames`, with the area of each triangle; the cells are the rows ``facet_x`` of the
    snapshots.

    Returns
    -------
    times : ndarray, shape (n,)
        s.
    depth : ndarray, shape (n, t)
        mm.
    """
    times, worn = _in_order(wear, len(surface.triangles), measure)
    return times, MM_PER_M * case["archard_constant"] / cell_areas(surface) * worn


def _in_order(wear: pd.DataFrame, cells: int, measure: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,), s, and cumulative work (n, cells), J."""
    ordered = wear.sort_values(["time", "facet_x", "facet_z"], kind="stable")
    times = ordered["time"].to_numpy()[::cells]
    return times, ordered[f"wear_{measure}"].to_numpy().reshape(len(times), cells)
