"""Where the steady state begins, and how well its rate is known.

The cumulative worn volume is a random walk around a straight line, so the usual standard error
of a fitted slope is far too small. Rates are therefore judged by batch means of *increments*.

A bed that fills shields the plate more and more. The particles present show that sooner and with
less noise than the wear, so a steady state is one of both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

BIN = 0.1
"""Width of the increments that the transient rule looks at, s."""

LAG1_QUANTILE = 1.645
"""One-sided 95 % bound of a normal variable: larger lag-1 correlations are believed."""

LEAST_BINS = 20
"""Bins that a late truncation must leave, as the scatter of a few says nothing."""

ROUNDING = 1e-18
"""Variance, as a share of the mean square, that is none."""

LARGEST_CHANGE = 0.2
"""Change of wear rate or particles present over the steady part, as a share of their mean, above
which it is none. The wear of a bed falls by up to 1.2 % where its particles grow by 1 %, so that
the mean over the part can differ by a tenth from that at its end. What fills more slowly is not
seen; docs/method.md says by how much beds were off."""

SIGNIFICANT = 3.0
"""Standard errors that such a change must have, lest chance keep few large particles unsteady."""


class SteadyStart(NamedTuple):
    """Outcome of the transient rule."""

    time: float
    settled: bool


class BatchMeans(NamedTuple):
    """Rate of a cumulative series with its standard error, both per second."""

    rate: float
    stderr: float
    lag1: float
    batches: int


class Change(NamedTuple):
    """Change of a rate over a part of its record, as a share of its mean there."""

    change: float
    stderr: float


def steady_part(
    time: np.ndarray, worn: np.ndarray, present: np.ndarray, window: float
) -> SteadyStart:
    """Return where both the wear and the particles present are steady.

    The transient of the wear ends by `steady_start`. If the particles present still change from
    there on, the part begins where their own transient ends. Neither may change in it by more
    than `LARGEST_CHANGE`, unless by chance. What is not steady by a truncation in the first half
    of the record may be by a later one that leaves the window.

    Parameters
    ----------
    time, worn, present : ndarray, shape (n,)
        Sample times, s, the cumulative wear and the particles present.
    window : float
        Length of record that suffices after the transient, s.

    Returns
    -------
    SteadyStart
        ``settled`` is False if either still drifts; ``time`` is then at least the half of the
        record.
    """
    summed = integral(time, present)
    half = 0.5 * (time[0] + time[-1])
    early = _part(time, worn, summed, None)
    if early.settled:
        return early
    latest = time[-1] - window
    if latest > half:
        late = _part(time, worn, summed, latest)
        if late.settled:
            return late
    return SteadyStart(max(half, early.time), False)


def _part(time, worn, summed, latest) -> SteadyStart:
    """The steady part by truncations up to ``latest``, see `steady_start`."""
    start, settled = steady_start(time, worn, latest)
    if settled and _changes(time, summed, start):
        bed = steady_start(time, summed, latest)
        start = max(start, bed.time)
        settled = bed.settled and not _changes(time, summed, start)
    return SteadyStart(start, settled and not _changes(time, worn, start))


def steady_start(
    time: np.ndarray, cumulative: np.ndarray, latest: float | None = None
) -> SteadyStart:
    """Return the end of the transient by the marginal standard error rule (MSER).

    The truncation that minimises the standard error of the mean of what remains (White 1997,
    Simulation 69:323); never before the first wear.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series.
    latest : float, optional
        Where the search ends, s, at the half of the record at least, which is the default.

    Returns
    -------
    SteadyStart
        ``time`` in s; ``settled`` is False if nothing is worn yet or the minimum lies at the
        end of the search, that is, the record still drifts. ``time`` is then that end, or the
        half of the record if it is that short.
    """
    time = np.asarray(time, dtype=float)
    cumulative = np.asarray(cumulative, dtype=float)
    half = time[0] + 0.5 * (time[-1] - time[0])
    worn = np.flatnonzero(cumulative > cumulative[0])
    if worn.size == 0:
        return SteadyStart(half, False)
    first = time[max(worn[0] - 1, 0)]
    bins = int((time[-1] - time[0]) / BIN + 1e-9)
    if bins < 4:
        return SteadyStart(half, False)
    edges = time[-1] - BIN * np.arange(bins, -1, -1)
    increments = np.diff(np.interp(edges, time, cumulative))
    last = bins // 2
    if latest is not None:
        last = max(last, int(min((latest - edges[0]) / BIN + 1e-9, bins - LEAST_BINS)))
    best = _truncation(increments, last)
    return SteadyStart(float(max(edges[best], first)), best < last)


def _truncation(increments: np.ndarray, last: int) -> int:
    """How many of the first increments, at most ``last``, to drop by the MSER."""
    # From the last one, so that rounding does not choose within a constant end.
    increments = increments - increments[-1]
    dropped = np.arange(last + 1)
    left = increments.size - dropped
    tail_sum = np.cumsum(increments[::-1])[::-1][dropped]
    tail_square = np.cumsum(increments[::-1] ** 2)[::-1][dropped]
    variance = tail_square / left - (tail_sum / left) ** 2
    variance[variance < ROUNDING * (increments @ increments) / increments.size] = 0.0
    return int(np.argmin(variance / left))


def integral(time: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Cumulative integral of a level by the trapezoidal rule, 0 at first, shape of ``time``."""
    level = np.asarray(level, dtype=float)
    pieces = 0.5 * (level[1:] + level[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(pieces)])


def change(time: np.ndarray, cumulative: np.ndarray, start: float, batches: int = 20) -> Change:
    """Return by how much a rate changes from ``start`` to the end, by a line through batch means.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series, or the `integral` of a level.
    start : float
        Where the part begins, s.
    batches : int
        Number of equal batches, at least 4.

    Returns
    -------
    Change
        Slope times length of the part, over the mean, by least squares. Its standard error comes
        from the residuals of a parabola, so that a change which grows is no scatter, and is
        enlarged for a positive lag-1 correlation of these as in `batch_means`. Both nan with
        fewer samples than batches, or if the mean is 0.
    """
    means = _batches(np.asarray(time, dtype=float), cumulative, start, batches)
    if means is None or means.mean() == 0.0:
        return Change(np.nan, np.nan)
    mean = float(means.mean())
    # A constant, a line and a parabola, orthogonal to each other.
    place = (np.arange(batches) - 0.5 * (batches - 1)) / batches
    bend = place**2 - (place**2).mean()
    whole = float(place @ means) / float(place @ place)
    residual = means - mean - whole * place - float(bend @ means) / float(bend @ bend) * bend
    scatter = float(residual @ residual) / (batches - 3)
    stderr = math.sqrt(scatter / float(place @ place)) * _enlarged(_lag1(residual), batches)
    return Change(whole / mean, stderr / mean)


def _changes(time: np.ndarray, cumulative: np.ndarray, start: float) -> bool:
    """Whether a rate grows or falls from ``start`` on; so too if the part is too short to tell."""
    if cumulative[-1] == np.interp(start, time, cumulative):
        # Nothing throughout.
        return False
    found = change(time, cumulative, start)
    return not abs(found.change) <= max(LARGEST_CHANGE, SIGNIFICANT * found.stderr)


def _batches(time: np.ndarray, cumulative: np.ndarray, start: float, number: int):
    """Mean rate in each of equal batches from ``start`` on; None if samples are too few."""
    span = time[-1] - start
    if not span > 0 or np.count_nonzero(time > start) < number:
        return None
    edges = np.linspace(start, time[-1], number + 1)
    return np.diff(np.interp(edges, time, cumulative)) / (span / number)


def _lag1(deviation: np.ndarray) -> float:
    """Lag-1 correlation of deviations from a mean or a line."""
    spread = float(deviation @ deviation)
    return float(deviation[1:] @ deviation[:-1] / spread) if spread > 0 else 0.0


def _enlarged(lag1: float, batches: int) -> float:
    """Factor of a standard error, above 1 where the lag-1 correlation of batches is believed."""
    if lag1 > LAG1_QUANTILE / np.sqrt(batches):
        return float(np.sqrt((1.0 + lag1) / (1.0 - lag1)))
    return 1.0


def batch_means(
    time: np.ndarray, cumulative: np.ndarray, start: float, minimum: int = 20
) -> BatchMeans:
    """Return the rate of a cumulative series from ``start`` on, by equal batches of increments.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series; the values at batch edges are interpolated.
    start : float
        Where the steady state begins, s.
    minimum : int
        Number of batches.

    Returns
    -------
    BatchMeans
        ``stderr`` is s / sqrt(batches), enlarged by sqrt((1 + r) / (1 - r)) where the lag-1
        correlation r of the batches is significantly positive. All nan with fewer samples
        than batches.
    """
    if minimum < 2:
        return BatchMeans(np.nan, np.nan, np.nan, 0)
    means = _batches(np.asarray(time, dtype=float), cumulative, start, minimum)
    if means is None:
        return BatchMeans(np.nan, np.nan, np.nan, 0)
    lag1 = _lag1(means - means.mean())
    stderr = float(means.std(ddof=1) / np.sqrt(minimum)) * _enlarged(lag1, minimum)
    return BatchMeans(float(means.mean()), stderr, lag1, minimum)
