"""Where the steady state begins, and how well its rate is known.

The cumulative worn volume is a random walk around a straight line, so the usual standard error
of a fitted slope is far too small. Rates are therefore judged by batch means of *increments*.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

BIN = 0.1
"""Width of the increments that the transient rule looks at, s."""

LAG1_QUANTILE = 1.645
"""One-sided 95 % bound of a normal variable: larger lag-1 correlations are believed."""


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


def steady_start(time: np.ndarray, cumulative: np.ndarray) -> SteadyStart:
    """Return the end of the transient by the marginal standard error rule (MSER).

    The truncation that minimises the standard error of the mean of what remains, searched over
    the first half of the record (White 1997, Simulation 69:323); never before the first wear.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series.

    Returns
    -------
    SteadyStart
        ``time`` in s; ``settled`` is False if nothing is worn yet or the minimum lies at the
        end of the search, that is, the record still drifts. ``time`` is then the half of it.
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
    candidates = np.arange(bins // 2 + 1)
    tail_count = bins - candidates
    tail_sum = np.cumsum(increments[::-1])[::-1][candidates]
    tail_square = np.cumsum(increments[::-1] ** 2)[::-1][candidates]
    variance = np.maximum(tail_square / tail_count - (tail_sum / tail_count) ** 2, 0.0)
    best = int(np.argmin(variance / tail_count))
    return SteadyStart(float(max(edges[best], first)), best < candidates[-1])


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
        correlation r of the batches is significantly positive. All nan if fewer than two
        batches of a sample each fit.
    """
    time = np.asarray(time, dtype=float)
    span = time[-1] - start
    if not span > 0 or np.count_nonzero(time > start) < minimum or minimum < 2:
        return BatchMeans(np.nan, np.nan, np.nan, 0)
    edges = np.linspace(start, time[-1], minimum + 1)
    means = np.diff(np.interp(edges, time, cumulative)) / (span / minimum)
    rate = float(means.mean())
    stderr = float(means.std(ddof=1) / np.sqrt(minimum))
    deviation = means - rate
    spread = float(deviation @ deviation)
    lag1 = float(deviation[1:] @ deviation[:-1] / spread) if spread > 0 else 0.0
    if lag1 > LAG1_QUANTILE / np.sqrt(minimum):
        stderr *= np.sqrt((1.0 + lag1) / (1.0 - lag1))
    return BatchMeans(rate, stderr, lag1, minimum)
