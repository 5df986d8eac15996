"""Prediction intervals of the Gaussian process, and a test of their calibration.

The Gaussian process predicts the target t with a mean and a standard deviation. Its own interval
of level c is mean +- z(c) deviation with the normal quantile z(c). The *conformal* interval
replaces the normal quantile with an empirical one: a quantile of the scores
|t_i - mean_i| / deviation_i of rows that are held out in turn, with the process fitted again
without them (cross-conformal prediction: Vovk 2015, Ann. Math. Artif. Intell. 74:9). Leave-one-out
residuals of a process whose parameters were fitted to all rows would be too small. The conformal
interval covers about a share c of new rows for any distribution of the errors, and is wider where
the process is less certain.

The intervals are for the result of a new simulation, its noise included.

Calibration is tested by nested cross-validation. Every row is held out once, its interval comes
from the other rows only, and the share of rows inside the intervals is compared with c. For
independent rows this share would be inside the binomial band in 95 of 100 such tests.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import LARGEST_LOG, WearProblem
from abradem.learning.protocols import folds
from abradem.surrogate.model import conformal_quantile, highest_level

CONFORMAL, OWN = METHODS = ("conformal", "gaussian process")
LEVELS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
REPORTED = (0.5, 0.8, 0.95)
BAND = 0.95
INNER_FOLDS = 5
"""Folds within the training rows, from which the scores for the test of the intervals come."""
TOLERANCE = 0.03
"""Largest allowed difference between coverage and nominal level for a study with enough rows."""


def held_out_scores(
    given: WearProblem, rows: np.ndarray, fold_count: int = INNER_FOLDS, seed: int = 0
) -> np.ndarray:
    """Sorted cross-validation scores |t - mean| / deviation of some rows.

    Parameters
    ----------
    given : WearProblem
    rows : ndarray of int, shape (n,)
        Rows that are used; each is scored by a process fitted to the other folds.
    fold_count : int
    seed : int

    Returns
    -------
    ndarray, shape (n,)
        In ascending order, dimensionless.
    """
    make = makers(seed)[PROCESS]
    scores = np.empty(len(rows))
    for train, test in folds(given.table.groups[rows], fold_count, seed):
        process = fitted(make, given, rows[train])
        scores[test] = _scores(process, given, rows[test])[0]
    return np.sort(scores)


def _scores(process, given: WearProblem, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scores |t - mean| / deviation of some rows, and their deviations."""
    mean, deviation = process.predict_with_deviation(given.groups[rows])
    return np.abs(given.log_number[rows] - mean) / deviation, deviation


def calibrate(given: WearProblem, fold_count: int = 5, seed: int = 0) -> tuple[pd.DataFrame, dict]:
    """Coverage of the prediction intervals on held-out rows.

    Parameters
    ----------
    given : WearProblem
    fold_count : int
        Number of folds; every row is held out in one of them.
    seed : int

    Returns
    -------
    calibration : pandas.DataFrame
        method, level, coverage, band_lower, band_upper (binomial band), tested (number of rows),
        width (median of upper end / prediction - 1). Levels that the held-out scores of a fold
        cannot promise are left out.
    summary : dict
        ``scores``: sorted held-out scores |t - mean| / deviation of all rows, from which the
        conformal intervals of later predictions are computed; ``highest_level`` that they can
        promise; ``coverage`` at the levels `REPORTED`, and ``not_reached``, those of them that
        were left out; ``in_band``, ``within_tolerance``.
    """
    make = makers(seed)[PROCESS]
    n = len(given.log_number)
    splits = folds(given.table.groups, fold_count, seed)
    highest = highest_level(min(len(train) for train, _ in splits))
    levels = [level for level in LEVELS if level <= highest]
    score, deviation = np.empty(n), np.empty(n)
    quantile = np.empty((n, len(levels)))
    for train, test in splits:
        score[test], deviation[test] = _scores(fitted(make, given, train), given, test)
        observed = held_out_scores(given, train, seed=seed)
        quantile[test] = [conformal_quantile(observed, level) for level in levels]
    half = {
        CONFORMAL: quantile,
        OWN: np.tile(stats.norm.ppf(0.5 + 0.5 * np.array(levels)), (n, 1)),
    }
    rows = []
    for method in METHODS:
        for place, level in enumerate(levels):
            inside = score <= half[method][:, place]
            low, high = stats.binom.interval(BAND, n, level)
            reach = np.minimum(half[method][:, place] * deviation, LARGEST_LOG)
            width = float(np.median(np.expm1(reach)))
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
        "highest_level": highest_level(n),
        "not_reached": [level for level in REPORTED if level not in levels],
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
