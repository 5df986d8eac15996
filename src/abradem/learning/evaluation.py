"""Fit a model on the training rows of each split and score it on the rows held out.

A model is a function ``fit(features, target) -> predict`` with ``predict(features)``, arrays in
and arrays out. `with_scalers` wraps one that wants standardised variables.
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
Fit = Callable[[np.ndarray, np.ndarray], Predict]

PREDICTION_COLUMNS = [
    "model", "protocol", "case_id", "repeat", "split", "actual", "predicted",
]  # fmt: skip


class Results:
    """Scores and predictions of held-out rows, gathered over models, protocols and splits."""

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
        """Score predictions of ``rows``; ``keep`` also stores the predictions."""
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
                    }
                )
            )
        return metrics

    def add_metrics(
        self, model: str, protocol: str, split: str, repeat: int, metrics: dict[str, float]
    ) -> None:
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
        return pd.DataFrame(self._scores, columns=SCORE_COLUMNS)

    @property
    def predictions(self) -> pd.DataFrame:
        if not self._predictions:
            return pd.DataFrame({name: [] for name in PREDICTION_COLUMNS})
        return pd.concat(self._predictions, ignore_index=True)[PREDICTION_COLUMNS]


def with_scalers(fit: Fit, scalers: tuple[Scaler, Scaler] | None = None) -> Fit:
    """A model in standardised variables, for raw ones.

    Parameters
    ----------
    fit : callable
    scalers : pair of Scaler, optional
        Of features and target; if not given they are fitted on the rows that ``fit`` gets.
    """

    def fit_raw(features: np.ndarray, target: np.ndarray) -> Predict:
        of_features, of_target = scalers or (standard_scaler(features), standard_scaler(target))
        predict = fit(of_features.forward(features), of_target.forward(target))
        return lambda rows: of_target.back(predict(of_features.forward(rows)))

    return fit_raw


def scalers_of_all_rows(table: Table) -> tuple[Scaler, Scaler]:
    """The scalers of the protocol as published: fitted before the split."""
    return standard_scaler(table.features), standard_scaler(table.target)


def evaluate_leakage_free(
    results: Results, model: str, fit: Fit, test_share: float, repeats: int, seed: int
) -> None:
    """Score ``fit`` on the test rows of repeated splits; it sees training rows alone."""
    table = results.table
    splits = repeated_splits(table.keys, test_share, repeats, seed)
    _evaluate(results, model, LEAKAGE_FREE, fit, splits)


def evaluate_as_published(results: Results, model: str, fit: Fit) -> None:
    """Score ``fit`` on the one split as published."""
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
        predict = fit(x[train], y[train])
        floor = float(y[train].min())
        results.add(model, protocol, "train", repeat, train, predict(x[train]), floor, keep=False)
        results.add(model, protocol, "test", repeat, test, predict(x[test]), floor)
