"""All models side by side: one tidy table of scores, one comparison, and the printed figures.

Two intervals answer two questions. Over repeated splits, the central share of the scores tells
how much one split may mislead. For a model that is trained on one split only, a bootstrap of its
test rows (percentiles) tells how much those rows may. Every model has the second, on the same
rows; cheap ones have the first too.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.learning.published import SCORES
from abradem.learning.scores import r2

ORDER = (
    "linear", "lasso", "ridge", "pca_wrong_target", "pca", "tree", "forest", "paper_net", "ga_ann",
    "power_law", "boosting", "networks", "gaussian_process", "surrogate",
)  # fmt: skip
SPLITS, FIXED, RETRAINED = "repeated splits", "fixed split", "trained again"


def join_tables(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """The scores or predictions of all models, in the order of `ORDER`."""
    joined = pd.concat(tables, ignore_index=True)
    place = {model: i for i, model in enumerate(ORDER)}
    order = joined["model"].map(lambda model: place.get(model, len(place)))
    return joined.iloc[np.argsort(order, kind="stable")].reset_index(drop=True)


def bootstrap_r2(
    actual: np.ndarray, predicted: np.ndarray, draws: int, confidence: float, seed: int
) -> tuple[float, float]:
    """Percentile interval of R2 over draws of the rows with replacement; nan for few rows."""
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, len(actual), (draws, len(actual)))
    y, error = actual[rows], (actual - predicted)[rows]
    spread = np.sum((y - y.mean(axis=1, keepdims=True)) ** 2, axis=1)
    kept = spread > 0.0
    if not kept.any():
        return np.nan, np.nan
    found = 1.0 - np.sum(error[kept] ** 2, axis=1) / spread[kept]
    tail = 50.0 * (1.0 - confidence)
    lower, upper = np.percentile(found, [tail, 100.0 - tail])
    return float(lower), float(upper)


def compare(
    scores: pd.DataFrame,
    predictions: pd.DataFrame,
    draws: int = 2000,
    confidence: float = 0.95,
    seed: int = 0,
) -> pd.DataFrame:
    """R2 on held-out rows of every model and protocol.

    Returns
    -------
    pandas.DataFrame
        model, protocol, basis (``repeated splits``: median; ``fixed split``: the first split
        with a bootstrap interval; ``trained again``: median over trainings of the same net),
        repeats, r2, r2_lower, r2_upper.
    """
    rows = []
    tail = 50.0 * (1.0 - confidence)
    held = scores[scores["metric"] == "R2"]
    for (model, protocol), mine in held.groupby(["model", "protocol"], sort=False):
        several = {}
        for basis, split in ((SPLITS, "test"), (RETRAINED, "retrained")):
            values = mine.loc[mine["split"] == split, "value"].dropna().to_numpy()
            if len(values) > 1:
                low, middle, high = np.percentile(values, [tail, 50.0, 100.0 - tail])
                several[basis] = (model, protocol, basis, len(values), middle, low, high)
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
    """The printed figure, what its steps give here, and the leakage-free score, for each model.

    Returns
    -------
    pandas.DataFrame
        model, printed_r2, as_published_r2, honest_r2, honest_lower, honest_upper, basis (of the
        leakage-free score), remark. nan where there is no such figure.
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
