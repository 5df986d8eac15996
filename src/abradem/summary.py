"""The numbers that a report on a study begins with."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from abradem import wear_rate
from abradem.parameters import TARGET


def summarise(
    dataset: pd.DataFrame, failures: pd.DataFrame, linear: Mapping, good_r2: float
) -> dict:
    """Headline numbers of a study.

    Parameters
    ----------
    dataset, failures : pandas.DataFrame
        From `abradem.dataset.join`.
    linear : mapping
        Summary of the linear regression, see `abradem.learning.linear`.
    good_r2 : float
        R2 of a cumulative series from which it counts as good.

    Returns
    -------
    dict
        What `abradem.wear_rate.summary` says, with ``cases`` those drawn, ``simulated`` those
        in the data set, ``failures`` the others, ``wear_range`` (mm/s), and ``linear_r2``, the
        median R2 of the linear regression on held-out cases, None if undefined.
    """
    target = dataset[TARGET.name]
    return {
        **wear_rate.summary(dataset, good_r2),
        "cases": len(dataset) + len(failures),
        "simulated": len(dataset),
        "failures": len(failures),
        "wear_range": [float(target.min()), float(target.max())],
        "linear_r2": linear["scores"].get("test", {}).get("R2", {}).get("median"),
    }
