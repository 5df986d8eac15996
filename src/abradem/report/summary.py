"""Headline numbers of a study, with which the report begins."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from abradem.dataset.join import reasons
from abradem.dataset.relative_errors import relative_stderr
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget


def study_summary(
    dataset: pd.DataFrame,
    failures: pd.DataFrame | None,
    linear: Mapping,
    comparison: pd.DataFrame,
    good_r2: float,
    external: str | None = None,
    element_size: float | None = None,
    cells: bool = False,
    part: str | None = None,
) -> dict:
    """Headline numbers of a study.

    Parameters
    ----------
    dataset, failures : pandas.DataFrame
        From `abradem.dataset.join.join`; for an external table there are no failures.
    linear : mapping
        Summary of the linear regression, see `abradem.learning.baselines.linear`.
    comparison : pandas.DataFrame
        From `abradem.learning.comparison.compare`.
    good_r2 : float
        Smallest R2 of a cumulative series that counts as good.
    external : str, optional
        Path of the external table, if the data set was not simulated.
    element_size, cells, part
        Of the target, see `abradem.words.wear.WearTarget`.

    Returns
    -------
    dict
        ``external``, ``cases``, ``target``, ``target_words`` (what the target is; for an external
        table only that it is a wear depth rate), ``wear_range`` (mm/s), ``models`` (leakage-free
        R2 on held-out rows: model, r2, lower, upper, number, the R2 of the logarithm of the wear
        number, basis), ``held_fixed`` (quantities that did
        not vary) and ``misprints`` of the printed equation (None unless the data set is the
        paper's).
        For simulations also the entries of `quality_counts`, with ``cases`` the number of sampled
        cases, ``simulated`` those in the data set, ``failures`` the others, and ``reasons`` the
        number of failures by reason.
    """
    name = linear["target"]["name"]
    target = dataset[name]
    found = {
        "external": external,
        "cases": len(dataset),
        "target": name,
        "target_words": (
            WearTarget(name, element_size, cells=cells, part=part).words
            if external is None
            else LABELS[name].long_name
        ),
        "wear_range": [float(target.min()), float(target.max())],
        "misprints": linear["misprints"],
        "held_fixed": [LABELS[one].long_name for one in linear["held_fixed"]],
        "models": [
            {
                "model": row.model,
                "r2": row.r2,
                "lower": row.r2_lower,
                "upper": row.r2_upper,
                "number": row.r2_number,
                "basis": row.basis,
            }
            for row in comparison[comparison["protocol"] == "leakage_free"]
            .drop_duplicates("model")
            .itertuples(index=False)
        ],
    }
    if failures is None:
        return found
    return {
        **quality_counts(dataset, name, good_r2),
        **found,
        "cases": len(dataset) + len(failures),
        "simulated": len(dataset),
        "failures": len(failures),
        "reasons": reasons(failures),
    }


def quality_counts(rates: pd.DataFrame, target: str, good_r2: float = 0.95) -> dict:
    """Quality of the wear rates of a study.

    Parameters
    ----------
    rates : pandas.DataFrame
        Holds wear_r2, quality, the target and its standard error, as the wear-rate tables and the
        data set do.
    target : str
        A wear-rate column.
    good_r2 : float
        Smallest R2 of a cumulative series that counts as good.

    Returns
    -------
    dict
        ``cases``, ``good_r2`` (the limit), ``cases_with_good_r2``, ``cases_without_flag``,
        ``flags`` (flag -> cases) and ``median_relative_stderr`` (of the positive targets; nan if
        it is not known).
    """
    flags: dict[str, int] = {}
    for text in rates["quality"]:
        for flag in text.split("+"):
            flags[flag] = flags.get(flag, 0) + 1
    unflagged = flags.pop("ok", 0)
    relative = relative_stderr(rates, target)
    relative = relative[np.isfinite(relative)]
    return {
        "cases": len(rates),
        "good_r2": good_r2,
        "cases_with_good_r2": int((rates["wear_r2"] >= good_r2).sum()),
        "cases_without_flag": unflagged,
        "flags": dict(sorted(flags.items())),
        "median_relative_stderr": float(np.median(relative)) if relative.size else np.nan,
    }
