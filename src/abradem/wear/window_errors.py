"""Standard errors of the statistics over elements, from the parts of the window.

The window is divided into g equal parts. If the parts are independent, the variance of a statistic
at half of the window is known without bias: the statistics T of two sets of parts without a common
one are independent, so::

    V(m) = mean over disjoint sets S, S' of m parts of (T(S) - T(S'))^2 / 2

estimates the variance of T at m parts. It is the variance at g parts that is wanted. For a mean it
is V(g/2)/2, which is then the variance over the parts divided by g. Other statistics change with
the duration, such as the number of worn elements, or are extremes. Therefore the last doubling
tells the next one, by the exponent of V between about g/4 and g/2 parts::

    V(g) = V(g/2) 2^b,   b = ln(V(g/2)/V(g/4)) / ln 2, within [-2, 0]

The jackknife, which leaves out one part, estimates more than the variance of any statistic that is
not a mean (Efron and Stein 1981, Ann. Stat. 9:586), and fails for extremes (Shao and Wu 1989, Ann.
Stat. 17:1176, who leave out more). docs/method.md has the measured accuracy of both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from itertools import combinations

import numpy as np

from abradem.dem.steady import correlation_factor, lag1_correlation
from abradem.quantities import STATISTICS

FEWEST_PARTS = 4
"""Parts from which two halves and their halves can be made."""

EXPONENTS = (-2.0, 0.0)
"""Bounds of the exponent b: the variance of a mean over the time has -1; -2 is that of a fixed
amount of work over the time, 0 that of a rate whose scatter time does not reduce."""

VALUES_AT_ONCE = 2**21
"""Largest number of values for which memory is taken."""


def element_stderr(
    parts: np.ndarray,
    element_area: float | np.ndarray,
    window: float,
    footprint_share: float = 0.95,
) -> dict[str, float]:
    """Return the standard errors of `abradem.wear.rates.element_rates`, J/(m2 s).

    Parameters
    ----------
    parts : ndarray, shape (g, nx, nz)
        Work J of each element in each of the g equal parts of the window, J, in order of time. If g
        is odd, the last part is left out of the comparison.
    element_area : float or ndarray, shape (nx, nz)
        m2.
    window : float
        Length of the window, s.
    footprint_share : float
        Share of the wear in the footprint.

    Returns
    -------
    dict of str to float
        ``worn``, ``footprint``, ``p99`` and ``max``. An error is enlarged, as in
        `abradem.dem.steady.batch_means`, if the effects of the parts on the statistic have a
        significantly positive lag-1 correlation. All are nan for fewer than `FEWEST_PARTS` parts.
    """
    count = len(parts)
    if count < FEWEST_PARTS:
        return dict.fromkeys(STATISTICS[1:], math.nan)
    half = count // 2
    quarter = (half + 1) // 2
    work = parts[: 2 * half].reshape(2 * half, -1)
    statistics = partial(subset_statistics, footprint_share=footprint_share)
    if isinstance(element_area, np.ndarray):
        statistics = partial(
            weighted_statistics, areas=element_area.ravel(), footprint_share=footprint_share
        )
        element_area = 1.0
    halves = _of_subsets(work, half, statistics)
    quarters = _of_subsets(work, quarter, statistics)
    found = {}
    for place, name in enumerate(STATISTICS[1:]):
        of_half, of_quarter = halves[:, place], quarters[:, place]
        variance = _extrapolated(
            _variance(of_quarter, 2 * half, quarter),
            _variance(of_half, 2 * half, half),
            half / quarter,
            count / half,
        )
        lag1 = lag1_correlation(_effects(of_half, 2 * half, half))
        stderr = math.sqrt(variance) * correlation_factor(lag1, 2 * half)
        found[name] = stderr / (element_area * window / count)
    return found


def subset_statistics(wear: np.ndarray, footprint_share: float = 0.95) -> np.ndarray:
    """Return the statistics of many maps, shape (k, 4), J per element.

    Parameters
    ----------
    wear : ndarray, shape (k, n)
        Work J of each element, J.
    footprint_share : float
        Share of the wear in the footprint.

    Returns
    -------
    ndarray, shape (k, 4)
        ``worn``, ``footprint``, ``p99``, ``max``, see `abradem.wear.rates.element_rates`, which is
        the same for one map.
    """
    count = wear.shape[1]
    falling = -np.sort(-wear, axis=1)
    held = np.cumsum(falling, axis=1)
    worn = wear > 0.0
    tiny = 1e-12
    enough = np.argmax(held >= footprint_share * (1.0 - tiny) * held[:, -1:], axis=1)
    within = held[np.arange(len(wear)), enough] / (enough + 1)
    above = 0.01 * (count - 1)
    place = int(above)
    next_place = min(place + 1, count - 1)
    p99 = falling[:, place] + (above - place) * (falling[:, next_place] - falling[:, place])
    return np.column_stack(
        [
            np.where(worn, wear, 0.0).sum(axis=1) / np.maximum(worn.sum(axis=1), 1),
            np.where(held[:, -1] > 0.0, within, 0.0),
            p99,
            falling[:, 0],
        ]
    )


def weighted_statistics(
    wear: np.ndarray, areas: np.ndarray, footprint_share: float = 0.95
) -> np.ndarray:
    """Return the statistics of many maps of cells of different areas, shape (k, 4), J/m2.

    Parameters
    ----------
    wear : ndarray, shape (k, n)
        Work J of each cell, J.
    areas : ndarray, shape (n,)
        m2.
    footprint_share : float
        Share of the wear in the footprint, which consists of the most deeply worn cells.

    Returns
    -------
    ndarray, shape (k, 4)
        ``worn``, ``footprint``, ``p99``, ``max``: work per area of the worn cells and of the
        footprint; the depth that is not exceeded on 99 % of the area; the deepest cell.
    """
    order = np.argsort(-wear / areas, axis=1, kind="stable")
    falling, sizes = np.take_along_axis(wear, order, axis=1), areas[order]
    held, covered = np.cumsum(falling, axis=1), np.cumsum(sizes, axis=1)
    rows = np.arange(len(wear))
    tiny = 1e-12
    enough = np.argmax(held >= footprint_share * (1.0 - tiny) * held[:, -1:], axis=1)
    # The first cell, from the deepest on, with which over 1 % of the area is deeper or as deep.
    place = np.argmax(covered > 0.01 * covered[:, -1:] * (1.0 + tiny), axis=1)
    density = falling / sizes
    worn_area = np.where(falling > 0.0, sizes, 0.0).sum(axis=1)
    total = held[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.column_stack(
            [
                np.where(worn_area > 0.0, total / worn_area, 0.0),
                np.where(total > 0.0, held[rows, enough] / covered[rows, enough], 0.0),
                density[rows, place],
                density[:, 0],
            ]
        )


@lru_cache(maxsize=8)
def _subsets(parts: int, size: int) -> np.ndarray:
    """Subsets of the parts, shape (k, size), in lexicographic order."""
    return np.array(list(combinations(range(parts), size)))


@lru_cache(maxsize=8)
def _disjoint(parts: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the subsets of each pair without a common part."""
    inside = np.zeros((math.comb(parts, size), parts), dtype=np.int64)
    np.put_along_axis(inside, _subsets(parts, size), 1, axis=1)
    first, second = np.nonzero(np.triu(inside @ inside.T == 0))
    return first, second


def _of_subsets(
    work: np.ndarray, size: int, statistics: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Statistics per part, shape (k, 4), of the subsets of the parts, whose work is (g, n)."""
    return np.concatenate(
        [statistics(sums) / size for sums in _sums(work, _subsets(len(work), size))]
    )


def _sums(work: np.ndarray, subsets: np.ndarray) -> Iterator[np.ndarray]:
    """Work of the subsets, some subsets at once; part after part, so that the bits are fixed."""
    at_once = max(1, VALUES_AT_ONCE // work.shape[1])
    for first in range(0, len(subsets), at_once):
        chosen = subsets[first : first + at_once]
        sums = work[chosen[:, 0]]
        for column in range(1, chosen.shape[1]):
            sums += work[chosen[:, column]]
        yield sums


def _variance(values: np.ndarray, parts: int, size: int) -> float:
    """Variance of a statistic at ``size`` parts, from its values for all subsets of that size."""
    first, second = _disjoint(parts, size)
    return 0.5 * float(np.mean((values[first] - values[second]) ** 2))


def _extrapolated(of_quarter: float, of_half: float, doubled: float, wanted: float) -> float:
    """Variance at ``wanted`` times half of the parts, by the exponent between quarter and half."""
    if of_half == 0.0:
        return 0.0
    exponent = math.log(of_half / of_quarter) / math.log(doubled) if of_quarter > 0.0 else math.inf
    low, high = EXPONENTS
    return of_half * wanted ** min(max(exponent, low), high)


def _effects(values: np.ndarray, parts: int, size: int) -> np.ndarray:
    """Mean of a statistic over the subsets that contain a part, less the mean over all."""
    effects = np.zeros(parts)
    for column in _subsets(parts, size).T:
        np.add.at(effects, column, values)
    effects /= math.comb(parts - 1, size - 1)
    return effects - effects.mean()
