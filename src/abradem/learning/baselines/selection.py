"""Selection of the features of the networks, by regression weights and loadings.

The paper chose 12 of the 20 features "from weights and loadings" without stating a rule. The rule
used here can be applied inside the training rows:

1. Rank the features by weight: the larger of the absolute weights of lasso and ridge
   (standardised, penalties as published).
2. Rank the features by loading: their share in the leading components, which is the sum of
   squared loading times variance over the first components that explain half of the variance.
3. Half of the selected features are those with the largest weights, the others those with the
   largest loadings among the remaining features.

Weights rank single features by how well they explain the wear; loadings rank features that
represent many others. Neither proves that a feature matters.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, held_fixed, of_kind
from abradem.learning.baselines.pca import principal_components
from abradem.learning.baselines.penalised import weights
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE, repeated_splits
from abradem.learning.published import SELECTED
from abradem.learning.rows import FEWEST_ROWS, Table, learning_table, minmax_scaler, standard_scaler
from abradem.quantities import FEATURE_NAMES, quantity

LEADING = 0.5
"""Share of the variance explained by the leading components."""
BY_WEIGHT = 0.5
"""Share of the features selected by weight."""


def select(
    x: np.ndarray,
    y: np.ndarray,
    count: int,
    lasso_alpha: float = 0.1,
    ridge_alpha: float = 1.0,
    minmax: bool = False,
    names: Sequence[str] = FEATURE_NAMES,
) -> tuple[np.ndarray, pd.DataFrame]:
    """Choose ``count`` features by the rule of this module.

    Parameters
    ----------
    x : ndarray, shape (n, p)
    y : ndarray, shape (n,)
    count : int
        Number of features to choose.
    lasso_alpha, ridge_alpha : float
        Penalties.
    minmax : bool
        Whether to scale to 0...1 (as published) instead of standardising before the component
        analysis.
    names : sequence of str
        Of the features.

    Returns
    -------
    columns : ndarray of int, shape (k,)
        Column numbers of the chosen features, ascending; fewer than ``count`` if fewer vary.
    table : pandas.DataFrame
        symbol, feature, lasso_weight, ridge_weight, leading_share, chosen_by (``weight``,
        ``loading`` or ""). Features held fixed in these rows have no
        weight and no share (nan).
    """
    z, v = standard_scaler(x).forward(x), standard_scaler(y).forward(y)
    (lasso,) = weights("lasso", z, v, np.array([lasso_alpha]))
    (ridge,) = weights("ridge", z, v, np.array([ridge_alpha]))
    varied = np.flatnonzero(~held_fixed(x))
    if not len(varied):
        # Few rows may all share the value of the only quantity of the study.
        varied = np.array([0])
    parts = principal_components((minmax_scaler(x).forward(x) if minmax else z)[:, varied])
    cumulative = np.cumsum(parts.variances) / (parts.variances.sum() or 1.0)
    leading = int(np.searchsorted(cumulative, LEADING)) + 1
    loading = np.full(x.shape[1], np.nan)
    loading[varied] = parts.variances[:leading] @ parts.axes[:leading] ** 2

    weight = np.maximum(np.abs(lasso), np.abs(ridge))
    by_weight = varied[np.argsort(-weight[varied], kind="stable")]
    first = by_weight[: max(1, round(BY_WEIGHT * count))]
    by_loading = varied[np.argsort(-loading[varied], kind="stable")]
    others = [column for column in by_loading if column not in first]
    second = others[: count - len(first)]
    chosen_by = np.full(x.shape[1], "", dtype=object)
    chosen_by[first], chosen_by[second] = "weight", "loading"
    table = pd.DataFrame(
        {
            "symbol": [quantity(name).symbol for name in names],
            "feature": list(names),
            "lasso_weight": np.where(np.isnan(loading), np.nan, lasso),
            "ridge_weight": np.where(np.isnan(loading), np.nan, ridge),
            "leading_share": loading / (loading[varied].sum() or 1.0),
            "chosen_by": chosen_by,
        }
    )
    return np.sort(np.concatenate([first, second]).astype(int)), table


def fit_selection(
    table: Table,
    count: int = 12,
    lasso_alpha: float = 0.1,
    ridge_alpha: float = 1.0,
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
) -> tuple[pd.DataFrame, dict]:
    """Features chosen under both protocols, compared with the list of the paper.

    Parameters
    ----------
    table : Table
    count, lasso_alpha, ridge_alpha
        See `select`.
    test_share, repeats, seed
        Of the leakage-free splits.

    Returns
    -------
    selection : pandas.DataFrame
        protocol and the columns of `select` (leakage-free: of the first split), ``survives`` (share
        of the selections that choose the feature; as published there is one, on all rows,
        leakage-free one on the training rows of each split; nan for features held fixed in all
        rows), ``in_paper`` and ``variation``.
    summary : dict
        For each protocol the chosen features and how many of them are in the list of the paper.
    """
    penalties = (lasso_alpha, ridge_alpha)
    frames, summary = [], {}
    columns, chosen = select(
        table.features, table.target, count, *penalties, minmax=True, names=table.names
    )
    frames.append(_labelled(AS_PUBLISHED, chosen, np.isin(np.arange(len(chosen)), columns)))
    summary[AS_PUBLISHED] = _agreement(table.names, columns)

    hits, of_splits = np.zeros(len(table.names)), []
    for train, _ in repeated_splits(table.keys, table.groups, test_share, repeats, seed):
        columns, chosen = select(
            table.features[train], table.target[train], count, *penalties, names=table.names
        )
        hits[columns] += 1.0
        of_splits.append((columns, chosen))
    of_first, first = of_splits[0]
    frames.append(_labelled(LEAKAGE_FREE, first, hits / repeats))
    summary[LEAKAGE_FREE] = _agreement(table.names, of_first)
    selection = pd.concat(
        [frame.assign(variation=table.variation) for frame in frames], ignore_index=True
    )
    selection.loc[selection["variation"] == HELD_FIXED, "survives"] = np.nan
    fixed = of_kind(table.names, table.variation, HELD_FIXED)
    return selection, {
        "count": min(count, len(table.varied)), "held_fixed": fixed, **summary,
    }  # fmt: skip


def _labelled(protocol: str, chosen: pd.DataFrame, survives: np.ndarray) -> pd.DataFrame:
    return chosen.assign(
        protocol=protocol,
        survives=np.asarray(survives, dtype=float),
        in_paper=[name in SELECTED for name in chosen["feature"]],
    )


def _agreement(known: Sequence[str], columns: np.ndarray) -> dict:
    names = [known[column] for column in columns]
    shared = [name for name in names if name in SELECTED]
    return {
        "features": names,
        "shared_with_paper": len(shared),
        "missing_from_paper": [name for name in SELECTED if name not in names],
        "not_in_paper": [name for name in names if name not in SELECTED],
    }


def train(dataset: pd.DataFrame, target: str, name: str, **options) -> dict:
    """Outputs of the workflow rule by name; ``options`` are arguments of `fit_selection`."""
    rows = learning_table(dataset, target, name, FEWEST_ROWS)
    selection, summary = fit_selection(rows, **options)
    return {"selection": selection, "summary": summary}
