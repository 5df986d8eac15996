"""Prediction intervals of the Gaussian process, and a test of their calibration.

The Gaussian process predicts the target t with a mean and a standard deviation. Its own interval
of level c is mean +- z(c) deviation with the normal quantile z(c). The *conformal* interval
replaces the normal quantile with an empirical one: a quantile of the scores
|t_i - mean_i| / (deviation_i g_i) of rows that are held out in turn, with the process fitted again
without them (cross-conformal prediction: Vovk 2015, Ann. Math. Artif. Intell. 74:9). Leave-one-out
residuals of a process whose parameters were fitted to all rows would be too small. g is the error
scale of `abradem.learning.physical.error_scale`, a function of plate angle, speed and size that is
learned from the held-out scores of other folds. The conformal interval covers about a share c of
new rows for any distribution of the errors, and is wider where the process is less certain and
where its errors were larger than it knew.

The intervals are for the result of a new simulation, its noise included.

Calibration is tested by nested cross-validation. Every row is held out once, its interval comes
from the other rows only, and the share of rows inside the intervals is compared with c, over all
rows and by region. For independent rows this share would be inside the binomial band in 95 of 100
such tests.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from abradem.learning.physical.error_scale import ErrorScale, cross_fitted, fit_scale
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import LARGEST_LOG, WearProblem
from abradem.learning.physical.region_coverage import (
    band,
    coverage_by_region,
    faultless,
    faultless_in_folds,
    joint_summary,
    with_joint_bands,
)
from abradem.learning.protocols import folds
from abradem.learning.regions import regions_of
from abradem.surrogate.model import conformal_quantile, highest_level

CONFORMAL, OWN = METHODS = ("conformal", "gaussian process")
LEVELS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
REPORTED = (0.5, 0.8, 0.95)
INNER_FOLDS = 5
"""Folds within the training rows, from which the scores for the test of the intervals come."""
TOLERANCE = 0.03
"""Largest allowed difference between coverage and nominal level for a study with enough rows."""


class HeldOut(NamedTuple):
    """Rows that were held out in turn, in the order in which they were asked for.

    Attributes
    ----------
    fold : ndarray of int, shape (n,)
        Fold in which the row was held out.
    mean, deviation : ndarray, shape (n,)
        What the process that did not see the row predicts for it.
    score : ndarray, shape (n,)
        |t - mean| / deviation, dimensionless.
    """

    fold: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray
    score: np.ndarray


class Conformal(NamedTuple):
    """Half widths of conformal intervals.

    Attributes
    ----------
    scores : ndarray, shape (n,)
        Held-out scores divided by the error scale, in ascending order.
    scale : ErrorScale
        Fitted to all of them.
    """

    scores: np.ndarray
    scale: ErrorScale

    @classmethod
    def of(cls, summary: Mapping, scores: pd.DataFrame) -> Conformal:
        """Restore the intervals from the summary and the table of scores of `calibrate`."""
        ordered = np.sort(scores["score"].to_numpy(dtype=float))
        return cls(ordered, ErrorScale.of(summary["error_scale"]))

    def half(self, groups: np.ndarray, level: float) -> np.ndarray:
        """Half width in deviations of the process for rows with groups (n, 10), shape (n,)."""
        return conformal_quantile(self.scores, level) * self.scale.at(groups)


def hold_out_in_turn(
    given: WearProblem, rows: np.ndarray, fold_count: int = INNER_FOLDS, seed: int = 0
) -> HeldOut:
    """Cross-validate the process on some rows.

    Parameters
    ----------
    given : WearProblem
    rows : ndarray of int, shape (n,)
        Rows that are used; each is scored by a process fitted to the other folds.
    fold_count : int
    seed : int
    """
    make = makers(seed)[PROCESS]
    found = HeldOut(np.zeros(len(rows), dtype=int), *np.empty((3, len(rows))))
    for number, (train, test) in enumerate(folds(given.table.groups[rows], fold_count, seed)):
        _note(found, given, fitted(make, given, rows[train]), number, rows, test)
    return found


def _note(found: HeldOut, given: WearProblem, process, number: int, rows, test) -> None:
    """Score the rows of one fold, in place."""
    mean, deviation = process.predict_with_deviation(given.groups[rows[test]])
    found.fold[test], found.mean[test], found.deviation[test] = number, mean, deviation
    found.score[test] = np.abs(given.log_number[rows[test]] - mean) / deviation


def conformal_of(given: WearProblem, rows: np.ndarray, held: HeldOut) -> Conformal:
    """Conformal intervals from rows that were held out.

    A score is divided by the scale of the other folds, as that of a new case is by a scale that
    does not know it.
    """
    groups = given.groups[rows]
    return Conformal(np.sort(_scaled(held, groups)), fit_scale(held.score, groups))


def _scaled(held: HeldOut, groups: np.ndarray) -> np.ndarray:
    """Scores divided by the scale of the other folds, shape (n,)."""
    return held.score / cross_fitted(held.score, groups, held.fold)


class IntervalCalibration(NamedTuple):
    """Coverage of the prediction intervals on held-out rows, and what later ones rest on.

    Attributes
    ----------
    calibration : pandas.DataFrame
        method, level, coverage, band_lower, band_upper (binomial band), tested (number of rows),
        width (median of upper end / prediction - 1). Levels that the held-out scores of a fold
        cannot promise are left out.
    regions : pandas.DataFrame
        Coverage of the conformal intervals by region, see
        `abradem.learning.physical.region_coverage.with_joint_bands`.
    scores : pandas.DataFrame
        case_id, fold, log_deviation (of the process), error_scale (fitted to the other folds),
        score (|t - mean| / (deviation scale)): the held-out scores of all rows, in the order of the
        problem.
    summary : dict
        ``error_scale``, fitted to the scores of all rows, see `ErrorScale.describe`;
        ``highest_level`` that the scores can promise; ``coverage`` at the levels `REPORTED`, and
        ``not_reached``, those of them that were left out; ``in_band``, ``within_tolerance``;
        ``regions``, the verdict on the table ``regions``, see
        `abradem.learning.physical.region_coverage.joint_summary`.
    """

    calibration: pd.DataFrame
    regions: pd.DataFrame
    scores: pd.DataFrame
    summary: dict


def calibrate(given: WearProblem, fold_count: int = 5, seed: int = 0) -> IntervalCalibration:
    """Coverage of the prediction intervals on held-out rows.

    Parameters
    ----------
    given : WearProblem
    fold_count : int
        Number of folds; every row is held out in one of them.
    seed : int
    """
    make = makers(seed)[PROCESS]
    n = len(given.log_number)
    everything = np.arange(n)
    splits = folds(given.table.groups, fold_count, seed)
    highest = highest_level(min(len(train) for train, _ in splits))
    levels = [level for level in LEVELS if level <= highest]
    outer = HeldOut(np.zeros(n, dtype=int), *np.empty((3, n)))
    quantile = np.empty((n, len(levels)))
    inner = []
    for number, (train, test) in enumerate(splits):
        _note(outer, given, fitted(make, given, train), number, everything, test)
        held = hold_out_in_turn(given, train, seed=seed)
        inner.append((train, _scaled(held, given.groups[train])))
        found = conformal_of(given, train, held)
        for place, level in enumerate(levels):
            quantile[test, place] = found.half(given.groups[test], level)
    half = {
        CONFORMAL: quantile,
        OWN: np.tile(stats.norm.ppf(0.5 + 0.5 * np.array(levels)), (n, 1)),
    }
    rows = []
    for method in METHODS:
        for place, level in enumerate(levels):
            inside = outer.score <= half[method][:, place]
            reach = np.minimum(half[method][:, place] * outer.deviation, LARGEST_LOG)
            width = float(np.median(np.expm1(reach)))
            rows.append((method, level, float(inside.mean()), *band(n, level), n, width))
    columns = ["method", "level", "coverage", "band_lower", "band_upper", "tested", "width"]
    calibration = pd.DataFrame(rows, columns=columns)
    reported = calibration[
        (calibration["method"] == CONFORMAL) & calibration["level"].isin(REPORTED)
    ]
    within = {level: outer.score <= quantile[:, levels.index(level)] for level in reported["level"]}
    cross = cross_fitted(outer.score, given.groups, outer.fold)
    score = outer.score / cross
    agreement = np.mean([stats.spearmanr(known, score[rows])[0] for rows, known in inner])
    # Rows that are all met exactly have no ranks.
    draw = faultless_in_folds(outer.fold, float(np.nan_to_num(agreement)))
    parts = regions_of(given.inputs)
    joint = faultless(draw, list(within), given.inputs, parts, seed)
    regions = with_joint_bands(coverage_by_region(within, given.inputs, parts), joint)
    scores = pd.DataFrame(
        {
            "case_id": given.table.keys,
            "fold": outer.fold,
            "log_deviation": outer.deviation,
            "error_scale": cross,
            "score": score,
        }
    )
    summary = {
        "method": CONFORMAL,
        "rows": n,
        "folds": fold_count,
        "error_scale": fit_scale(outer.score, given.groups).describe(),
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
        "regions": joint_summary(regions, joint),
    }
    return IntervalCalibration(calibration, regions, scores, summary)
