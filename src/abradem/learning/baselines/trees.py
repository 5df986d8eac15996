"""Decision tree and random forest.

``as_published`` grows trees of depth 1 to 49 on unscaled features and chooses the depth on the
test rows. Without scaling, differences of the wear constant (1e-8 1/Pa) are below the smallest
difference that scikit-learn splits on (1e-7), so the tree cannot use the constant at all.
``leakage_free`` standardises the features and uses cost-complexity pruning (Breiman et al. 1984,
Classification and Regression Trees), with the penalty chosen by cross-validation inside the
training rows. The random forest (Breiman 2001, Machine Learning 45:5) is leakage-free only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, variation
from abradem.learning.evaluation import (
    Results,
    evaluate_as_published,
    evaluate_leakage_free,
    scalers_of_all_rows,
    with_scalers,
)
from abradem.learning.model_files import about, tree_arrays
from abradem.learning.protocols import (
    AS_PUBLISHED,
    LEAKAGE_FREE,
    PUBLISHED_SEED,
    PUBLISHED_SHARE,
    folds,
    published_split,
    repeated_splits,
)
from abradem.learning.rows import FEWEST_ROWS, Table, learning_table, standard_scaler
from abradem.learning.scores import central_columns, mean_columns, r2, scores_of
from abradem.quantities import quantity

TREE, FOREST = "tree", "forest"
MOST_PENALTIES = 60
"""Largest number of penalties tried along the pruning sequence, from root only to full tree."""


@dataclass(frozen=True)
class TreesResult:
    """Result of `fit_trees`.

    Attributes
    ----------
    curve : pandas.DataFrame
        protocol, depth, split, r2, r2_lower, r2_upper; leakage-free: median over the repeated
        splits and their central share.
    nodes : pandas.DataFrame
        The pruned tree of all rows: protocol, node, parent, left, right, symbol, feature,
        threshold (in the feature's unit), unit, rows, predicted (mm/s).
    importance : pandas.DataFrame
        model, protocol, symbol, feature, importance (share of the variance removed by splits on
        the feature), variation. Features that were held fixed have no importance (nan); that of
        features that are not identified is shared among them at random.
    results : Results
    models : dict
        Description and arrays of tree and forest.
    summary : dict
    """

    curve: pd.DataFrame
    nodes: pd.DataFrame
    importance: pd.DataFrame
    results: Results
    models: dict
    summary: dict


def grow(x: np.ndarray, y: np.ndarray, depth: int | None = None, penalty: float = 0.0):
    """Fit a scikit-learn regression tree with a fixed seed."""
    from sklearn.tree import DecisionTreeRegressor

    return DecisionTreeRegressor(
        max_depth=depth, ccp_alpha=penalty, random_state=PUBLISHED_SEED
    ).fit(x, y)


def choose_penalty(
    x: np.ndarray, y: np.ndarray, groups: np.ndarray, fold_count: int, seed: int
) -> float:
    """Complexity penalty with the best mean R2 over the folds."""
    path = grow(x, y).cost_complexity_pruning_path(x, y).ccp_alphas
    # The tree is the same between two penalties of the sequence, so try their geometric means.
    # Beyond the last penalty only the root is left.
    middles = np.sqrt(np.maximum(path[:-1], 0.0) * path[1:])
    sequence = np.unique([0.0, *middles, 2.0 * path[-1]])
    # Of many penalties keep few: densely for small trees, sparsely for large ones.
    places = np.unique(np.geomspace(1, len(sequence), MOST_PENALTIES).round().astype(int))
    candidates = sequence[-places[::-1]]
    scores = [
        [r2(y[check], grow(x[train], y[train], None, c).predict(x[check])) for c in candidates]
        for train, check in folds(groups, fold_count, seed)
    ]
    means = np.nan_to_num(mean_columns(np.array(scores)), nan=-np.inf)
    # Of equally good penalties take the one with the simplest tree.
    return float(candidates[len(means) - 1 - int(np.argmax(means[::-1]))])


def fit_trees(
    table: Table,
    max_depth: int = 49,
    forest_trees: int = 200,
    fold_count: int = 5,
    test_share: float = 0.2,
    repeats: int = 20,
    confidence: float = 0.95,
    seed: int = 0,
) -> TreesResult:
    """Fit decision tree and random forest.

    Parameters
    ----------
    table : Table
    max_depth : int
        Largest depth of the curve.
    forest_trees : int
        Number of trees of the forest.
    fold_count : int
        Folds of the cross-validation that chooses the penalty.
    test_share, repeats, confidence, seed
        Of the leakage-free splits.

    Returns
    -------
    TreesResult
    """
    results = Results(table)
    x, y = table.features, table.target
    published = _published_depths(table, max_depth)
    tests = published[published["split"] == "test"]
    # R2 is nan for a constant test target.
    best = 1 if tests["r2"].isna().all() else int(tests.loc[tests["r2"].idxmax(), "depth"])
    evaluate_as_published(results, TREE, lambda a, b, _: grow(a, b, best).predict)

    penalties = []

    def pruned(features, target, groups):
        penalties.append(choose_penalty(features, target, groups, fold_count, seed))
        return grow(features, target, None, penalties[-1]).predict

    splits: dict[str, Any] = {"test_share": test_share, "repeats": repeats, "seed": seed}
    evaluate_leakage_free(results, TREE, with_scalers(pruned), **splits)
    evaluate_leakage_free(
        results, FOREST, with_scalers(lambda a, b, _: _forest(a, b, forest_trees).predict), **splits
    )

    scalers = scalers_of_all_rows(table)
    z, v = scalers[0].forward(x), scalers[1].forward(y)
    penalty = choose_penalty(z, v, table.groups, fold_count, seed)
    tree, forest = grow(z, v, None, penalty), _forest(z, v, forest_trees)
    arrays = {TREE: tree_arrays([tree]), FOREST: tree_arrays(forest.estimators_)}
    more: dict[str, dict[str, Any]] = {
        TREE: {"ccp_alpha": penalty},
        FOREST: {"trees": forest_trees},
    }
    return TreesResult(
        curve=pd.concat(
            [
                published,
                _leakage_free_depths(table, max_depth, test_share, repeats, confidence, seed),
            ],
            ignore_index=True,
        ),
        nodes=_nodes(arrays[TREE], table.names, tree.tree_.n_node_samples, scalers),
        importance=pd.concat(
            [_importance(TREE, tree, table), _importance(FOREST, forest, table)],
            ignore_index=True,
        ),
        results=results,
        models={
            name: (
                about(
                    table,
                    name,
                    LEAKAGE_FREE,
                    "trees",
                    scalers,
                    **more[name],
                    confidence=confidence,
                    scores=scores_of(results.scores, name, LEAKAGE_FREE, confidence),
                ),
                arrays[name],
            )
            for name in (TREE, FOREST)
        },
        summary={
            "best_depth_on_test_rows": {AS_PUBLISHED: best},
            "published_splits_on_wear_constant": _splits_on(table, best, "archard_constant"),
            "pruned": {
                "ccp_alpha": penalty,
                "depth": int(tree.get_depth()),
                "leaves": int(tree.get_n_leaves()),
            },
            "ccp_alphas_of_the_splits": penalties,
        },
    )


def _forest(x: np.ndarray, y: np.ndarray, trees: int):
    from sklearn.ensemble import RandomForestRegressor

    return RandomForestRegressor(n_estimators=trees, random_state=PUBLISHED_SEED).fit(x, y)


def _depths(x, y, train, test, max_depth: int, scale) -> np.ndarray:
    """R2 on training and test rows for each depth, shape (2, max_depth)."""
    of_x = scale(x[train])
    found, last = [], None
    for depth in range(1, max_depth + 1):
        # A fully grown tree does not change with a larger depth limit.
        if last is None or last.get_depth() == depth - 1:
            last = grow(of_x(x[train]), y[train], depth)
            scores = [r2(y[rows], last.predict(of_x(x[rows]))) for rows in (train, test)]
        found.append(scores)
    return np.array(found).T


def _published_depths(table: Table, max_depth: int) -> pd.DataFrame:
    train, test = published_split(len(table.target), PUBLISHED_SHARE)
    found = _depths(
        table.features, table.target, train, test, max_depth, lambda rows: lambda values: values
    )
    return _depth_rows(AS_PUBLISHED, found)


def _leakage_free_depths(table, max_depth, test_share, repeats, confidence, seed) -> pd.DataFrame:
    found = np.array(
        [
            _depths(
                table.features, table.target, train, test, max_depth,
                lambda rows: standard_scaler(rows).forward,
            )
            for train, test in repeated_splits(table.keys, table.groups, test_share, repeats, seed)
        ]
    )  # fmt: skip
    ends = central_columns(found.reshape(len(found), -1), confidence)
    return _depth_rows(LEAKAGE_FREE, *(end.reshape(found.shape[1:]) for end in ends))


def _depth_rows(protocol, found, lower=None, upper=None) -> pd.DataFrame:
    depths = np.arange(1, found.shape[1] + 1)
    return pd.concat(
        [
            pd.DataFrame(
                {
                    "protocol": protocol,
                    "depth": depths,
                    "split": split,
                    "r2": found[i],
                    "r2_lower": np.nan if lower is None else lower[i],
                    "r2_upper": np.nan if upper is None else upper[i],
                }
            )
            for i, split in enumerate(("train", "test"))
        ],
        ignore_index=True,
    )


def _splits_on(table: Table, depth: int, feature: str) -> int:
    """Number of splits of the published tree that use a feature."""
    train, _ = published_split(len(table.target), PUBLISHED_SHARE)
    tree = grow(table.features[train], table.target[train], depth).tree_
    return int(np.sum(tree.feature == table.names.index(feature)))


def _nodes(arrays: dict, names: Sequence[str], samples: np.ndarray, scalers) -> pd.DataFrame:
    of_x, of_y = scalers
    count = len(arrays["value"])
    parent = np.full(count, -1)
    for side in ("left", "right"):
        inner = arrays[side] >= 0
        parent[arrays[side][inner]] = np.flatnonzero(inner)
    feature = arrays["feature"]
    rows = [quantity(names[column]) if column >= 0 else None for column in feature]
    threshold = np.where(
        feature >= 0, of_x.mean[feature] + of_x.scale[feature] * arrays["threshold"], np.nan
    )
    return pd.DataFrame(
        {
            "protocol": LEAKAGE_FREE,
            "node": np.arange(count),
            "parent": parent,
            "left": arrays["left"],
            "right": arrays["right"],
            "symbol": [row.symbol if row else "" for row in rows],
            "feature": [row.name if row else "" for row in rows],
            "threshold": threshold,
            "unit": [row.unit if row else "" for row in rows],
            "rows": samples,
            "predicted": of_y.back(arrays["value"]),
        }
    )


def _importance(model: str, fitted, table: Table) -> pd.DataFrame:
    # Trees do not tell a feature from a function of it, such as damping and restitution.
    says = variation(table.features, table.names)
    return pd.DataFrame(
        {
            "model": model,
            "protocol": LEAKAGE_FREE,
            "symbol": [quantity(name).symbol for name in table.names],
            "feature": list(table.names),
            "importance": np.where(says == HELD_FIXED, np.nan, fitted.feature_importances_),
            "variation": says,
        }
    )


def train(dataset: pd.DataFrame, target: str, name: str, **options) -> dict:
    """Outputs of the workflow rule by name; ``options`` are arguments of `fit_trees`."""
    found = fit_trees(learning_table(dataset, target, name, FEWEST_ROWS), **options)
    return {
        "curve": found.curve,
        "nodes": found.nodes,
        "importance": found.importance,
        "scores": found.results.scores,
        "predictions": found.results.predictions,
        "summary": found.summary,
        **found.models,
    }
