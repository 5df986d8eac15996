"""The rows that models learn from, and the scaling of features and target."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import held_fixed, scales_of, settled, variation
from abradem.learning.repeated_rows import groups_of_rows
from abradem.quantities import FEATURE_NAMES, GEOMETRY_NAMES, TARGET
from abradem.store.columns import COLUMNS
from abradem.store.tables import content_hash

FEWEST_ROWS = 8
"""Smallest data set that leaves rows for validation after some are held out for testing."""

FEWEST_TRAINED = 4
"""Smallest number of training rows of a split: two folds of two rows."""


HUGE = 1e100
"""Magnitude above which squares are computed in a unit of this magnitude, as they overflow."""

NOTHING_VARIED = "dataset: all quantities were held fixed, there is nothing to learn"


class Table(NamedTuple):
    """Features and target, in the order of the case numbers.

    Attributes
    ----------
    keys : ndarray, shape (n,)
        Case numbers.
    features : ndarray, shape (n, 20 and those of a geometry)
        In the order of ``names`` and in the units of `abradem.quantities`. Features that were held
        fixed have exactly the same value in all rows.
    groups : ndarray of int, shape (n,)
        Group of each row; rows of a group repeat one another, see
        `abradem.learning.repeated_rows.groups_of_rows`.
    target : ndarray, shape (n,)
    target_name, unit : str
    name : str
        Name of the data set in the scores.
    hash : str
        Hash of the rows.
    names : tuple of str
        `FEATURE_NAMES`, and the sampled quantities of a geometry.
    """

    keys: np.ndarray
    features: np.ndarray
    groups: np.ndarray
    target: np.ndarray
    target_name: str
    unit: str
    name: str
    hash: str
    names: tuple[str, ...] = FEATURE_NAMES

    @property
    def variation(self) -> np.ndarray:
        """What the rows say about each feature of a linear model, by `variation`."""
        return variation(self.features, self.names, linear=True)

    @property
    def varied(self) -> np.ndarray:
        """Column numbers of the features that were not held fixed."""
        return np.flatnonzero(~held_fixed(self.features))


class Scaler(NamedTuple):
    """Linear scaling of columns, (values - mean) / scale; a constant column becomes 0.

    A constant column is scaled by its absolute value. Other values of it, which no model has seen
    in training, are then not scaled to huge numbers.

    Attributes
    ----------
    mean, scale : ndarray, shape (p,) or ()
    """

    mean: np.ndarray | np.float64
    scale: np.ndarray | np.float64

    def forward(self, values: np.ndarray) -> np.ndarray:
        """Scale values."""
        return (values - self.mean) / self.scale

    def back(self, values: np.ndarray) -> np.ndarray:
        """Undo `forward`."""
        return self.mean + self.scale * values


def learning_table(
    dataset: pd.DataFrame, target: str = TARGET.name, name: str = "dataset", fewest: int = 3
) -> Table:
    """Features and target of a data set, checked and sorted by case.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features, the sampled quantities of a geometry and ``target``.
    target : str
        A wear-rate column, mm/s.
    name : str
        Name of the data set in the scores.
    fewest : int
        Smallest number of rows accepted.

    Raises
    ------
    ValueError
        If the target is missing, a value is not finite, there are too few rows, or no feature
        varies.
    """
    if target not in dataset:
        raise ValueError(f"dataset: lacks the target {target}")
    dataset = dataset.sort_values("case_id", ignore_index=True)
    names = (*FEATURE_NAMES, *(name for name in GEOMETRY_NAMES if name in dataset))
    x = dataset[list(names)].to_numpy(dtype=float)
    y = dataset[target].to_numpy(dtype=float)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError("dataset: features and target must be finite")
    if len(y) < fewest:
        raise ValueError(f"dataset: {len(y)} rows are too few to learn from, {fewest} are needed")
    x = settled(x, scales_of(names))
    if held_fixed(x).all():
        raise ValueError(NOTHING_VARIED)
    return Table(
        keys=dataset["case_id"].to_numpy(),
        features=x,
        groups=groups_of_rows(x),
        target=y,
        target_name=target,
        unit=COLUMNS[target].unit,
        name=name,
        hash=content_hash(dataset[["case_id", *names, target]]),
        names=names,
    )


def standard_scaler(values: np.ndarray) -> Scaler:
    """Scaler to mean 0 and standard deviation 1, for ``values`` of shape (n,) or (n, p)."""
    columns = values.reshape(len(values), -1)
    fixed = held_fixed(columns)
    mean = np.where(fixed, columns[0], columns.mean(axis=0))
    scale = np.where(fixed, np.where(mean == 0.0, 1.0, np.abs(mean)), _deviation(columns))
    if values.ndim == 1:
        return Scaler(mean[0], scale[0])
    return Scaler(mean, scale)


def minmax_scaler(values: np.ndarray) -> Scaler:
    """Scaler to the interval from 0 to 1, for ``values`` of shape (n, p)."""
    scale = np.where(held_fixed(values), 1.0, np.ptp(values, axis=0))
    return Scaler(values.min(axis=0), scale)


def _deviation(columns: np.ndarray) -> np.ndarray:
    """Standard deviation of each column, also where its square overflows."""
    size = np.abs(columns).max(axis=0)
    unit = np.where((size > HUGE) | ((size > 0.0) & (size < 1.0 / HUGE)), size, 1.0)
    return unit * (columns / unit).std(axis=0)
