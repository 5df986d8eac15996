"""Short simulations for pictures: snapshots of a case, and wear depth against time by angle."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.dataset import Column
from abradem.dem.model import Case, Setup
from abradem.dem.steady import steady_start
from abradem.export import write_snapshots
from abradem.wear_rate import MM_PER_M, steady_rate

ANGLES = ("plate_angle", "factory_angle")

COLUMNS = {
    "varied": Column("1", "quantity that is varied", "string"),
    "angle": Column("deg", "value of the quantity that is varied"),
    "wear_depth": Column("mm", "mean wear depth of the plate"),
    "rate": Column("mm/s", "steady wear depth rate, mean over the plate"),
    "rate_stderr": Column("mm/s", "its standard error"),
}
"""Columns of the tables by angle beside those of `abradem.dataset.COLUMNS`."""


def write_scene(
    case: Mapping[str, float], setup: Setup, folder: str | Path, duration: float, interval: float
) -> None:
    """Simulate a case for a while and write its snapshots, see `abradem.export`.

    Parameters
    ----------
    case : mapping
        Arguments of `abradem.Case`.
    setup : Setup
    folder : path-like
    duration, interval : float
        Simulated time, and time between snapshots, s.
    """
    write_snapshots(Case(**case), replace(setup, duration=duration), folder, interval)


def depth_frames(
    wear: pd.DataFrame, case: Mapping[str, float], setup: Setup, reading: str = "total"
) -> tuple[np.ndarray, np.ndarray]:
    """Wear depth of every facet at the times of the snapshots.

    Parameters
    ----------
    wear : pandas.DataFrame
        Snapshots as `abradem.export` writes them, of an Archard constant of 1.
    case : mapping
        Holds ``archard_constant``, 1/Pa.
    setup : Setup
    reading : str
        One of `abradem.parameters.READINGS`.

    Returns
    -------
    times : ndarray, shape (n,)
        s.
    depth : ndarray, shape (n, nx, nz)
        mm, along the plate's length and width.
    """
    nx, nz = setup.facets
    ordered = wear.sort_values(["time", "facet_x", "facet_z"], kind="stable")
    times = ordered["time"].to_numpy()[:: nx * nz]
    worn = ordered[f"wear_{reading}"].to_numpy().reshape(len(times), nx, nz)
    return times, MM_PER_M * case["archard_constant"] * nx * nz / setup.plate_area * worn


def depth_by_angle(
    case: Mapping[str, float],
    setup: Setup,
    angles: Mapping[str, Iterable[float]],
    duration: float,
    min_batches: int = 20,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Wear depth of the plate against time for a case whose angles are varied one by one.

    Parameters
    ----------
    case : mapping
        Arguments of `abradem.Case`; its angles hold while the other is varied.
    setup : Setup
    angles : mapping
        Values of each of `ANGLES`, degrees.
    duration : float
        Simulated time of each, s.
    min_batches : int
        Batches behind slope and standard error.

    Returns
    -------
    curves : pandas.DataFrame
        varied, angle (deg), time (s), wear_depth (mm).
    rates : pandas.DataFrame
        varied, angle (deg), rate and rate_stderr (mm/s; nan without wear).

    Raises
    ------
    RuntimeError
        If a simulation ends early.
    """
    from abradem.dem import simulate

    setup = replace(setup, duration=duration)
    curves, rates, known = [], [], {}
    for varied in ANGLES:
        for angle in map(float, angles[varied]):
            values = {**case, varied: angle}
            place = (values["plate_angle"], values["factory_angle"])
            if place not in known:
                known[place] = simulate(Case(**values), setup)
            result = known[place]
            if result.status != "ok":
                raise RuntimeError(f"{varied} = {angle:g} deg: ended early: {result.status}")
            depth = MM_PER_M * case["archard_constant"] / setup.plate_area * result.worn[:, 0]
            row = {"varied": varied, "angle": angle}
            curves.append(pd.DataFrame({**row, "time": result.time, "wear_depth": depth}))
            start = steady_start(result.time, depth).time
            fit = steady_rate(result.time, depth, start, min_batches)
            rates.append({**row, "rate": fit.rate, "rate_stderr": fit.stderr})
    return pd.concat(curves, ignore_index=True), pd.DataFrame(rates)
