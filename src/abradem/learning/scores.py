"""Scores on the target and on its logarithm, in one tidy table.

R2 = 1 - sum (y - p)^2 / sum (y - mean y)^2 over the rows scored. Wear rates are positive, but a
linear model may predict negative ones. Only for the score on ln y, predictions are raised to the
smallest target of the training rows; ``floored_share`` is the share of predictions raised.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

METRICS = ("R2", "RMSE", "MAE", "MAPE", "R2_log", "floored_share")
SCORE_COLUMNS = ["model", "protocol", "table", "split", "repeat", "metric", "value", "unit"]


def r2(actual: np.ndarray, predicted: np.ndarray) -> float:
    """Coefficient of determination; nan for fewer than two rows or a constant target."""
    if len(actual) < 2:
        return np.nan
    spread = float(np.sum((actual - np.mean(actual)) ** 2))
    return 1.0 - float(np.sum((actual - predicted) ** 2)) / spread if spread > 0.0 else np.nan


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
    return {
        "R2": r2(actual, predicted),
        "RMSE": float(np.sqrt(np.mean(error**2))),
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
        values = values[np.isfinite(values)]
        tail = 50.0 * (1.0 - confidence)
        lower, median, upper = (
            np.percentile(values, [tail, 50.0, 100.0 - tail]) if values.size else [np.nan] * 3
        )
        mean = float(values.mean()) if values.size else np.nan
        rows.append((*key, values.size, mean, float(median), float(lower), float(upper)))
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
