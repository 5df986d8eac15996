"""Fit a model to the training rows of each split and score it on the held-out rows.

A model is a function ``fit(features, target, groups)`` that returns a function
``predict(features)``. Features have shape (n, p), targets, groups of rows and predictions shape
(n,). The groups are those that no split inside the training rows may divide. `with_scalers` wraps a
model that expects standardised variables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pandas as pd

from abradem.learning.protocols import (
    AS_PUBLISHED,
    LEAKAGE_FREE,
    PUBLISHED_SHARE,
    published_split,
    repeated_splits,
)
from abradem.learning.rows import Scaler, Table, standard_scaler
from abradem.learning.scores import SCORE_COLUMNS, score, score_rows

Predict = Callable[[np.ndarray], np.ndarray]
Fit = Callable[[np.ndarray, np.ndarray, np.ndarray], Predict]

PREDICTION_COLUMNS = [
    "model", "protocol", "case_id", "repeat", "split", "actual", "predicted", "floor",
]  # fmt: skip


class Results:
    """Scores and predictions collected over models, protocols and splits.

    Parameters
    ----------
    table : Table
        Rows that the predictions belong to.
    """

    def __init__(self, table: Table):
        self.table = table
        self._scores: list[dict] = []
        self._predictions: list[pd.DataFrame] = []

    def add(
        self,
        model: str,
        protocol: str,
        split: str,
        repeat: int,
        rows: np.ndarray,
        predicted: np.ndarray,
        floor: float,
        keep: bool = True,
    ) -> dict[str, float]:
        """Score the predictions of some rows, and store them.

        Parameters
        ----------
        model, protocol, split : str
        repeat : int
            Number of the split.
        rows : ndarray of int, shape (n,)
        predicted : ndarray, shape (n,)
            In the unit of the target.
        floor : float
            Smallest target of the training rows, see `abradem.learning.scores.score`.
        keep : bool
            Whether to store the predictions as well as the scores.

        Returns
        -------
        dict of str to float
            The scores by metric.
        """
        actual = self.table.target[rows]
        metrics = score(actual, predicted, floor)
        self.add_metrics(model, protocol, split, repeat, metrics)
        if keep:
            self._predictions.append(
                pd.DataFrame(
                    {
                        "model": model,
                        "protocol": protocol,
                        "case_id": self.table.keys[rows],
                        "repeat": repeat,
                        "split": split,
                        "actual": actual,
                        "predicted": predicted,
                        "floor": floor,
                    }
                )
            )
        return metrics

    def add_metrics(
        self, model: str, protocol: str, split: str, repeat: int, metrics: dict[str, float]
    ) -> None:
        """Store scores that were computed elsewhere."""
        self._scores += score_rows(
            metrics,
            model=model,
            protocol=protocol,
            table=self.table.name,
            split=split,
            repeat=repeat,
            target_unit=self.table.unit,
        )

    @property
    def scores(self) -> pd.DataFrame:
        """All scores, with the columns `SCORE_COLUMNS`."""
        return pd.DataFrame(self._scores, columns=SCORE_COLUMNS)

    @property
    def predictions(self) -> pd.DataFrame:
        """All stored predictions, with the columns `PREDICTION_COLUMNS`."""
        if not self._predictions:
            return pd.DataFrame({name: [] for name in PREDICTION_COLUMNS})
        return pd.concat(self._predictions, ignore_index=True)[PREDICTION_COLUMNS]


def with_scalers(fit: Fit, scalers: tuple[Scaler, Scaler] | None = None) -> Fit:
    """Wrap a model that expects standardised variables, so that it takes raw ones.

    Parameters
    ----------
    fit : callable
        The model in standardised variables.
    scalers : pair of Scaler, optional
        Scalers of the features and of the target. By default they are fitted to the rows that
        ``fit`` receives.

    Returns
    -------
    callable
        The model in raw variables.
    """

    def fit_raw(features: np.ndarray, target: np.ndarray, groups: np.ndarray) -> Predict:
        of_features, of_target = scalers or (standard_scaler(features), standard_scaler(target))
        predict = fit(of_features.forward(features), of_target.forward(target), groups)
        return lambda rows: of_target.back(predict(of_features.forward(rows)))

    return fit_raw


def scalers_of_all_rows(table: Table) -> tuple[Scaler, Scaler]:
    """Scalers of features and target fitted to all rows, before the split (as published)."""
    return standard_scaler(table.features), standard_scaler(table.target)


def evaluate_leakage_free(
    results: Results, model: str, fit: Fit, test_share: float, repeats: int, seed: int
) -> None:
    """Score a model on the test rows of repeated splits; it sees training rows only.

    Parameters
    ----------
    results : Results
        Collects the scores and predictions.
    model : str
        Name of the model.
    fit : callable
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    """
    table = results.table
    splits = repeated_splits(table.keys, table.groups, test_share, repeats, seed)
    _evaluate(results, model, LEAKAGE_FREE, fit, splits)


def evaluate_as_published(results: Results, model: str, fit: Fit) -> None:
    """Score a model on the single split of the published protocol."""
    splits = [published_split(len(results.table.target), PUBLISHED_SHARE)]
    _evaluate(results, model, AS_PUBLISHED, fit, splits)


def _evaluate(
    results: Results,
    model: str,
    protocol: str,
    fit: Fit,
    splits: Iterable[tuple[np.ndarray, np.ndarray]],
) -> None:
    x, y = results.table.features, results.table.target
    for repeat, (train, test) in enumerate(splits):
        predict = fit(x[train], y[train], results.table.groups[train])
        floor = float(y[train].min())
        results.add(model, protocol, "train", repeat, train, predict(x[train]), floor, keep=False)
        results.add(model, protocol, "test", repeat, test, predict(x[test]), floor)
