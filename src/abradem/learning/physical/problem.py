"""The regression problem of the physics-informed models.

All models predict the logarithm of the wear number from dimensionless groups
(`abradem.surrogate.groups`) and multiply by the scale of the wear afterwards:

``power_law``
    `abradem.learning.physical.power_law`, transparent.
``gaussian_process``
    `abradem.learning.physical.gaussian_process`, used for intervals, sensitivity and the
    surrogate. It was chosen beforehand, not by its score on the test rows.
``boosting``, ``networks``
    `abradem.learning.physical.ensembles`.
``stacked``
    Process and boosting, `abradem.learning.physical.stacked`.

They are scored under the leakage-free protocol on the same splits as the other models.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import scales_of, settled, variation
from abradem.learning.rows import Table, learning_table
from abradem.quantities import stderr_column
from abradem.surrogate.groups import Jet, group_matrix, input_names, wear_scale

HEADLINE = "wear_total_mean"

GROUP_SCALE = 1.0
"""Groups are logarithms, an angle in rad or a cosine, so their differences count absolutely."""

LARGEST_LOG = 600.0
"""Largest logarithm of a wear number; beyond it a prediction would overflow."""


class WearProblem(NamedTuple):
    """Rows to learn from, in the order of their case numbers.

    Attributes
    ----------
    table : Table
        Features and target.
    inputs : ndarray, shape (n, 14 and those of a geometry)
        The sampled quantities (`abradem.surrogate.groups.input_names`) in the units of
        `abradem.quantities`, free of float noise where they were held fixed.
    groups : ndarray, shape (n, 10 and those of a geometry)
        The dimensionless groups, likewise.
    scale : ndarray, shape (n,)
        Scale of the wear depth rate, mm/s.
    log_number : ndarray, shape (n,)
        Logarithm of the wear number.
    error : ndarray, shape (n,)
        Relative standard error of the simulation; 0 if the data set does not hold it. Where it is
        not known, or the target is 0, it is the largest of the other rows.
    jet : Jet
    raised : int
        Number of targets that were not positive; their wear number was raised to the smallest
        positive one.
    """

    table: Table
    inputs: np.ndarray
    groups: np.ndarray
    scale: np.ndarray
    log_number: np.ndarray
    error: np.ndarray
    jet: Jet
    raised: int

    def wear(self, rows: np.ndarray, log_number: np.ndarray) -> np.ndarray:
        """Wear depth rate (n,), mm/s, of rows (n,) with a logarithm of the wear number (n,)."""
        return self.scale[rows] * np.exp(np.minimum(log_number, LARGEST_LOG))

    @property
    def variation(self) -> np.ndarray:
        """What the rows say about each sampled quantity, see `abradem.dataset.variation`."""
        return variation(self.inputs, input_names(self.jet))


def problem(
    dataset: pd.DataFrame, jet: Jet, target: str = HEADLINE, name: str = "dataset", fewest: int = 3
) -> WearProblem:
    """Regression problem of a data set.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features, the sampled quantities of a geometry and ``target``;
        simulated data sets also hold its standard error.
    jet : Jet
    target : str
        A wear-rate column, mm/s.
    name : str
        Name of the data set in the scores.
    fewest : int
        Smallest number of rows accepted.

    Raises
    ------
    ValueError
        If no target is positive, or the data set is refused by `learning_table`.
    """
    table = learning_table(dataset, target, name, fewest)
    rows = dataset.sort_values("case_id", ignore_index=True)
    names = input_names(jet)
    sampled = np.column_stack([rows[key].to_numpy(dtype=float) for key in names])
    sampled = settled(sampled, scales_of(names))
    columns = {key: sampled[:, place].copy() for place, key in enumerate(names)}
    scale = wear_scale(columns, jet)
    number = table.target / scale
    positive = number > 0.0
    if not positive.any():
        raise ValueError(f"dataset: {target} is nowhere positive, there is nothing to learn")
    # Statistics over facets, such as p99, are 0 if most facets are not hit.
    number = np.where(positive, number, number[positive].min())
    error = np.zeros(len(rows))
    if stderr_column(target) in rows:
        stated = rows[stderr_column(target)].to_numpy(dtype=float)
        known = positive & np.isfinite(stated)
        error[known] = stated[known] / table.target[known]
        error[~known] = error[known].max(initial=0.0)
    return WearProblem(
        table,
        sampled,
        settled(group_matrix(columns, jet), GROUP_SCALE),
        scale,
        np.log(number),
        error,
        jet,
        int(np.sum(~positive)),
    )
