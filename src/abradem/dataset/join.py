"""Tables in and out: Parquet with units in the field metadata, the join, the checks.

One dictionary, `COLUMNS`, says for every column of every table its unit, its type and what it
is. `write_table` takes no column that is not in it, so that no number is ever stored without
its unit. Files are written under a temporary name and renamed, hence complete or absent, and
the same table gives the same bytes.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.dataset.features import derive
from abradem.quantities import FEATURE_NAMES, SAMPLED, STATISTICS, WEAR_COLUMNS, wear_column
from abradem.store.columns import COLUMNS, KEYS
from abradem.store.files import TableError

DATASET_COLUMNS: tuple[str, ...] = (
    *KEYS,
    *FEATURE_NAMES,
    *WEAR_COLUMNS,
    "wear_total_mean_stderr",
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
"""Columns of ``dataset.parquet``, in order."""

FAILURE_COLUMNS: tuple[str, ...] = ("case_id", "status", "simulated_time")
"""Columns of ``failures.parquet``, in order."""


# Of the depth rates only the headline must exceed zero: few large particles leave most facets
# untouched (p99 = 0), and sliding vanishes where particles stick from first touch to last.
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
    "wear_total_mean_stderr",
    *(wear_column("total", statistic) for statistic in STATISTICS if statistic != "mean"),
    *(wear_column("sliding", statistic) for statistic in STATISTICS),
)


def join(
    cases: pd.DataFrame,
    rates: pd.DataFrame,
    runs: pd.DataFrame,
    damping_coefficient: str = "table",
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Bring cases, features, wear rates and runs together, one row per case.

    Parameters
    ----------
    cases : pandas.DataFrame
        case_id, block, seed, the 14 sampled columns (SI) and optionally ``rejected``.
    rates : pandas.DataFrame
        From `abradem.wear.rates.wear_rates`, of all batches.
    runs : pandas.DataFrame
        One row per case simulated or rejected.
    damping_coefficient : {"table", "printed"}
        See `abradem.dataset.features.derive`.

    Returns
    -------
    dataset : pandas.DataFrame
        `DATASET_COLUMNS`, the cases that ended well and have a wear rate, by case_id.
    failures : pandas.DataFrame
        `FAILURE_COLUMNS`, all other cases: rejected, ended early, never steady, without wear,
        with a number that is not finite, not simulated.
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
    table["rejected"] = rejected.fillna("").astype(str).to_numpy()
    run_columns = [
        "case_id", "status", "steady_from", "simulated_time", "delivered_rate", "face_share",
    ]  # fmt: skip
    rate_columns = [
        "case_id", *WEAR_COLUMNS, "wear_total_mean_stderr", "wear_r2", "worn_volume_rate",
        "wear_per_kg", "quality",
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
    dataset = table.loc[good, list(DATASET_COLUMNS)].reset_index(drop=True)
    failures = table.loc[~good, list(FAILURE_COLUMNS)].reset_index(drop=True)
    failures["simulated_time"] = failures["simulated_time"].fillna(0.0)
    return dataset, failures


def check_failures(dataset: pd.DataFrame, failures: pd.DataFrame, most: float) -> None:
    """Raise `TableError` if more cases failed than a study can do without.

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
            f"{first['status']}; failures.parquet holds all"
        )


def reasons(failures: pd.DataFrame) -> dict[str, int]:
    """How many cases failed for each kind of reason, the most frequent first."""
    kinds = failures["status"].str.split(":").str[0]
    return {kind: int(count) for kind, count in kinds.value_counts().items()}


def check(dataset: pd.DataFrame) -> None:
    """Raise `TableError` with one line per problem unless ``dataset`` is fit to learn from.

    Columns complete, keys unique, every number finite, positive where it must be, sampled
    quantities within physical limits.
    """
    missing = [name for name in DATASET_COLUMNS if name not in dataset]
    if missing:
        raise TableError(f"dataset: lacks column {', '.join(missing)}")
    if dataset.empty:
        raise TableError("dataset: no case ended well, see failures.parquet")
    problems = []
    twice = dataset["case_id"][dataset["case_id"].duplicated()]
    if not twice.empty:
        problems.append(f"dataset: case {twice.iloc[0]} stands {1 + len(twice)} times or more")
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
    """Why a case is no row of the dataset, or "" if it is one.

    ``odd`` is the first column of its row that is not finite, if any.
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
    """One line for a column with rows that break a law, naming the first of them."""
    if not bad.any():
        return []
    row = dataset.iloc[int(np.argmax(bad))]
    unit = "" if COLUMNS[name].unit == "1" else f" {COLUMNS[name].unit}"
    more = "" if bad.sum() == 1 else f" (and in {int(bad.sum()) - 1} more)"
    return [f"dataset: case {row['case_id']}: {name} = {row[name]}{unit} {law}{more}"]


def _require_unique(name: str, frame: pd.DataFrame) -> None:
    twice = frame["case_id"][frame["case_id"].duplicated()]
    if not twice.empty:
        raise TableError(f"{name}: case {twice.iloc[0]} stands twice")
