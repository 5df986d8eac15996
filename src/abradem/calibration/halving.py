"""Successive halving: the set-ups that agree best get more rows and replicates.

All rungs simulate the same time, because extremes such as the worst element depend on it. The
window can be an unknown like any other.

After Jamieson & Talwalkar (2016, Non-stochastic best arm identification and hyperparameter
optimization, AISTATS). A set-up is judged by its best reading: the measure, statistic and element
size with the highest score.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.calibration.agreement import COMBINATION


class Rung(NamedTuple):
    """One round of the search.

    Attributes
    ----------
    trials : int
        Number of set-ups.
    rows : int
        Number of rows of the table, the first of `abradem.calibration.rows.arranged_rows`.
    replicates : int
        Simulations of each row.
    """

    trials: int
    rows: int
    replicates: int


def rungs(
    trials: int,
    keep: float,
    rows: Sequence[int],
    replicates: Sequence[int],
) -> list[Rung]:
    """Return the rounds of a search; from each round the share ``keep`` of the set-ups goes on."""
    return [
        Rung(max(1, round(trials * keep**place)), *values)
        for place, values in enumerate(zip(rows, replicates, strict=True))
    ]


def best_readings(scores: pd.DataFrame, by: str) -> pd.DataFrame:
    """Return the best reading of each trial, the best trial first.

    Readings with a missing simulation or an undefined score are not considered. Of equal scores
    the first in the order of `COMBINATION` is taken.

    Parameters
    ----------
    scores : pandas.DataFrame
        From `abradem.calibration.agreement.scored`.
    by : str
        The score that decides.
    """
    fine = scores[scores[by].notna() & (scores["missing"] == 0)]
    ordered = fine.assign(order=-fine[by]).sort_values(["order", *COMBINATION], kind="stable")
    return ordered.drop(columns="order").drop_duplicates("trial").reset_index(drop=True)


def survivors(scores: pd.DataFrame, by: str, count: int) -> list[int]:
    """Return the numbers of the ``count`` best trials, the best first.

    Raises
    ------
    ValueError
        If no trial has a score.
    """
    best = best_readings(scores, by)
    if best.empty:
        reasons = int(scores["missing"].sum())
        raise ValueError(
            f"no set-up of the search has a {by} on all {int(scores['rows'].max())} rows "
            f"({reasons} simulations without a wear rate); allow more time or other set-ups"
        )
    return [int(trial) for trial in best["trial"].head(count)]


def combination(row: Mapping) -> dict:
    """Return the reading of a row of scores as plain values."""
    size = float(row["element_size"])
    return {
        "measure": str(row["measure"]),
        "statistic": str(row["statistic"]),
        "element_size": None if np.isnan(size) else size,
    }
