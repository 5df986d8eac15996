"""Start of the steady state, and the standard error of its rate.

The cumulative worn volume is a random walk around a straight line, so the usual standard error
of a fitted slope is far too small. Rates and their errors are therefore computed from batch
means of *increments*.

A bed that fills up shields the plate more and more. The number of particles present shows this
earlier and with less noise than the wear, so both must be steady.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

BIN = 0.1
"""Width of the increments that the transient rule uses, s."""

LAG1_QUANTILE = 1.645
"""One-sided 95 % bound of a normal variable: larger lag-1 correlations are significant."""

COSINES = 12
"""Most cosines of the error of a mean, and its degrees of freedom. The slowest has a period of two
records, the fastest of a sixth of one; faster ones see the scatter at the edges of the pieces."""

LEAST_BINS = 20
"""Bins that must remain after a late truncation; the scatter of fewer is not informative."""

ROUNDING = 1e-18
"""Variance, as a share of the mean square, below which it is taken as zero."""

ROUNDING_OF_TIMES = 1e-12
"""Share of a span by which rounding may make it seem shorter than its release intervals."""

LARGEST_CHANGE = 0.2
"""Largest change of the wear rate or of the particles present over a steady part, as a share of
the mean. The wear of a bed falls by up to 1.2 % if the number of its particles grows by 1 %, so
the mean over the part can differ by a tenth from the value at its end. A bed that fills more
slowly is not detected; docs/method.md gives the resulting errors."""

SIGNIFICANT = 3.0
"""Number of standard errors above which such a change is significant. Without this condition the
random fluctuations of a few large particles would count as a drift."""


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

    @property
    def freedom(self) -> float:
        """Degrees of freedom of ``stderr``, for Student's t: the number of cosines."""
        return float(cosines(self.batches))


class Change(NamedTuple):
    """Change of a rate over a part of its record, as a share of the mean over that part."""

    change: float
    stderr: float


def steady_part(
    time: np.ndarray, worn: np.ndarray, present: np.ndarray, window: float
) -> SteadyStart:
    """Return the time from which both the wear and the particles present are steady.

    `steady_start` gives the end of the transient of the wear. If the number of particles present
    still changes after it, the steady part begins at the end of their own transient. In the
    steady part neither may change by more than `LARGEST_CHANGE`, unless the change is not
    significant. If no truncation in the first half of the record gives a steady part, later
    ones that leave at least ``window`` are tried.

    Parameters
    ----------
    time, worn, present : ndarray, shape (n,)
        Sample times, s, the cumulative wear and the number of particles present.
    window : float
        Shortest length of record needed after the transient, s.

    Returns
    -------
    SteadyStart
        ``settled`` is False if either still drifts; ``time`` is then in the second half of the
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
    """The steady part for truncations up to ``latest``, see `steady_start`."""
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

    The truncation minimises the standard error of the mean of the remaining increments (White
    1997, Simulation 69:323). It is never before the first wear.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series.
    latest : float, optional
        End of the search, s. The default, and the smallest value, is half of the record.

    Returns
    -------
    SteadyStart
        ``time`` in s. ``settled`` is False if there is no wear yet, or if the minimum is at the
        end of the search, that is, if the record still drifts. ``time`` is then that end, or
        half of the record if the record is too short.
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
    """Number of first increments, at most ``last``, to drop by the MSER."""
    # Relative to the last one, so that rounding does not decide within a constant end.
    increments = increments - increments[-1]
    dropped = np.arange(last + 1)
    left = increments.size - dropped
    tail_sum = np.cumsum(increments[::-1])[::-1][dropped]
    tail_square = np.cumsum(increments[::-1] ** 2)[::-1][dropped]
    variance = tail_square / left - (tail_sum / left) ** 2
    variance[variance < ROUNDING * (increments @ increments) / increments.size] = 0.0
    return int(np.argmin(variance / left))


def integral(time: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Cumulative integral of a level by the trapezoidal rule, from 0 on, shape of ``time``."""
    level = np.asarray(level, dtype=float)
    pieces = 0.5 * (level[1:] + level[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(pieces)])


def change(time: np.ndarray, cumulative: np.ndarray, start: float, batches: int = 20) -> Change:
    """Return the change of a rate from ``start`` to the end, from a line through batch means.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series, or the `integral` of a level.
    start : float
        Start of the part, s.
    batches : int
        Number of equal batches, at least 4.

    Returns
    -------
    Change
        Least-squares slope times the length of the part, divided by the mean. The standard error
        is computed from the residuals of a parabola, so that a change which accelerates does not
        count as scatter. It is enlarged if the residuals have a positive lag-1 correlation, as in
        `batch_means`. Both are nan if there are fewer samples than batches or the mean is 0.
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
    factor = correlation_factor(lag1_correlation(residual), batches)
    stderr = math.sqrt(scatter / float(place @ place)) * factor
    return Change(whole / mean, stderr / mean)


def _changes(time: np.ndarray, cumulative: np.ndarray, start: float) -> bool:
    """Whether a rate changes significantly from ``start`` on; True if the part is too short."""
    if cumulative[-1] == np.interp(start, time, cumulative):
        # The rate is zero throughout.
        return False
    found = change(time, cumulative, start)
    return not abs(found.change) <= max(LARGEST_CHANGE, SIGNIFICANT * found.stderr)


def _batches(time: np.ndarray, cumulative: np.ndarray, start: float, number: int):
    """Mean rate in each of the equal batches from ``start`` on; None for too few samples."""
    span = time[-1] - start
    if not span > 0 or np.count_nonzero(time > start) < number:
        return None
    edges = np.linspace(start, time[-1], number + 1)
    return np.diff(np.interp(edges, time, cumulative)) / (span / number)


def lag1_correlation(deviation: np.ndarray) -> float:
    """Lag-1 correlation of deviations from a mean or a line."""
    spread = float(deviation @ deviation)
    return float(deviation[1:] @ deviation[:-1] / spread) if spread > 0 else 0.0


def correlation_factor(lag1: float, batches: int) -> float:
    """Factor of the standard error of a mean of batches whose lag-1 correlation is ``lag1``.

    It is sqrt((1 + r) / (1 - r)) for a significantly positive correlation r, otherwise 1.
    """
    if lag1 > LAG1_QUANTILE / np.sqrt(batches):
        return float(np.sqrt((1.0 + lag1) / (1.0 - lag1)))
    return 1.0


def cosines(pieces: int) -> int:
    """Number of cosines for the error of a mean of so many pieces: a third, at most `COSINES`."""
    return min(COSINES, pieces // 3)


def slow_variance(values: np.ndarray, number: int) -> float:
    """Squared standard error of a mean, from the slowest fluctuations of the values.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Values of equal pieces of a steady record.
    number : int
        Number of cosines B.

    Returns
    -------
    float
        Mean square of the projections on the first B cosines, over n. With them as unit vectors,
        sqrt(2/n) cos(pi j (k + 1/2)/n) for j = 1 to B, the estimate is that of the spectrum at the
        frequency 0 by equal weights (Mueller 2007, J. Econometrics 141:1331; Lazarus, Lewis, Stock
        and Watson 2018, J. Bus. Econ. Stat. 36:541). For a spectrum that is flat up to B/(2 n)
        cycles a piece, the mean over its error follows Student's t of B degrees of freedom.
    """
    pieces = len(values)
    order = np.arange(1, number + 1)[:, None]
    waves = np.cos(np.pi * order * (np.arange(pieces) + 0.5) / pieces)
    projections = math.sqrt(2.0 / pieces) * (waves @ (values - values.mean()))
    return float(projections @ projections) / number / pieces


def batch_means(
    time: np.ndarray,
    cumulative: np.ndarray,
    start: float,
    minimum: int = 20,
    release_interval: float = 0.0,
) -> BatchMeans:
    """Return the rate of a cumulative series from ``start`` on, by the method of batch means.

    The increments are divided into equal batches (Law 2015, Simulation Modeling and Analysis,
    chapter 9). The factory releases particles evenly in time. Where a batch holds few of them, one
    more or one less would count as scatter of the rate, so batches are whole release intervals
    and their edges are where the plate wears least, between the impacts of two particles.

    Falls last differently long, so what one batch wears less at an edge its neighbour wears more.
    The error of the mean is therefore less than that of independent batches. It is estimated from
    the slow fluctuations of the record, which edges hardly change.

    Parameters
    ----------
    time, cumulative : ndarray, shape (n,)
        Sample times, s, and the cumulative series; values at the batch edges are interpolated.
    start : float
        Start of the steady state, s. Less than one batch and one release interval after it are
        left out.
    minimum : int
        Least number of batches. There are at least twice as many, so that pairs of neighbours are
        enough, where samples and release intervals suffice.
    release_interval : float
        Time between two releases, s; 0 if they are not even. Parts with fewer intervals than
        ``minimum`` are divided as if it were 0.

    Returns
    -------
    BatchMeans
        ``stderr`` is that of `slow_variance`, from the release intervals (samples, if these are
        longer) and `cosines` of the number of batches. If the lag-1 correlation r of the n batches
        is significantly positive, it is that of independent batches, with their variance s^2,
        enlarged as for a correlation that decays exponentially:
        s sqrt((1 + r) / (1 - r) / (n - 2)). All are nan, and ``batches`` is 0, if there are fewer
        samples than ``minimum``.
    """
    time = np.asarray(time, dtype=float)
    samples = int(np.count_nonzero(time > start))
    if minimum < 3 or not samples >= minimum:
        return BatchMeans(np.nan, np.nan, np.nan, 0)
    wanted = min(2 * minimum, samples)
    edges: np.ndarray = np.linspace(start, time[-1], wanted + 1)
    pieces = wanted * max(1, samples // wanted)
    if release_interval > 0.0:
        end = _quiet_end(time, cumulative, start, release_interval)
        intervals = int((end - start) / release_interval * (1.0 + ROUNDING_OF_TIMES))
        if intervals >= minimum:
            each = max(1, intervals // wanted)
            places = np.arange(intervals // each, -1, -1)
            edges = end - each * release_interval * places
            pieces = places[0] * each
            pieces //= max(1, round(pieces / samples))
    number = edges.size - 1
    length = (edges[-1] - edges[0]) / number
    means = np.diff(np.interp(edges, time, cumulative)) / length
    lag1 = lag1_correlation(means - means.mean())
    factor = correlation_factor(lag1, number)
    if factor > 1.0:
        stderr = factor * math.sqrt(float(means.var(ddof=1)) / (number - 2))
    else:
        fine = np.interp(np.linspace(edges[0], edges[-1], pieces + 1), time, cumulative)
        rates = np.diff(fine) * (pieces / (edges[-1] - edges[0]))
        stderr = math.sqrt(slow_variance(rates, cosines(number)))
    return BatchMeans(float(means.mean()), stderr, lag1, number)


def _quiet_end(time, cumulative, start: float, release_interval: float) -> float:
    """Latest sample at whose place in the release interval the plate wears least; the last sample
    if an interval has fewer than four samples, as batches then hold many particles."""
    samples = int(release_interval * (time.size - 1) / (time[-1] - time[0]))
    if samples < 4:
        return float(time[-1])
    ends = time[-1 : -1 - samples : -1]
    # Places of all candidates, except those so late that their second half is not recorded.
    count = int((ends[-1] - start) / release_interval) + 1
    places = ends[:, None] - release_interval * np.arange(1, max(count, 2))
    half = 0.25 * release_interval
    worn = np.interp(places + half, time, cumulative) - np.interp(places - half, time, cumulative)
    return float(ends[np.argmin(worn.sum(axis=1))])
