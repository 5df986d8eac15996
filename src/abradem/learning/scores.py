"""Scores on the target and on its logarithm, in one tidy table.

R2 = 1 - sum (y - p)^2 / sum (y - mean y)^2 over the rows scored. It is undefined, nan, if they have
no spread. Wear rates are positive, but a
linear model may predict negative ones. Only for the score on ln y, predictions are raised to the
smallest target of the training rows; ``floored_share`` is the share of predictions raised.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from abradem.dataset.variation import held_fixed
from abradem.learning.rows import HUGE

METRICS = ("R2", "RMSE", "MAE", "MAPE", "R2_log", "floored_share")
SCORE_COLUMNS = ["model", "protocol", "table", "split", "repeat", "metric", "value", "unit"]


WORST = -1e9
"""Smallest R2 that is told apart; far below it, means and intervals of R2 would overflow."""


def r2(actual: np.ndarray, predicted: np.ndarray) -> float:
    """Coefficient of determination, at least `WORST`.

    It is nan for fewer than two rows, and for a target without spread: a score relative to the
    last digits of a constant says nothing.
    """
    if len(actual) < 2 or not has_spread(actual):
        return np.nan
    return float(_r2_of(np.asarray(actual)[None, :], np.asarray(actual - predicted)[None, :])[0])


def has_spread(actual: np.ndarray) -> bool:
    """Whether a target (n,) varies beyond float noise."""
    return not held_fixed(np.asarray(actual, dtype=float)[:, None])[0]


def r2_of_resamples(
    actual: np.ndarray, predicted: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, int]:
    """R2 on resamples of the rows.

    Parameters
    ----------
    actual, predicted : ndarray, shape (n,)
    rows : ndarray of int, shape (draws, k)
        Row numbers of each resample.

    Returns
    -------
    found : ndarray
        R2 of the resamples whose target has a spread.
    undefined : int
        Number of the others.
    """
    y = actual[rows]
    kept = ~held_fixed(y.T)
    return _r2_of(y[kept], (actual - predicted)[rows][kept]), int(np.sum(~kept))


def _r2_of(actual: np.ndarray, error: np.ndarray) -> np.ndarray:
    """R2 for each row of targets that vary and their errors, both of shape (m, k)."""
    size = max(np.abs(actual).max(initial=0.0), np.abs(error).max(initial=0.0))
    if not 1.0 / HUGE < size < HUGE:
        # Squares would overflow or vanish; R2 does not depend on the unit.
        unit = np.abs(actual).max(axis=1, keepdims=True)
        with np.errstate(over="ignore"):
            actual, error = actual / unit, np.clip(error / unit, -HUGE, HUGE)
    spread = np.sum((actual - actual.mean(axis=1, keepdims=True)) ** 2, axis=1)
    return np.maximum(1.0 - np.sum(error**2, axis=1) / spread, WORST)


def central(values: ArrayLike, confidence: float) -> tuple[int, float, float, float]:
    """Number of defined values, their median, and the ends of their central share.

    Parameters
    ----------
    values : array of float
        Undefined ones are nan and do not count.
    confidence : float
        Central share.

    Returns
    -------
    count : int
    middle, lower, upper : float
        nan if no value is defined.
    """
    found = _defined(values)
    if not found.size:
        return 0, np.nan, np.nan, np.nan
    tail = 50.0 * (1.0 - confidence)
    lower, middle, upper = np.percentile(found, [tail, 50.0, 100.0 - tail])
    return found.size, float(middle), float(lower), float(upper)


def central_columns(
    values: np.ndarray, confidence: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Median and ends of the central share of each column of ``values`` (n, k), see `central`."""
    columns = np.asarray(values, dtype=float).T
    ends = np.array([central(column, confidence)[2:] for column in columns]).reshape(-1, 2)
    return np.array([middle_of(column) for column in columns]), ends[:, 0], ends[:, 1]


def middle_of(values: ArrayLike) -> float:
    """Median of the defined values; nan if there are none."""
    found = _defined(values)
    return float(np.median(found)) if found.size else np.nan


def _defined(values: ArrayLike) -> np.ndarray:
    found = np.asarray(values, dtype=float)
    return found[np.isfinite(found)]


def mean_columns(values: np.ndarray) -> np.ndarray:
    """Mean of the defined values of each column of ``values`` (n, k); nan if there are none."""
    values = np.asarray(values, dtype=float)
    known = np.isfinite(values)
    count = known.sum(axis=0)
    total = np.where(known, values, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def score(actual: np.ndarray, predicted: np.ndarray, floor: float) -> dict[str, float]:
    """All metrics of some predictions; undefined ones are nan.

    Parameters
    ----------
    actual, predicted : ndarray, shape (n,)
        In the unit of the target.
    floor : float
        Smallest target of the training rows; R2_log raises smaller predictions to it.

    Returns
    -------
    dict of str to float
        One value for each of `METRICS`; RMSE and MAE are in the unit of the target.
    """
    actual, predicted = np.asarray(actual, dtype=float), np.asarray(predicted, dtype=float)
    error = predicted - actual
    positive = bool((actual > 0.0).all() and floor > 0.0)
    largest = float(np.abs(error).max(initial=0.0))
    # Squares of huge errors overflow.
    unit = largest if largest > HUGE else 1.0
    return {
        "R2": r2(actual, predicted),
        "RMSE": unit * float(np.sqrt(np.mean((error / unit) ** 2))),
        "MAE": float(np.mean(np.abs(error))),
        "MAPE": float(np.mean(np.abs(error) / actual)) if positive else np.nan,
        "R2_log": r2(np.log(actual), np.log(np.maximum(predicted, floor))) if positive else np.nan,
        "floored_share": float(np.mean(predicted < floor * (1.0 - 1e-9))) if positive else np.nan,
    }


def score_rows(
    metrics: dict[str, float],
    *,
    model: str,
    protocol: str,
    table: str,
    split: str,
    repeat: int,
    target_unit: str,
) -> list[dict]:
    """Rows of the tidy table, with the columns `SCORE_COLUMNS`, for the metrics of one split."""
    keys = {"model": model, "protocol": protocol, "table": table, "split": split, "repeat": repeat}
    return [
        {
            **keys,
            "metric": name,
            "value": value,
            "unit": target_unit if name in ("RMSE", "MAE") else "1",
        }
        for name, value in metrics.items()
    ]


def score_intervals(scores: pd.DataFrame, confidence: float = 0.95) -> pd.DataFrame:
    """Mean, median and interval of each metric over the repeats.

    The interval contains the central share ``confidence`` of the repeats. Splits of one data set
    overlap, so it shows how much the score depends on the split; it is not a confidence interval
    of the mean.

    Returns
    -------
    pandas.DataFrame
        model, protocol, table, split, metric, unit, repeats (those with a finite value), mean,
        median, lower, upper.
    """
    keys = ["model", "protocol", "table", "split", "metric", "unit"]
    rows = []
    for key, group in scores.groupby(keys, sort=False):
        values = group["value"].to_numpy(dtype=float)
        count, median, lower, upper = central(values, confidence)
        mean = float(values[np.isfinite(values)].mean()) if count else np.nan
        rows.append((*key, count, mean, median, lower, upper))
    return pd.DataFrame(rows, columns=[*keys, "repeats", "mean", "median", "lower", "upper"])


def scores_of(scores: pd.DataFrame, model: str, protocol: str, confidence: float = 0.95) -> dict:
    """Mean, median and interval of all metrics of one model, as stored in its JSON file."""
    mine = scores[(scores["model"] == model) & (scores["protocol"] == protocol)]
    return {
        split: {
            row.metric: {
                "mean": row.mean,
                "median": row.median,
                "lower": row.lower,
                "upper": row.upper,
                "unit": row.unit,
            }
            for row in rows.itertuples(index=False)
        }
        for split, rows in score_intervals(mine, confidence).groupby("split", sort=False)
    }
