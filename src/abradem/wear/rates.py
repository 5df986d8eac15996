"""Wear rates from the results of simulations: steady slope, standard errors and quality flags.

Simulations record, for an Archard constant of 1, the cumulative work J = F_n ds (J) of three wear
measures on the whole plate, and J per facet in one window. By Archard's law (Archard 1953, J. Appl.
Phys. 24:981) the worn volume is W J. Divided by the area it is the depth::

    plate mean    W / A_plate dJ/dt, slope over equal batches of increments of the steady part
    worn          W / A J summed over the elements with any of it, A their area, divided by the
                  length of the window
    footprint     the same over the smallest set of elements with 95 % of it
    p99, max      the 99th percentile and the maximum of W J_element / A_element, divided by the
                  length of the window

An element is a facet, or a square of whole facets: a coarser mesh gives smaller extremes, and one
simulation gives those of all multiples of its facets.

All results are proportional to W, so one simulation is valid for every W.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.dem.steady import BatchMeans, batch_means
from abradem.quantities import (
    STATISTICS,
    STDERR_COLUMNS,
    WEAR_COLUMNS,
    WEAR_MEASURES,
    stderr_column,
    wear_column,
)
from abradem.units import MM_PER_M
from abradem.wear.window_errors import element_stderr, weighted_statistics

SHORTFALL_SHARE = 0.95
"""A case is flagged if the delivered feed is below this share of the requested feed."""

OVERLAP_SHARE = 0.05
"""A case is flagged if its largest overlap is above this share of the radius, where the contact law
becomes inaccurate."""


class SteadyRate(NamedTuple):
    """Steady rate of one cumulative series, J/s, and ``r2`` of the series against a line."""

    rate: float
    stderr: float
    lag1: float
    batches: int
    r2: float


def steady_rate(
    time: np.ndarray,
    worn: np.ndarray,
    start: float,
    batches: int = 20,
    release_interval: float = 0.0,
) -> SteadyRate:
    """Return the rate of a cumulative series from ``start`` on, with its standard error.

    Parameters
    ----------
    time, worn : ndarray, shape (n,)
        Sample times, s, and cumulative work J, J.
    start : float
        Start of the steady state, s.
    batches : int
        Least number of equal batches.
    release_interval : float
        Time between two releases, s; 0 if they are not even.

    Returns
    -------
    SteadyRate
        The rate is the mean increment per time over the batches; the standard error is that of
        `abradem.dem.steady.batch_means`. ``r2`` is not a quality measure: every cumulative series
        has R2 near 1. All are nan if there is no steady part.
    """
    if not np.isfinite(start) or len(time) < 2:
        return SteadyRate(np.nan, np.nan, np.nan, 0, np.nan)
    means: BatchMeans = batch_means(time, worn, start, batches, release_interval)
    tail = time >= start
    return SteadyRate(*means, straightness(time[tail], worn[tail]))


def release_interval(run: Mapping, delivered_mass: float) -> float:
    """Return the time between two releases of a case, s; 0 for given releases.

    Parameters
    ----------
    run : mapping
        Its row of the runs: ``requested_rate``, kg/s, and ``released``.
    delivered_mass : float
        Mass of the released particles, kg.
    """
    released = run.get("released", 0)
    if not (run["requested_rate"] > 0.0 and released > 0):
        return 0.0
    return float(delivered_mass) / int(released) / float(run["requested_rate"])


def straightness(time: np.ndarray, worn: np.ndarray) -> float:
    """Return R2 of a series against its least-squares straight line, or nan if undefined."""
    if len(time) < 3:
        return np.nan
    t, w = time - time.mean(), worn - worn.mean()
    spread = float(w @ w) * float(t @ t)
    return float(t @ w) ** 2 / spread if spread > 0.0 else np.nan


def footprint(wear: np.ndarray, share: float = 0.95) -> np.ndarray:
    """Return the smallest set of facets with ``share`` of the wear, the most worn ones.

    Parameters
    ----------
    wear : ndarray, any shape
        Wear per facet, not negative.
    share : float
        In (0, 1].

    Returns
    -------
    ndarray of bool, shape of ``wear``
        All False if there is no wear. Among equally worn facets, the first in memory is taken.
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


def element_counts(setup: Setup, element_size: float | None) -> tuple[int, int]:
    """Return the number of elements along the length and the width of the plate.

    Parameters
    ----------
    setup : Setup
    element_size : float or None
        Edge of an element, m; None for the facets themselves.

    Raises
    ------
    ValueError
        If the plate does not consist of such elements, or they not of whole facets.
    """
    if element_size is None:
        return setup.facets
    sides = (setup.plate_length, setup.plate_width)
    counts = (
        max(1, round(setup.plate_length / element_size)),
        max(1, round(setup.plate_width / element_size)),
    )
    for side, count, facets in zip(sides, counts, setup.facets, strict=True):
        if abs(side / count - element_size) > 1e-9 * side or facets % count:
            raise ValueError(
                f"element_size = {element_size!r} m does not divide the plate of {side:g} m into "
                f"elements of whole facets ({facets} facets of {side / facets:g} m)"
            )
    return counts


def element_wear(wear: np.ndarray, counts: tuple[int, int]) -> np.ndarray:
    """Return the work of elements, shape ``counts``, from that of facets, shape (nx, nz), J."""
    nx, nz = counts
    return wear.reshape(nx, wear.shape[0] // nx, nz, wear.shape[1] // nz).sum(axis=(1, 3))


def element_rates(
    wear: np.ndarray,
    element_area: float | np.ndarray,
    window: float,
    footprint_share: float = 0.95,
) -> dict[str, float]:
    """Return statistics over the elements of J per area and time, J/(m2 s), except for the mean.

    Parameters
    ----------
    wear : ndarray, shape (nx, nz)
        Work J of each element in the window, J.
    element_area : float or ndarray, shape (nx, nz)
        m2; with different areas, as of the cells of a surface, means and percentiles are weighted
        by them.
    window : float
        Length of the window, s.
    footprint_share : float
        Share of the wear in the footprint.

    Returns
    -------
    dict of str to float
        ``worn``, ``footprint``, ``p99`` and ``max``.
    """
    if isinstance(element_area, np.ndarray):
        found = weighted_statistics(wear.reshape(1, -1), element_area.ravel(), footprint_share)[0]
        return {
            name: float(value) / window for name, value in zip(STATISTICS[1:], found, strict=True)
        }
    density = wear / (element_area * window)
    worn = wear > 0.0
    most_worn = footprint(wear, footprint_share)
    return {
        "worn": float(density[worn].mean()) if worn.any() else 0.0,
        "footprint": float(density[most_worn].mean()) if most_worn.any() else 0.0,
        "p99": float(np.percentile(density, 99.0)),
        "max": float(density.max()),
    }


def depth_map(maps: pd.DataFrame, facets: tuple[int, int]) -> dict[str, np.ndarray]:
    """Return the maps of one case by wear measure, J, shape ``facets``; 0 for missing facets."""
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


def part_maps(parts: pd.DataFrame, count: int, facets: tuple[int, int]) -> dict[str, np.ndarray]:
    """Return the maps of the parts of one case's window by wear measure, J.

    Parameters
    ----------
    parts : pandas.DataFrame
        Rows of one case of the table of parts; facets without wear may be missing.
    count : int
        Number of parts of the window.
    facets : tuple of int

    Returns
    -------
    dict of str to ndarray, shape (count, nx, nz)
    """
    place = tuple(parts[name].to_numpy() for name in ("window_part", "facet_x", "facet_z"))
    arrays = {}
    for measure in WEAR_MEASURES:
        arrays[measure] = np.zeros((count, *facets))
        arrays[measure][place] = parts[f"part_wear_{measure}"].to_numpy(dtype=float)
    return arrays


def wear_rates(
    series: pd.DataFrame,
    maps: pd.DataFrame,
    runs: pd.DataFrame,
    cases: pd.DataFrame,
    setup: Setup,
    min_batches: int = 20,
    footprint_share: float = 0.95,
    element_size: float | None = None,
    parts: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Return the wear rates of the cases of a batch, by Archard's law (Archard 1953).

    Parameters
    ----------
    series, maps, runs : pandas.DataFrame
        Tables written by the simulations (W = 1).
    cases : pandas.DataFrame
        Contains case_id and archard_constant (1/Pa) of at least these cases.
    setup : Setup
        Defines the plate, its facets and the target standard error.
    min_batches : int
        Number of batches of increments for slope and standard error, at least 20.
    footprint_share : float
        Share of the wear of a wear measure in its footprint.
    element_size : float, optional
        Edge of the elements of the statistics, m, see `element_counts`; by default a facet.
    parts : pandas.DataFrame, optional
        Table of the parts of the windows, written by the simulations. Without it the standard
        errors of the statistics over elements are nan, which saves their time.

    Returns
    -------
    pandas.DataFrame
        One row per successful case, by case_id: depth rates (mm/s) for each wear measure and
        statistic and their standard errors (mm/s), ``wear_r2``, ``wear_batches`` and
        ``wear_lag1`` of the headline, ``worn_volume_rate`` (m3/s), ``wear_per_kg`` (m3/kg) and
        ``quality``.

    Raises
    ------
    ValueError
        If ``min_batches`` is below 20, the element size does not fit, or a simulated case has no
        row in ``cases`` or ``series``.
    """
    if min_batches < 20:
        raise ValueError(f"min_batches = {min_batches} must be at least 20")
    # The statistics of a surface are over its cells.
    surface = "cell_area" in maps
    elements = (0, 0) if surface else element_counts(setup, element_size)
    constants = cases.set_index("case_id")["archard_constant"]
    series_of = {key: rows for key, rows in series.groupby("case_id", sort=False)}
    maps_of = {key: rows for key, rows in maps.groupby("case_id", sort=False)}
    parts_of = {} if parts is None else dict(iter(parts.groupby("case_id", sort=False)))
    rows = []
    for run in runs[runs["status"] == "ok"].sort_values("case_id").to_dict("records"):
        key = run["case_id"]
        if key not in constants.index:
            raise ValueError(f"case {key} was simulated but is not among the cases")
        if key not in series_of:
            raise ValueError(f"case {key} was simulated but has no series")
        rates = _case_rates(
            series_of[key],
            maps_of.get(key, maps.iloc[:0]),
            None if parts is None else parts_of.get(key, parts.iloc[:0]),
            run,
            setup,
            min_batches,
            footprint_share,
            elements,
        )
        rows.append({"case_id": key, **_worn(rates, float(constants[key]))})
    return pd.DataFrame(rows, columns=RATE_COLUMNS).astype(
        {"case_id": "int64", "wear_batches": "int32"}
    )


RATE_COLUMNS = [
    "case_id",
    *WEAR_COLUMNS,
    *STDERR_COLUMNS,
    "wear_r2",
    "wear_batches",
    "wear_lag1",
    "worn_volume_rate",
    "wear_per_kg",
    "quality",
]
"""Columns of the wear-rate tables, in order."""

_PROPORTIONAL = (*WEAR_COLUMNS, *STDERR_COLUMNS, "worn_volume_rate", "wear_per_kg")


def quality(run: dict, relative_stderr: float, setup: Setup) -> str:
    """Return the flags of a case joined by "+", or "ok".

    ``shortfall``: less than 95 % of the requested feed was delivered, although what finds no room
    waits for it (``unplaced``). ``overlap``: an overlap
    exceeded 5 % of the radius. ``stderr``: the relative standard error of the plate mean is above
    the target. ``unsteady``: no steady state, no full window after it, or (if the runs have the
    column ``settled``) a record that still drifts at its end.
    """
    window = run["window_end"] - run["window_start"]
    steady = np.isfinite(run["steady_from"]) and window > 0.0 and run.get("settled", True)
    flags = {
        # Given releases have no requested rate (nan); the comparison is then False.
        "shortfall": setup.unplaced == "wait"
        and run["delivered_rate"] < SHORTFALL_SHARE * run["requested_rate"],
        "overlap": not run["max_overlap"] <= OVERLAP_SHARE,
        "stderr": not relative_stderr <= setup.target_stderr,
        "unsteady": not steady,
    }
    return "+".join(name for name, raised in flags.items() if raised) or "ok"


def _case_rates(
    series: pd.DataFrame,
    maps: pd.DataFrame,
    parts: pd.DataFrame | None,
    run: dict,
    setup: Setup,
    batches: int,
    footprint_share: float,
    elements: tuple[int, int],
) -> dict:
    """Return the row of one case for W = 1; depth rates in mm/s per 1/Pa, others accordingly."""
    time = series["time"].to_numpy(dtype=float)
    start = run["steady_from"]
    delivered = series["delivered_mass"].to_numpy(dtype=float)
    interval = release_interval(run, delivered[-1])
    steady = {
        measure: steady_rate(
            time, series[f"worn_{measure}"].to_numpy(dtype=float), start, batches, interval
        )
        for measure in WEAR_MEASURES
    }
    window = run["window_end"] - run["window_start"]
    facets, area, element_area = _areas(maps, setup, elements)
    if isinstance(element_area, np.ndarray):
        elements = facets
    arrays = depth_map(maps, facets)
    parted = None
    if parts is not None and window > 0.0:
        parted = part_maps(parts, run["window_parts"], facets)
    unknown = dict.fromkeys(STATISTICS[1:], np.nan)
    row: dict[str, Any] = {}
    for measure in WEAR_MEASURES:
        rates, errors = unknown, unknown
        if window > 0.0:
            rates = element_rates(
                element_wear(arrays[measure], elements), element_area, window, footprint_share
            )
        if parted is not None:
            errors = element_stderr(
                np.array([element_wear(part, elements) for part in parted[measure]]),
                element_area,
                window,
                footprint_share,
            )
        mean = steady[measure]
        for statistic, value, error in (
            ("mean", mean.rate / area, mean.stderr / area),
            *((name, rates[name], errors[name]) for name in STATISTICS[1:]),
        ):
            name = wear_column(measure, statistic)
            row[name], row[stderr_column(name)] = MM_PER_M * value, MM_PER_M * error
    total = steady["total"]
    row["wear_r2"] = total.r2
    row["wear_batches"] = total.batches
    row["wear_lag1"] = total.lag1
    row["worn_volume_rate"] = total.rate
    fed = _feed_rate(time, delivered, start)
    row["wear_per_kg"] = total.rate / fed if fed > 0.0 else np.nan
    relative = total.stderr / total.rate if total.rate > 0.0 else np.nan
    row["quality"] = quality(run, relative, setup)
    return row


def _areas(
    maps: pd.DataFrame, setup: Setup, elements: tuple[int, int]
) -> tuple[tuple[int, int], float, float | np.ndarray]:
    """Return number of facets, area of the plate or surface, and of the elements, m2."""
    if "cell_area" not in maps:
        return setup.facets, setup.plate_area, setup.plate_area / math.prod(elements)
    areas = np.empty((len(maps), 1))
    areas[maps["facet_x"].to_numpy(), 0] = maps["cell_area"].to_numpy(dtype=float)
    return areas.shape, float(areas.sum()), areas


def _worn(row: dict, archard_constant: float) -> dict:
    """Return a row for W = 1 scaled to W, which is exact."""
    return {k: v * archard_constant if k in _PROPORTIONAL else v for k, v in row.items()}


def _feed_rate(time: np.ndarray, delivered: np.ndarray, start: float) -> float:
    """Return the mass delivered per time over the steady part, kg/s."""
    if not (np.isfinite(start) and time[-1] > start):
        return np.nan
    return float(delivered[-1] - np.interp(start, time, delivered)) / (time[-1] - start)
