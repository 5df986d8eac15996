"""Wear depth of all facets at the times of the snapshots."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
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
    ordered = wear.sort_values(["time", "facet_x", "facet_z"], kind="stable")
    times = ordered["time"].to_numpy()[:: nx * nz]
    worn = ordered[f"wear_{measure}"].to_numpy().reshape(len(times), nx, nz)
    return times, MM_PER_M * case["archard_constant"] * nx * nz / setup.plate_area * worn
