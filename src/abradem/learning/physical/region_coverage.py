"""Coverage of prediction intervals by region, and what chance leaves of it.

Each share of rows inside their intervals has a *binomial band*, in which it is in 95 of 100 tests
if the intervals hold. A study tests two dozen shares, three levels in eight regions, so one of them
is outside its band by chance in most studies, however good the intervals. Two numbers say what may
be asked of all shares together:

- how many are in their binomial bands on average, and
- the *joint bands*, wider ones in which all shares of a test are at once in 95 of 100 tests
  (minimum p value: Westfall and Young 1993, Resampling-Based Multiple Testing, ch. 2).

Both follow from *faultless* intervals: those of a model whose scores (errors over deviations)
depend on nothing. The ranks of such scores are those of uniform random numbers, whatever their
distribution, so the test is drawn again and again with the same rows in the same regions. The draws
know that regions share rows, that levels are nested, and that the quantile of an interval rests on
few held-out scores itself (Vovk 2012, JMLR W&CP 25:475), which a binomial band does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from abradem.learning.regions import Region
from abradem.surrogate.model import conformal_quantile

BAND = 0.95
"""Share of the tests in which faultless intervals are in a band."""

DRAWS = 2000
"""Tests of faultless intervals that are drawn; the p value of the joint bands is then known to
7 %, from 100 draws below it."""

COVERAGE_COLUMNS = [
    "region", "words", "level", "coverage", "band_lower", "band_upper", "tested", "in_band",
]  # fmt: skip

Draw = Callable[[np.random.Generator, Sequence[float]], np.ndarray]


class Joint(NamedTuple):
    """What faultless intervals do in the regions of a test.

    Attributes
    ----------
    p_value : float
        In `BAND` of the draws no share has a two-sided binomial p value below it.
    expected : float
        Mean number of shares in their binomial bands.
    """

    p_value: float
    expected: float


def band(tested: int, level: float) -> tuple[float, float]:
    """Binomial band of level `BAND` of the share of ``tested`` rows inside intervals that hold."""
    low, high = stats.binom.interval(BAND, tested, level)
    return low / tested, high / tested


def coverage_by_region(
    inside: dict[float, np.ndarray], inputs: np.ndarray, regions: Sequence[Region]
) -> pd.DataFrame:
    """Share of rows inside their intervals, by region and level.

    Parameters
    ----------
    inside : dict of float to ndarray of bool, shape (n,)
        Whether each row is inside its interval, by the level of the interval.
    inputs : ndarray, shape (n, 14)
        The sampled quantities of the rows.
    regions : list of Region

    Returns
    -------
    pandas.DataFrame
        region, words, level, coverage, band_lower, band_upper (binomial band), tested (number of
        rows), in_band. Regions without a row are left out.
    """
    rows = []
    for region in regions:
        held = region.holds(inputs)
        count = int(held.sum())
        if not count:
            continue
        for level, found in inside.items():
            share = float(found[held].mean())
            low, high = band(count, level)
            rows.append(
                (region.name, region.words, level, share, low, high, count, low <= share <= high)
            )
    return pd.DataFrame(rows, columns=COVERAGE_COLUMNS)


def faultless_on_new(known: int, tested: int) -> Draw:
    """Draws of whether new rows (tested,) are inside intervals that rest on ``known`` scores."""

    def draw(rng: np.random.Generator, levels: Sequence[float]) -> np.ndarray:
        ordered, new = np.sort(rng.random(known)), rng.random(tested)
        return np.array([new <= conformal_quantile(ordered, level) for level in levels])

    return draw


def faultless_in_folds(fold: np.ndarray, agreement: float) -> Draw:
    """Draws of whether rows are inside intervals from the scores of the other folds' rows.

    A row has two scores, one in its own fold and one among the rows that others' intervals rest on.
    The nearer they agree, the less the share over all rows can differ from the level.

    Parameters
    ----------
    fold : ndarray of int, shape (n,)
        Fold in which each row was held out.
    agreement : float
        Rank correlation of the two scores, from -1 to 1.
    """
    # Correlation of normal variables with this rank correlation (Pearson 1907).
    shared = 2.0 * np.sin(np.pi * agreement / 6.0)

    def draw(rng: np.random.Generator, levels: Sequence[float]) -> np.ndarray:
        score, other = rng.standard_normal((2, len(fold)))
        known = shared * score + np.sqrt(1.0 - shared**2) * other
        inside = np.empty((len(levels), len(fold)), dtype=bool)
        for one in np.unique(fold):
            held = fold == one
            ordered = np.sort(known[~held])
            for place, level in enumerate(levels):
                inside[place, held] = score[held] <= conformal_quantile(ordered, level)
        return inside

    return draw


def faultless(
    draw: Draw,
    levels: Sequence[float],
    inputs: np.ndarray,
    regions: Sequence[Region],
    seed: int = 0,
) -> Joint:
    """What faultless intervals do in some regions.

    Parameters
    ----------
    draw : callable
        From `faultless_on_new` or `faultless_in_folds`.
    levels : sequence of float
        Levels of the intervals.
    inputs : ndarray, shape (n, 14)
        The sampled quantities of the tested rows.
    regions : sequence of Region
    seed : int
    """
    members = np.array([region.holds(inputs) for region in regions]).reshape(-1, len(inputs))
    members = members[members.any(axis=1)].astype(float)
    if not len(members) or not levels:
        return Joint(0.0, 0.0)
    rng = np.random.default_rng(seed)
    # (draws, regions, levels): rows inside.
    counts = np.rint([members @ draw(rng, levels).T for _ in range(DRAWS)]).astype(int)
    least, in_band = np.ones(DRAWS), np.zeros(DRAWS)
    for place, tested in enumerate(members.sum(axis=1).astype(int)):
        for column, level in enumerate(levels):
            found = counts[:, place, column]
            least = np.minimum(least, p_values(tested, level)[found])
            low, high = stats.binom.interval(BAND, tested, level)
            in_band += (found >= low) & (found <= high)
    return Joint(float(np.sort(least)[int((1.0 - BAND) * DRAWS)]), float(in_band.mean()))


def p_values(tested: int, level: float) -> np.ndarray:
    """Two-sided binomial p value of each number of rows inside, shape (tested + 1,)."""
    count = np.arange(tested + 1)
    below = stats.binom.cdf(count, tested, level)
    above = stats.binom.sf(count - 1, tested, level)
    return np.minimum(2.0 * np.minimum(below, above), 1.0)


def with_joint_bands(coverage: pd.DataFrame, joint: Joint) -> pd.DataFrame:
    """Table of `coverage_by_region` with joint_lower, joint_upper and in_joint, the joint bands."""
    ends = []
    for row in coverage.itertuples(index=False):
        (kept,) = np.nonzero(p_values(row.tested, row.level) >= joint.p_value)
        ends.append((kept[0] / row.tested, kept[-1] / row.tested))
    low, high = np.array(ends).reshape(-1, 2).T
    inside = coverage["coverage"].between(low - 1e-9, high + 1e-9)
    return coverage.assign(joint_lower=low, joint_upper=high, in_joint=inside)


def joint_summary(coverage: pd.DataFrame, joint: Joint) -> dict:
    """Verdict on a table of `with_joint_bands`.

    Returns
    -------
    dict
        ``shares``, their number; ``in_band``, how many are in their binomial bands; ``expected``,
        how many of faultless intervals are on average; ``in_joint``, how many are in their joint
        bands, in which all of faultless intervals are in `BAND` of the tests.
    """
    return {
        "shares": len(coverage),
        "in_band": int(coverage["in_band"].sum()),
        "expected": joint.expected,
        "in_joint": int(coverage["in_joint"].sum()),
    }
