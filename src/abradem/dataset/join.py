"""Join of cases, features, wear rates and runs into the data set, and the checks of the data set.

Units and types of all columns are in `abradem.store.columns.COLUMNS`.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.dataset.features import derive
from abradem.quantities import (
    FEATURE_NAMES,
    GEOMETRY_NAMES,
    SAMPLED,
    STATISTICS,
    STDERR_COLUMNS,
    WEAR_COLUMNS,
    wear_column,
)
from abradem.store.columns import COLUMNS, KEYS
from abradem.store.files import TableError

DATASET_COLUMNS: tuple[str, ...] = (
    *KEYS,
    *FEATURE_NAMES,
    *WEAR_COLUMNS,
    *STDERR_COLUMNS,
    "wear_r2",
    "steady_from",
    "simulated_time",
    "delivered_rate",
    "face_share",
    "status",
    "worn_volume_rate",
    "wear_per_kg",
    "quality",
)
"""Columns of ``dataset.parquet``, in order. Quantities of a geometry that were sampled follow."""

FAILURE_COLUMNS: tuple[str, ...] = ("case_id", "status", "simulated_time")
"""Columns of ``failures.parquet``, in order."""


# Only the plate-mean total depth rate must be positive: a few large particles leave most facets
# untouched (p99 = 0), and sliding is zero if particles stick during the whole contact.
_POSITIVE = (
    "particle_shear_modulus",
    "equipment_shear_modulus",
    "particle_density",
    "equipment_density",
    "restitution",
    "archard_constant",
    "particle_radius",
    "simulated_time",
    "delivered_rate",
    "wear_total_mean",
)
_NOT_NEGATIVE = (
    "particle_poisson_ratio",
    "equipment_poisson_ratio",
    "rolling_friction",
    "static_friction",
    *STDERR_COLUMNS,
    *(wear_column("total", statistic) for statistic in STATISTICS if statistic != "mean"),
    *(wear_column("sliding", statistic) for statistic in STATISTICS),
)


def join(
    cases: pd.DataFrame,
    rates: pd.DataFrame,
    runs: pd.DataFrame,
    damping_coefficient: str = "table",
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Join cases, features, wear rates and runs, one row per case.

    Parameters
    ----------
    cases : pandas.DataFrame
        case_id, block, seed, the 14 sampled columns (SI), those of a geometry that were sampled,
        and optionally ``rejected``.
    rates : pandas.DataFrame
        From `abradem.wear.rates.wear_rates`, for all batches.
    runs : pandas.DataFrame
        One row per simulated or rejected case.
    damping_coefficient : {"table", "printed"}
        See `abradem.dataset.features.derive`.

    Returns
    -------
    dataset : pandas.DataFrame
        `DATASET_COLUMNS`, and the sampled quantities of a geometry, of the successful cases with a
        wear rate, by case_id.
    failures : pandas.DataFrame
        `FAILURE_COLUMNS` of all other cases: rejected, ended early, never steady, without wear,
        with a value that is not finite, or not simulated.

    Raises
    ------
    TableError
        If a case appears twice in a table, or a run does not belong to the study.
    """
    for name, frame in (("cases", cases), ("wear rates", rates), ("runs", runs)):
        _require_unique(name, frame)
    strangers = sorted(set(runs["case_id"]) - set(cases["case_id"]))
    if strangers:
        raise TableError(f"runs: case {strangers[0]} does not belong to this study")

    features = derive(cases, damping_coefficient)
    keys = cases[list(KEYS)].reset_index(drop=True)
    rejected = cases["rejected"] if "rejected" in cases else pd.Series("", index=cases.index)
    table = pd.concat([keys, features[list(FEATURE_NAMES)].reset_index(drop=True)], axis=1)
    shape = [name for name in GEOMETRY_NAMES if name in cases]
    table[shape] = cases[shape].to_numpy()
    table["rejected"] = rejected.fillna("").astype(str).to_numpy()
    run_columns = [
        "case_id", "status", "steady_from", "simulated_time", "delivered_rate", "face_share",
    ]  # fmt: skip
    rate_columns = [
        "case_id", *WEAR_COLUMNS, *STDERR_COLUMNS, "wear_r2", "worn_volume_rate", "wear_per_kg",
        "quality",
    ]  # fmt: skip
    table = table.merge(runs[run_columns], on="case_id", how="left", validate="1:1")
    table = table.merge(rates[rate_columns], on="case_id", how="left", validate="1:1")
    table = table.sort_values("case_id", ignore_index=True)

    numbers = [name for name in DATASET_COLUMNS if COLUMNS[name].dtype == "float64"]
    finite = np.isfinite(table[numbers].to_numpy(dtype=float))
    odd = ["" if row.all() else numbers[int(np.argmin(row))] for row in finite]
    status = [
        _failure(*row)
        for row in zip(
            table["rejected"], table["status"], table["wear_total_mean"], odd, strict=True
        )
    ]
    table["status"] = [word or "ok" for word in status]
    good = np.array([not word for word in status], dtype=bool)
    dataset = table.loc[good, [*DATASET_COLUMNS, *shape]].reset_index(drop=True)
    failures = table.loc[~good, list(FAILURE_COLUMNS)].reset_index(drop=True)
    failures["simulated_time"] = failures["simulated_time"].fillna(0.0)
    return dataset, failures


def check_failures(dataset: pd.DataFrame, failures: pd.DataFrame, most: float) -> None:
    """Raise `TableError` if the share of failed cases is too large.

    Parameters
    ----------
    dataset, failures : pandas.DataFrame
        From `join`.
    most : float
        Largest share of the cases that may fail.
    """
    cases = len(dataset) + len(failures)
    if len(failures) > most * cases:
        counted = ", ".join(f"{count} {kind}" for kind, count in reasons(failures).items())
        first = failures.iloc[0]
        raise TableError(
            f"dataset: {len(failures)} of {cases} cases failed ({counted}), more than "
            f"simulation.max_failed_share = {most:g} allows; case {first['case_id']}: "
            f"{first['status']}; failures.parquet lists all"
        )


def reasons(failures: pd.DataFrame) -> dict[str, int]:
    """Return the number of failed cases by kind of reason, the most frequent first."""
    kinds = failures["status"].str.split(":").str[0]
    return {kind: int(count) for kind, count in kinds.value_counts().items()}


def check(dataset: pd.DataFrame) -> None:
    """Raise `TableError` with one line per problem if ``dataset`` is not valid for learning.

    In a valid data set all columns are present, keys are unique, all numbers are finite, positive
    where required, and sampled quantities are within their physical limits.
    """
    missing = [name for name in DATASET_COLUMNS if name not in dataset]
    if missing:
        raise TableError(f"dataset: lacks column {', '.join(missing)}")
    if dataset.empty:
        raise TableError("dataset: no case was successful, see failures.parquet")
    problems = []
    twice = dataset["case_id"][dataset["case_id"].duplicated()]
    if not twice.empty:
        problems.append(f"dataset: case {twice.iloc[0]} appears more than once")
    numeric = [n for n in DATASET_COLUMNS if COLUMNS[n].dtype.startswith(("float", "int"))]
    for name in numeric:
        values = dataset[name].to_numpy(dtype=float)
        problems += _first_bad(dataset, name, ~np.isfinite(values), "must be finite")
        if name in _POSITIVE:
            problems += _first_bad(dataset, name, values <= 0.0, "must be positive")
        elif name in _NOT_NEGATIVE:
            problems += _first_bad(dataset, name, values < 0.0, "must not be negative")
    for row in SAMPLED:
        values = dataset[row.name].to_numpy(dtype=float)
        low, high = row.limits
        problems += _first_bad(
            dataset,
            row.name,
            (values < low) | (values > high),
            f"must lie in [{low:g}, {high:g}] {row.unit}",
        )
    if problems:
        raise TableError("\n".join(problems))


def _failure(rejected: str, status, rate: float, odd: str) -> str:
    """Return the reason why a case is not a row of the data set, or "" if it is one.

    ``odd`` is the first column of its row that is not finite, or "".
    """
    if rejected:
        return f"rejected: {rejected}"
    if not isinstance(status, str):
        return "not simulated"
    if status != "ok":
        return status
    if not np.isfinite(rate):
        return "no wear rate: no steady state reached"
    if rate <= 0.0:
        return "no wear: nothing met the plate"
    if odd:
        return f"no finite {odd}"
    return ""


def _first_bad(dataset: pd.DataFrame, name: str, bad: np.ndarray, law: str) -> list[str]:
    """Return one line for a column with rows that violate a condition, naming the first row."""
    if not bad.any():
        return []
    row = dataset.iloc[int(np.argmax(bad))]
    unit = "" if COLUMNS[name].unit == "1" else f" {COLUMNS[name].unit}"
    more = "" if bad.sum() == 1 else f" (and in {int(bad.sum()) - 1} more)"
    return [f"dataset: case {row['case_id']}: {name} = {row[name]}{unit} {law}{more}"]


def _require_unique(name: str, frame: pd.DataFrame) -> None:
    twice = frame["case_id"][frame["case_id"].duplicated()]
    if not twice.empty:
        raise TableError(f"{name}: case {twice.iloc[0]} appears twice")
