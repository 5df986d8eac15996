"""The models that learn physics: one problem, one protocol, four models, every target.

Each predicts the logarithm of the wear number from dimensionless groups
(`abradem.surrogate.groups`) and multiplies the scale back:

``power_law``           `abradem.learning.physical.power_law`, transparent
``gaussian_process``    `abradem.learning.physical.gaussian_process`, the best; decided beforehand, not by
                        the test rows, and used for intervals, sensitivity and the surrogate
``boosting``, ``networks``  `abradem.learning.physical.ensembles`

Scores are those of the leakage-free protocol, on the same splits as the other models of the study.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.learning.rows import Table, learning_table
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import Jet, group_matrix, wear_scale

STDERR = "wear_total_mean_stderr"
HEADLINE = "wear_total_mean"


class WearProblem(NamedTuple):
    """Rows to learn from, in the order of their case numbers.

    ``inputs`` (n, 14) the sampled quantities, ``groups`` (n, 10), ``scale`` (n,) in mm/s,
    ``log_number`` (n,) logarithm of the wear number, ``error`` (n,) relative standard error of
    the simulation (0 where none is known), ``raised`` how many targets were not positive and
    count as the smallest wear number that is.
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
        """Wear depth rate of rows, mm/s, from the logarithm of the wear number."""
        return self.scale[rows] * np.exp(log_number)


def problem(
    dataset: pd.DataFrame, jet: Jet, target: str = HEADLINE, name: str = "dataset", fewest: int = 3
) -> WearProblem:
    """What the models of this module learn from.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features and ``target``, and of simulations the standard error.
    jet : Jet
    target : str
        A wear-rate column, mm/s.
    name : str
        What the scores call the table.
    fewest : int
        Least number of rows.
    """
    table = learning_table(dataset, target, name, fewest)
    rows = dataset.sort_values("case_id", ignore_index=True)
    columns = {key: rows[key].to_numpy(dtype=float) for key in SAMPLED_NAMES}
    scale = wear_scale(columns, jet)
    number = table.target / scale
    positive = number > 0.0
    if not positive.any():
        raise ValueError(f"dataset: {target} is nowhere positive, there is nothing to learn")
    # What a statistic over facets says of a plate that stays untouched.
    number = np.where(positive, number, number[positive].min())
    error = np.zeros(len(rows))
    if target == HEADLINE and STDERR in rows:
        error = rows[STDERR].to_numpy(dtype=float) / table.target
        error = np.where(np.isfinite(error), error, np.nanmax(error, initial=0.0))
    return WearProblem(
        table,
        np.column_stack([columns[key] for key in SAMPLED_NAMES]),
        group_matrix(columns, jet),
        scale,
        np.log(number),
        error,
        jet,
        int(np.sum(~positive)),
    )
