"""The numbers that a report on a study begins with."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from abradem import wear_rate
from abradem.dataset import reasons


def summarise(
    dataset: pd.DataFrame,
    failures: pd.DataFrame | None,
    linear: Mapping,
    comparison: pd.DataFrame,
    good_r2: float,
    external: str | None = None,
) -> dict:
    """Headline numbers of a study.

    Parameters
    ----------
    dataset, failures : pandas.DataFrame
        From `abradem.dataset.join`; of an external table there are no failures.
    linear : mapping
        Summary of the linear regression, see `abradem.learning.linear`.
    comparison : pandas.DataFrame
        From `abradem.learning.comparison.compare`.
    good_r2 : float
        R2 of a cumulative series from which it counts as good.
    external : str, optional
        Where the table came from, if it was not simulated.

    Returns
    -------
    dict
        ``external``, ``cases``, ``wear_range`` (mm/s), ``models`` (R2 on held-out rows, honest:
        model, r2, lower, upper, basis), ``misprints`` of the printed equation (None unless the
        table is the paper's) and, of simulations, what `abradem.wear_rate.summary` says, with
        ``cases`` those drawn, ``simulated`` those in the data set, ``failures`` the others and
        ``reasons`` how many of them for each kind of reason.
    """
    target = dataset[linear["target"]["name"]]
    found = {
        "external": external,
        "cases": len(dataset),
        "target": linear["target"]["name"],
        "wear_range": [float(target.min()), float(target.max())],
        "misprints": linear["misprints"],
        "models": [
            {
                "model": row.model,
                "r2": row.r2,
                "lower": row.r2_lower,
                "upper": row.r2_upper,
                "basis": row.basis,
            }
            for row in comparison[comparison["protocol"] == "honest"]
            .drop_duplicates("model")
            .itertuples(index=False)
        ],
    }
    if failures is None:
        return found
    return {
        **wear_rate.summary(dataset, good_r2),
        **found,
        "cases": len(dataset) + len(failures),
        "simulated": len(dataset),
        "failures": len(failures),
        "reasons": reasons(failures),
    }
