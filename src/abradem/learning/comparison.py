"""Comparison of all models: one tidy table of scores, R2 with intervals, and the printed scores.

Two kinds of intervals are computed. Over repeated splits, the central share of the scores shows
how much the score depends on the split. On a single split, a percentile bootstrap of the test
rows shows how much the score depends on those rows. Under the leakage-free protocol all models
have both, on the same splits; as published there is one split.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.learning.published import SCORES
from abradem.learning.scores import (
    SCORE_COLUMNS,
    central,
    r2,
    r2_of_resamples,
    score,
    score_rows,
)
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import Jet, wear_scale

ORDER = (
    "linear", "lasso", "ridge", "pca_wrong_target", "pca", "tree", "forest", "paper_net", "ga_ann",
    "power_law", "boosting", "networks", "gaussian_process", "stacked", "surrogate",
)  # fmt: skip
SPLITS, FIXED, RETRAINED = "repeated splits", "fixed split", "trained again"


METRIC_COLUMNS = {
    "R2": "r2", "R2_log": "r2_log", "R2_number": "r2_number", "RMSE": "rmse", "MAE": "mae",
    "MAPE": "mape",
}  # fmt: skip
"""Columns of `compare` for each metric; the ends of its interval are ``_lower`` and ``_upper``."""


def join_tables(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Concatenate the scores or predictions of all models, sorted by `ORDER`.

    Parameters
    ----------
    tables : list of pandas.DataFrame
        Tables with a column ``model``; models that `ORDER` lacks come last.

    Returns
    -------
    pandas.DataFrame
        All rows; rows of one model keep their order.
    """
    joined = pd.concat(tables, ignore_index=True)
    place = {model: i for i, model in enumerate(ORDER)}
    order = joined["model"].map(lambda model: place.get(model, len(place)))
    return joined.iloc[np.argsort(order, kind="stable")].reset_index(drop=True)


def bootstrap_r2(
    actual: np.ndarray, predicted: np.ndarray, draws: int, confidence: float, seed: int
) -> tuple[float, float]:
    """Percentile bootstrap interval of R2 (Efron and Tibshirani 1993, chapter 13).

    Parameters
    ----------
    actual, predicted : ndarray, shape (n,)
        In the unit of the target.
    draws : int
        Number of resamples of the rows with replacement.
    confidence : float
        Level of the interval, between 0 and 1.
    seed : int

    Returns
    -------
    lower, upper : float
        nan if the rows do not determine them: in too many resamples, such as those that repeat
        one row, the target has no spread and R2 is undefined.
    """
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, len(actual), (draws, len(actual)))
    found, undefined = r2_of_resamples(np.asarray(actual), np.asarray(predicted), rows)
    # A resample without spread could have any R2, down to minus infinity.
    if undefined > 0.5 * (1.0 - confidence) * draws:
        return np.nan, np.nan
    _, _, lower, upper = central(found, confidence)
    return lower, upper


def with_scale(predictions: pd.DataFrame, dataset: pd.DataFrame, jet: Jet) -> pd.DataFrame:
    """Predictions with the ``scale`` of the wear of each row, W m' v^2 / (2 A), mm/s."""
    values = {name: dataset[name].to_numpy(dtype=float) for name in SAMPLED_NAMES}
    scale = pd.Series(wear_scale(values, jet), index=dataset["case_id"].to_numpy())
    return predictions.assign(scale=predictions["case_id"].map(scale).to_numpy(dtype=float))


def number_scores(predictions: pd.DataFrame, table: str) -> pd.DataFrame:
    """R2 of the logarithm of the wear number for the test rows of every split.

    The wear number is the wear divided by its scale, the part of the wear that is not known
    beforehand. Its score has the errors of ln y, related to a smaller variance.

    Parameters
    ----------
    predictions : pandas.DataFrame
        From `with_scale`.
    table : str
        Name of the data set.

    Returns
    -------
    pandas.DataFrame
        With the columns `abradem.learning.scores.SCORE_COLUMNS`, metric ``R2_number``.
    """
    keys = ["model", "protocol", "split", "repeat"]
    rows = []
    for key, part in predictions.groupby(keys, sort=False):
        value = _metrics(part)["R2_number"]
        rows += score_rows(
            {"R2_number": value}, **dict(zip(keys, key, strict=True)), table=table, target_unit="1"
        )
    return pd.DataFrame(rows, columns=SCORE_COLUMNS)


def _metrics(part: pd.DataFrame) -> dict[str, float]:
    """All metrics of some predictions that share a floor."""
    actual, predicted = part["actual"].to_numpy(), part["predicted"].to_numpy()
    floor, scale = float(part["floor"].iloc[0]), part["scale"].to_numpy()
    known = (actual > 0.0).all() and floor > 0.0 and (scale > 0.0).all()
    raised = np.maximum(predicted, floor)
    number = r2(np.log(actual / scale), np.log(raised / scale)) if known else np.nan
    return {**score(actual, predicted, floor), "R2_number": number}


def bootstrap(
    part: pd.DataFrame, draws: int, confidence: float, seed: int
) -> dict[str, tuple[float, float]]:
    """Percentile bootstrap intervals of all metrics on some test rows, see `bootstrap_r2`.

    Parameters
    ----------
    part : pandas.DataFrame
        Predictions of one model and split, with scale.
    draws, confidence, seed
        As for `bootstrap_r2`.

    Returns
    -------
    dict of str to tuple of float
        Lower and upper end for each metric of `METRIC_COLUMNS`; nan where undetermined.
    """
    actual, predicted = part["actual"].to_numpy(), part["predicted"].to_numpy()
    floor, scale = float(part["floor"].iloc[0]), part["scale"].to_numpy()
    options = (draws, confidence, seed)
    found = dict.fromkeys(METRIC_COLUMNS, (np.nan, np.nan))
    found["R2"] = bootstrap_r2(actual, predicted, *options)
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, len(actual), (draws, len(actual)))
    away = np.abs(actual - predicted)
    # Squares of huge errors overflow.
    unit = max(float(away.max(initial=0.0)), 1.0)
    means = {
        "RMSE": unit * np.sqrt(np.mean((away / unit)[rows] ** 2, axis=1)),
        "MAE": np.mean(away[rows], axis=1),
    }
    if (actual > 0.0).all() and floor > 0.0:
        means["MAPE"] = np.mean((away / actual)[rows], axis=1)
        raised = np.maximum(predicted, floor)
        found["R2_log"] = bootstrap_r2(np.log(actual), np.log(raised), *options)
        if (scale > 0.0).all():
            found["R2_number"] = bootstrap_r2(
                np.log(actual / scale), np.log(raised / scale), *options
            )
    for metric, values in means.items():
        _, _, *ends = central(values, confidence)
        found[metric] = (ends[0], ends[1])
    return found


def compare(
    scores: pd.DataFrame,
    predictions: pd.DataFrame,
    draws: int = 2000,
    confidence: float = 0.95,
    seed: int = 0,
) -> pd.DataFrame:
    """Scores on held-out rows for every model and protocol, with intervals.

    Parameters
    ----------
    scores : pandas.DataFrame
        Tidy scores, see `abradem.learning.scores.SCORE_COLUMNS`, and those of `number_scores`.
    predictions : pandas.DataFrame
        From `with_scale`.
    draws : int
        Number of bootstrap resamples.
    confidence : float
        Level of all intervals, between 0 and 1.
    seed : int
        Seed of the bootstrap.

    Returns
    -------
    pandas.DataFrame
        model, protocol, basis (``repeated splits``: median over the splits; ``fixed split``: the
        first split with a bootstrap interval; ``trained again``: median over trainings of the
        same network), repeats, and for each metric of `METRIC_COLUMNS` its value and the ends of
        its interval.
    """
    rows = []
    for (model, protocol), mine in scores.groupby(["model", "protocol"], sort=False):
        head = {"model": model, "protocol": protocol}
        several = {
            basis: {**head, "basis": basis, **over}
            for basis, split in ((SPLITS, "test"), (RETRAINED, "retrained"))
            if (over := _over_repeats(mine[mine["split"] == split], confidence))
        }
        if SPLITS in several:
            rows.append(several[SPLITS])
        fixed = predictions[
            (predictions["model"] == model)
            & (predictions["protocol"] == protocol)
            & (predictions["repeat"] == 0)
            & (predictions["split"] == "test")
        ]
        one = {**head, "basis": FIXED, "repeats": 1}
        if len(fixed):
            values, ends = _metrics(fixed), bootstrap(fixed, draws, confidence, seed)
            for metric in METRIC_COLUMNS:
                one |= _with_ends(metric, values[metric], *ends[metric])
        else:
            tested = mine[mine["split"] == "test"]
            for metric in METRIC_COLUMNS:
                value = tested.loc[tested["metric"] == metric, "value"]
                one |= _with_ends(metric, value.iloc[0] if len(value) else np.nan, np.nan, np.nan)
        rows.append(one)
        if RETRAINED in several:
            rows.append(several[RETRAINED])
    names = [name + end for name in METRIC_COLUMNS.values() for end in ("", "_lower", "_upper")]
    return pd.DataFrame(rows, columns=["model", "protocol", "basis", "repeats", *names])


def _with_ends(metric: str, value: float, lower: float, upper: float) -> dict[str, float]:
    name = METRIC_COLUMNS[metric]
    return {name: value, f"{name}_lower": lower, f"{name}_upper": upper}


def _over_repeats(mine: pd.DataFrame, confidence: float) -> dict[str, float]:
    """Median and central share of each metric over the repeats; empty for a single one."""
    found: dict[str, float] = {}
    for metric in METRIC_COLUMNS:
        values = mine.loc[mine["metric"] == metric, "value"].to_numpy(dtype=float)
        if metric == "R2":
            if len(values) < 2:
                return {}
            found["repeats"] = central(values, confidence)[0]
        count, middle, *ends = central(values, confidence)
        found |= _with_ends(metric, middle, *(ends if count > 1 else (np.nan, np.nan)))
    return found


def beside_paper(comparison: pd.DataFrame) -> pd.DataFrame:
    """Printed R2, R2 reproduced as published, and leakage-free R2 of each model.

    Parameters
    ----------
    comparison : pandas.DataFrame
        From `compare`.

    Returns
    -------
    pandas.DataFrame
        model, printed_r2, as_published_r2, leakage_free_r2, leakage_free_lower,
        leakage_free_upper, leakage_free_r2_log, leakage_free_r2_number, basis (of the leakage-free
        score), remark. Missing scores are nan.
    """
    rows = []
    for model in ORDER:
        mine = comparison[comparison["model"] == model]
        if mine.empty:
            continue
        published = mine[(mine["protocol"] == AS_PUBLISHED) & (mine["basis"] == FIXED)]["r2"]
        leakage_free = mine[mine["protocol"] == LEAKAGE_FREE]
        best = next(
            (
                leakage_free[leakage_free["basis"] == basis].iloc[0]
                for basis in (SPLITS, FIXED)
                if (leakage_free["basis"] == basis).any()
            ),
            None,
        )
        printed, remark = SCORES.get(model, (np.nan, ""))
        rows.append(
            {
                "model": model,
                "printed_r2": printed,
                "as_published_r2": published.iloc[0] if len(published) else np.nan,
                "leakage_free_r2": np.nan if best is None else best["r2"],
                "leakage_free_lower": np.nan if best is None else best["r2_lower"],
                "leakage_free_upper": np.nan if best is None else best["r2_upper"],
                "leakage_free_r2_log": np.nan if best is None else best["r2_log"],
                "leakage_free_r2_number": np.nan if best is None else best["r2_number"],
                "basis": "" if best is None else best["basis"],
                "remark": remark,
            }
        )
    return pd.DataFrame(rows)
