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
from abradem.learning.scores import central, r2, r2_of_resamples

ORDER = (
    "linear", "lasso", "ridge", "pca_wrong_target", "pca", "tree", "forest", "paper_net", "ga_ann",
    "power_law", "boosting", "networks", "gaussian_process", "surrogate",
)  # fmt: skip
SPLITS, FIXED, RETRAINED = "repeated splits", "fixed split", "trained again"


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


def compare(
    scores: pd.DataFrame,
    predictions: pd.DataFrame,
    draws: int = 2000,
    confidence: float = 0.95,
    seed: int = 0,
) -> pd.DataFrame:
    """R2 on held-out rows for every model and protocol.

    Parameters
    ----------
    scores : pandas.DataFrame
        Tidy scores, see `abradem.learning.scores.SCORE_COLUMNS`.
    predictions : pandas.DataFrame
        See `abradem.learning.evaluation.PREDICTION_COLUMNS`.
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
        same network), repeats, r2, r2_lower, r2_upper.
    """
    rows = []
    held = scores[scores["metric"] == "R2"]
    for (model, protocol), mine in held.groupby(["model", "protocol"], sort=False):
        several = {}
        for basis, split in ((SPLITS, "test"), (RETRAINED, "retrained")):
            values = mine.loc[mine["split"] == split, "value"].to_numpy(dtype=float)
            if len(values) > 1:
                count, middle, *ends = central(values, confidence)
                ends = ends if count > 1 else [np.nan, np.nan]
                several[basis] = (model, protocol, basis, count, middle, *ends)
        if SPLITS in several:
            rows.append(several[SPLITS])
        fixed = predictions[
            (predictions["model"] == model)
            & (predictions["protocol"] == protocol)
            & (predictions["repeat"] == 0)
            & (predictions["split"] == "test")
        ]
        if len(fixed):
            actual, predicted = fixed["actual"].to_numpy(), fixed["predicted"].to_numpy()
            interval = bootstrap_r2(actual, predicted, draws, confidence, seed)
            rows.append((model, protocol, FIXED, 1, r2(actual, predicted), *interval))
        else:
            value = mine.loc[mine["split"] == "test", "value"]
            rows.append((model, protocol, FIXED, 1, value.iloc[0], np.nan, np.nan))
        if RETRAINED in several:
            rows.append(several[RETRAINED])
    columns = ["model", "protocol", "basis", "repeats", "r2", "r2_lower", "r2_upper"]
    return pd.DataFrame(rows, columns=columns)


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
        leakage_free_upper, basis (of the leakage-free score), remark. Missing scores are nan.
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
                "basis": "" if best is None else best["basis"],
                "remark": remark,
            }
        )
    return pd.DataFrame(rows)
