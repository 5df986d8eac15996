"""The rows that models learn from, and how features and target are scaled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.quantities import FEATURE_NAMES, TARGET
from abradem.store.columns import COLUMNS
from abradem.store.tables import content_hash

FEWEST_ROWS = 8
"""Below this nothing is left to validate on once rows are held out for testing."""


class Table(NamedTuple):
    """Rows in the order of their case numbers.

    ``keys`` (n,), ``features`` (n, 20) in the order of `FEATURE_NAMES`, ``target`` (n,).
    """

    keys: np.ndarray
    features: np.ndarray
    target: np.ndarray
    target_name: str
    unit: str
    name: str
    hash: str


class Scaler(NamedTuple):
    """Mean and standard deviation of rows; a constant column becomes 0.

    The scale of a constant is its own size, so that another value, which no model can have
    learned from, does not become a huge one.
    """

    mean: np.ndarray
    scale: np.ndarray

    def forward(self, values: np.ndarray) -> np.ndarray:
        return (values - self.mean) / self.scale

    def back(self, values: np.ndarray) -> np.ndarray:
        return self.mean + self.scale * values


def learning_table(
    dataset: pd.DataFrame, target: str = TARGET.name, name: str = "dataset", fewest: int = 3
) -> Table:
    """Features and target of a data set, sorted by case, checked.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features and ``target``.
    target : str
        A wear-rate column, mm/s.
    name : str
        What the scores call this table.
    fewest : int
        Least number of rows.

    Raises
    ------
    ValueError
        If the target is missing, a number is not finite, or the rows are too few.
    """
    if target not in dataset:
        raise ValueError(f"dataset: lacks the target {target}")
    dataset = dataset.sort_values("case_id", ignore_index=True)
    x = dataset[list(FEATURE_NAMES)].to_numpy(dtype=float)
    y = dataset[target].to_numpy(dtype=float)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError("dataset: features and target must be finite")
    if len(y) < fewest:
        raise ValueError(f"dataset: {len(y)} rows are too few to learn from, {fewest} are needed")
    return Table(
        keys=dataset["case_id"].to_numpy(),
        features=x,
        target=y,
        target_name=target,
        unit=COLUMNS[target].unit,
        name=name,
        hash=content_hash(dataset[["case_id", *FEATURE_NAMES, target]]),
    )


def constant(features: np.ndarray) -> np.ndarray:
    """Which columns do not vary, shape (p,)."""
    return np.ptp(features, axis=0) <= 1e-12 * np.abs(features).max(axis=0)


def standard_scaler(values: np.ndarray) -> Scaler:
    """Scaler to mean 0 and standard deviation 1 of ``values``, shape (n,) or (n, p)."""
    columns = values.reshape(len(values), -1)
    fixed = constant(columns)
    mean = np.where(fixed, columns[0], columns.mean(axis=0))
    scale = np.where(fixed, np.where(mean == 0.0, 1.0, np.abs(mean)), columns.std(axis=0))
    if values.ndim == 1:
        return Scaler(mean[0], scale[0])
    return Scaler(mean, scale)


def minmax_scaler(values: np.ndarray) -> Scaler:
    """Scaler to the interval from 0 to 1 of ``values``, shape (n, p)."""
    scale = np.where(constant(values), 1.0, np.ptp(values, axis=0))
    return Scaler(values.min(axis=0), scale)
