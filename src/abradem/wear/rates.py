"""From what a simulation wrote to wear rates: steady slope, its error, its quality.

Simulations record, for an Archard constant of 1, the cumulative work J = F_n ds (J) of three
wear measures on the whole plate, and J per facet within one window. Archard's law makes the worn
volume W J and, per area, the depth::

    plate mean    W / A_plate dJ/dt, slope over equal batches of increments of the steady part
    footprint     W / A J summed over the fewest facets that hold 95 % of it, A their area,
                  per length of the window
    p99, max      the 99th percentile and the largest of W J_facet / A_facet, per length of the
                  window

W is a factor of everything here, so one simulation serves every W.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.dem.steady import BatchMeans, batch_means
from abradem.quantities import WEAR_COLUMNS, WEAR_MEASURES, wear_column
from abradem.units import MM_PER_M

SHORTFALL_SHARE = 0.95
"""Feed achieved below this share of the feed asked for is flagged."""

OVERLAP_SHARE = 0.05
"""Largest overlap above this share of the radius is flagged: the contact law is then strained."""


class SteadyRate(NamedTuple):
    """Steady part of one cumulative series; rates in J/s, ``r2`` of its straight line."""

    rate: float
    stderr: float
    lag1: float
    batches: int
    r2: float


def steady_rate(time: np.ndarray, worn: np.ndarray, start: float, batches: int = 20) -> SteadyRate:
    """Rate of a cumulative series from ``start`` on, with its standard error.

    Parameters
    ----------
    time, worn : ndarray, shape (n,)
        Sample times, s, and cumulative J, J.
    start : float
        Where the steady state begins, s.
    batches : int
        Number of equal batches.

    Returns
    -------
    SteadyRate
        The rate is the mean of the batches' increments per time, the standard error that of
        `abradem.dem.steady.batch_means`. ``r2`` only describes the series: a cumulative
        series has R2 near 1 whatever happens. All nan if there is no steady part.
    """
    if not np.isfinite(start) or len(time) < 2:
        return SteadyRate(np.nan, np.nan, np.nan, 0, np.nan)
    means: BatchMeans = batch_means(time, worn, start, batches)
    tail = time >= start
    return SteadyRate(*means, straightness(time[tail], worn[tail]))


def straightness(time: np.ndarray, worn: np.ndarray) -> float:
    """R2 of a series against its least-squares straight line; nan where undefined."""
    if len(time) < 3:
        return np.nan
    t, w = time - time.mean(), worn - worn.mean()
    spread = float(w @ w) * float(t @ t)
    return float(t @ w) ** 2 / spread if spread > 0.0 else np.nan


def footprint(wear: np.ndarray, share: float = 0.95) -> np.ndarray:
    """Which facets hold ``share`` of the wear: the fewest that do, the most worn first.

    Parameters
    ----------
    wear : ndarray, any shape
        Wear per facet, not negative.
    share : float
        In (0, 1].

    Returns
    -------
    ndarray of bool, shape of ``wear``
        None if nothing is worn; of equally worn facets the first in memory come first.
    """
    flat = np.asarray(wear, dtype=float).ravel()
    chosen = np.zeros(flat.size, dtype=bool)
    if flat.sum() > 0.0:
        order = np.argsort(-flat, kind="stable")
        held = np.cumsum(flat[order])
        tiny = 1e-12
        enough = int(np.searchsorted(held, share * (1.0 - tiny) * held[-1])) + 1
        chosen[order[:enough]] = True
    return chosen.reshape(np.shape(wear))


def facet_rates(
    wear: np.ndarray, facet_area: float, window: float, footprint_share: float = 0.95
) -> dict[str, float]:
    """Statistics over facets of J per area and time, J/(m2 s); without the plate's mean.

    Parameters
    ----------
    wear : ndarray, shape (nx, nz)
        J within the window, J.
    facet_area : float
        m2.
    window : float
        Length of the window, s.
    footprint_share : float
        Share of the wear that the footprint holds.
    """
    density = wear / (facet_area * window)
    worn = footprint(wear, footprint_share)
    return {
        "footprint": float(density[worn].mean()) if worn.any() else 0.0,
        "p99": float(np.percentile(density, 99.0)),
        "max": float(density.max()),
    }


def depth_map(maps: pd.DataFrame, facets: tuple[int, int]) -> dict[str, np.ndarray]:
    """Maps of one case as arrays of shape ``facets``, by wear measure, J; absent facets are unworn."""
    x, z = maps["facet_x"].to_numpy(), maps["facet_z"].to_numpy()
    if len(maps) and not (
        0 <= x.min() <= x.max() < facets[0] and 0 <= z.min() <= z.max() < facets[1]
    ):
        raise ValueError(f"map holds facet ({x.max()}, {z.max()}), the plate {facets} facets")
    arrays = {}
    for measure in WEAR_MEASURES:
        arrays[measure] = np.zeros(facets)
        arrays[measure][x, z] = maps[f"wear_{measure}"].to_numpy(dtype=float)
    return arrays


def wear_rates(
    series: pd.DataFrame,
    maps: pd.DataFrame,
    runs: pd.DataFrame,
    cases: pd.DataFrame,
    setup: Setup,
    min_batches: int = 20,
    footprint_share: float = 0.95,
) -> pd.DataFrame:
    """Wear rates of the cases of a batch.

    Parameters
    ----------
    series, maps, runs : pandas.DataFrame
        As the simulations wrote them (W = 1).
    cases : pandas.DataFrame
        Holds case_id and archard_constant (1/Pa) of at least these cases.
    setup : Setup
        Gives the plate, its facets and the standard error aimed at.
    min_batches : int
        Batches of increments behind slope and standard error, at least 20.
    footprint_share : float
        Share of a wear measure's wear that its footprint holds.

    Returns
    -------
    pandas.DataFrame
        One row per case that ended well, by case_id: depth rates (mm/s) for each wear measure and
        statistic, ``wear_total_mean_stderr`` (mm/s), ``wear_r2``, ``wear_batches``,
        ``wear_lag1``, ``worn_volume_rate`` (m3/s), ``wear_per_kg`` (m3/kg) and ``quality``.
    """
    if min_batches < 20:
        raise ValueError(f"min_batches = {min_batches} must be at least 20")
    constants = cases.set_index("case_id")["archard_constant"]
    series_of = {key: rows for key, rows in series.groupby("case_id", sort=False)}
    maps_of = {key: rows for key, rows in maps.groupby("case_id", sort=False)}
    rows = []
    for run in runs[runs["status"] == "ok"].sort_values("case_id").to_dict("records"):
        key = run["case_id"]
        if key not in constants.index:
            raise ValueError(f"case {key} was simulated but is not among the cases")
        if key not in series_of:
            raise ValueError(f"case {key} ended well but has no series")
        rates = _case_rates(
            series_of[key],
            maps_of.get(key, maps.iloc[:0]),
            run,
            setup,
            min_batches,
            footprint_share,
        )
        rows.append({"case_id": key, **_worn(rates, float(constants[key]))})
    return pd.DataFrame(rows, columns=RATE_COLUMNS).astype(
        {"case_id": "int64", "wear_batches": "int32"}
    )


RATE_COLUMNS = [
    "case_id",
    *WEAR_COLUMNS,
    "wear_total_mean_stderr",
    "wear_r2",
    "wear_batches",
    "wear_lag1",
    "worn_volume_rate",
    "wear_per_kg",
    "quality",
]
"""Columns of the wear-rate tables, in order."""

_PROPORTIONAL = (*WEAR_COLUMNS, "wear_total_mean_stderr", "worn_volume_rate", "wear_per_kg")


def quality(run: dict, relative_stderr: float, setup: Setup) -> str:
    """Flags of a case joined by "+", or "ok".

    ``shortfall``: less than 95 % of the feed was delivered. ``overlap``: an overlap exceeded
    5 % of the radius. ``stderr``: the relative standard error of the plate mean is above the
    one aimed at. ``unsteady``: no steady state, no full window after it, or (where the runs
    say whether the record had ``settled``) a record that still drifts at its end.
    """
    window = run["window_end"] - run["window_start"]
    steady = np.isfinite(run["steady_from"]) and window > 0.0 and run.get("settled", True)
    flags = {
        # A schedule of releases asks for no rate; there is then nothing to fall short of.
        "shortfall": run["delivered_rate"] < SHORTFALL_SHARE * run["requested_rate"],
        "overlap": not run["max_overlap"] <= OVERLAP_SHARE,
        "stderr": not relative_stderr <= setup.target_stderr,
        "unsteady": not steady,
    }
    return "+".join(name for name, raised in flags.items() if raised) or "ok"


def _case_rates(
    series: pd.DataFrame,
    maps: pd.DataFrame,
    run: dict,
    setup: Setup,
    batches: int,
    footprint_share: float,
) -> dict:
    """The row of one case for W = 1; depth rates in mm/s per 1/Pa and so on."""
    time = series["time"].to_numpy(dtype=float)
    start = run["steady_from"]
    steady = {
        measure: steady_rate(time, series[f"worn_{measure}"].to_numpy(dtype=float), start, batches)
        for measure in WEAR_MEASURES
    }
    nx, nz = setup.facets
    window = run["window_end"] - run["window_start"]
    arrays = depth_map(maps, setup.facets)
    row = {}
    for measure in WEAR_MEASURES:
        row[wear_column(measure, "mean")] = MM_PER_M * steady[measure].rate / setup.plate_area
        over_facets = (
            facet_rates(arrays[measure], setup.plate_area / (nx * nz), window, footprint_share)
            if window > 0.0
            else dict.fromkeys(("footprint", "p99", "max"), np.nan)
        )
        for statistic, value in over_facets.items():
            row[wear_column(measure, statistic)] = MM_PER_M * value
    total = steady["total"]
    row["wear_total_mean_stderr"] = MM_PER_M * total.stderr / setup.plate_area
    row["wear_r2"] = total.r2
    row["wear_batches"] = total.batches
    row["wear_lag1"] = total.lag1
    row["worn_volume_rate"] = total.rate
    fed = _feed_rate(time, series["delivered_mass"].to_numpy(dtype=float), start)
    row["wear_per_kg"] = total.rate / fed if fed > 0.0 else np.nan
    relative = total.stderr / total.rate if total.rate > 0.0 else np.nan
    row["quality"] = quality(run, relative, setup)
    return row


def _worn(row: dict, archard_constant: float) -> dict:
    """A row for W = 1 scaled to W, which is exact."""
    return {k: v * archard_constant if k in _PROPORTIONAL else v for k, v in row.items()}


def _feed_rate(time: np.ndarray, delivered: np.ndarray, start: float) -> float:
    """Mass delivered per time over the steady part, kg/s."""
    if not (np.isfinite(start) and time[-1] > start):
        return np.nan
    return float(delivered[-1] - np.interp(start, time, delivered)) / (time[-1] - start)
