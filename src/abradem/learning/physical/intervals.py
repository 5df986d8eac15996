"""Intervals of a prediction, and whether they hold what they promise.

The Gaussian process predicts t with a standard deviation. Its own interval is t +- z(c) times
that; the *conformal* one replaces the normal quantile by a quantile of what was observed: the
scores |t_i - mean_i| / deviation_i of rows that were held out in turn, the process fitted again
without them (cross-conformal: Vovk 2015, Ann. Math. Artif. Intell. 74:9; leaving rows out of a
process whose parameters saw them would flatter it). Whatever the errors' distribution, it holds
about a share c of new rows; and where the process is unsure, it is wider.

What the interval holds is a new simulation, with the scatter that a simulation has.

Calibration is tested by nested cross-validation: every row is held out once, the intervals come
from the others alone, their scores included, and the share of rows inside is compared with c. If
the rows were independent it would lie within the binomial band in 95 of 100 such tests.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import WearProblem
from abradem.learning.protocols import folds
from abradem.surrogate.model import conformal_quantile

CONFORMAL, OWN = METHODS = ("conformal", "gaussian process")
LEVELS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
REPORTED = (0.5, 0.8, 0.95)
BAND = 0.95
INNER_FOLDS = 5
"""Folds of the training rows that scores are taken from when the intervals are tested."""
TOLERANCE = 0.03
"""Distance from the nominal level that a study of enough rows is held to."""


def held_out_scores(
    given: WearProblem, rows: np.ndarray, fold_count: int = INNER_FOLDS, seed: int = 0
) -> np.ndarray:
    """Scores of rows that a process fitted to the others of ``rows`` did not see, sorted."""
    make = makers(seed)[PROCESS]
    scores = np.empty(len(rows))
    for train, test in folds(len(rows), fold_count, seed):
        process = fitted(make, given, rows[train])
        scores[test] = _scores(process, given, rows[test])[0]
    return np.sort(scores)


def _scores(process, given: WearProblem, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """|t - mean| / deviation of rows, and the deviation."""
    mean, deviation = process.predict_with_deviation(given.groups[rows])
    return np.abs(given.log_number[rows] - mean) / deviation, deviation


def calibrate(given: WearProblem, fold_count: int = 5, seed: int = 0) -> tuple[pd.DataFrame, dict]:
    """Coverage of intervals on rows that were held out.

    Parameters
    ----------
    given : WearProblem
    fold_count : int
        Every row is held out in one of so many folds.
    seed : int

    Returns
    -------
    calibration : pandas.DataFrame
        method, level, coverage, band_lower, band_upper (binomial), tested, width: median of the
        upper end over the prediction less 1.
    summary : dict
        ``scores``: held-out scores |t - mean| / deviation of all rows, sorted, which conformal
        intervals of later predictions use; ``coverage`` at the levels `REPORTED`; ``in_band``,
        ``within_tolerance``.
    """
    make = makers(seed)[PROCESS]
    n = len(given.log_number)
    score, deviation = np.empty(n), np.empty(n)
    quantile = np.empty((n, len(LEVELS)))
    for train, test in folds(n, fold_count, seed):
        score[test], deviation[test] = _scores(fitted(make, given, train), given, test)
        observed = held_out_scores(given, train, seed=seed)
        quantile[test] = [conformal_quantile(observed, level) for level in LEVELS]
    half = {
        CONFORMAL: quantile,
        OWN: np.tile(stats.norm.ppf(0.5 + 0.5 * np.array(LEVELS)), (n, 1)),
    }
    rows = []
    for method in METHODS:
        for place, level in enumerate(LEVELS):
            inside = score <= half[method][:, place]
            low, high = stats.binom.interval(BAND, n, level)
            width = float(np.median(np.expm1(half[method][:, place] * deviation)))
            rows.append((method, level, float(inside.mean()), low / n, high / n, n, width))
    columns = ["method", "level", "coverage", "band_lower", "band_upper", "tested", "width"]
    calibration = pd.DataFrame(rows, columns=columns)
    reported = calibration[
        (calibration["method"] == CONFORMAL) & calibration["level"].isin(REPORTED)
    ]
    return calibration, {
        "method": CONFORMAL,
        "rows": n,
        "folds": fold_count,
        "scores": np.sort(score),
        "coverage": [
            {
                "level": row.level,
                "coverage": row.coverage,
                "band": [row.band_lower, row.band_upper],
                "relative_width": row.width,
            }
            for row in reported.itertuples(index=False)
        ],
        "in_band": bool(
            reported["coverage"].between(reported["band_lower"], reported["band_upper"]).all()
        ),
        "within_tolerance": bool(
            ((reported["coverage"] - reported["level"]).abs() <= TOLERANCE).all()
        ),
        "tolerance": TOLERANCE,
    }
