"""Tables in and out: Parquet with units in the field metadata, the join, the checks.

One dictionary, `COLUMNS`, says for every column of every table its unit, its type and what it
is. `write_table` takes no column that is not in it, so that no number is ever stored without
its unit. Files are written under a temporary name and renamed, hence complete or absent, and
the same table gives the same bytes.
"""

from __future__ import annotations

import contextlib
import glob
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from abradem.features import derive
from abradem.parameters import (
    FEATURE_NAMES,
    QUANTITIES,
    READINGS,
    SAMPLED,
    STATISTICS,
    TARGET,
)


class TableError(ValueError):
    """A table that cannot be written, read or used; the message is one line per problem."""


@dataclass(frozen=True)
class Column:
    """What a column holds.

    Parameters
    ----------
    unit : str
        "1" where dimensionless or text.
    long_name : str
        What it is, in words.
    dtype : {"float64", "int64", "int32", "bool", "string"}
    """

    unit: str
    long_name: str
    dtype: str = "float64"


_READING_WORDS = {
    "total": "all tangential motion under load",
    "sliding": "sliding while Coulomb's limit is active",
    "friction": "friction work over the coefficient of friction",
}
_STATISTIC_WORDS = {
    "mean": "mean over the plate",
    "footprint": "mean over the footprint",
    "p99": "99th percentile of facets",
    "max": "worst facet",
}


def wear_column(reading: str, statistic: str) -> str:
    """Name of the depth rate of a reading and a statistic over the plate."""
    return f"wear_{reading}_{statistic}"


WEAR_COLUMNS: tuple[str, ...] = tuple(
    wear_column(reading, statistic) for reading in READINGS for statistic in STATISTICS
)

_KEYS = {
    "case_id": Column("1", "number of the case in the study", "int64"),
    "block": Column("1", "block of the sample the case belongs to", "int32"),
    "seed": Column("1", "seed of the released positions", "int64"),
}

_CASES = {"rejected": Column("1", "why the case is physically inconsistent, or empty", "string")}

_SERIES = {
    "time": Column("s", "simulated time"),
    "worn_total": Column("J", "cumulative normal force times distance of all tangential motion"),
    "worn_sliding": Column("J", "cumulative normal force times sliding distance"),
    "worn_friction": Column("J", "cumulative friction work over the coefficient of friction"),
    "delivered_mass": Column("kg", "cumulative mass released"),
    "particles_present": Column("1", "particles present", "int32"),
}

_MAPS = {
    "facet_x": Column("1", "facet index along the plate's length", "int32"),
    "facet_z": Column("1", "facet index along the plate's width", "int32"),
    **{
        f"wear_{reading}": Column(
            "J", f"normal force times distance in the window ({_READING_WORDS[reading]})"
        )
        for reading in READINGS
    },
}

_RUNS = {
    "settled": Column("1", "whether wear rate and particles present had stopped to drift", "bool"),
    "status": Column("1", "ok, or why the case ended early", "string"),
    "simulated_time": Column("s", "simulated time at the end"),
    "steady_from": Column("s", "end of the transient"),
    "window_start": Column("s", "start of the window over which facets are compared"),
    "window_end": Column("s", "end of the window over which facets are compared"),
    "stderr": Column("1", "relative standard error of the mean wear rate at the stop"),
    "time_step": Column("s", "time step"),
    "requested_rate": Column("kg/s", "feed asked for"),
    "delivered_rate": Column("kg/s", "feed achieved"),
    "face_share": Column("1", "share of first contacts on the plate's face"),
    "edge_share": Column("1", "share of first contacts on an edge or corner"),
    "missed_share": Column("1", "share of particles that left without a contact"),
    "max_overlap": Column("1", "largest overlap as a share of the radius"),
    "released": Column("1", "particles released", "int64"),
    "removed": Column("1", "particles removed", "int64"),
}

_TIMES = {"processor_time": Column("s", "processor time that the case took")}

_WEAR_RATES = {
    **{
        wear_column(reading, statistic): Column(
            "mm/s",
            f"wear depth rate, {_STATISTIC_WORDS[statistic]} ({_READING_WORDS[reading]})",
        )
        for reading in READINGS
        for statistic in STATISTICS
    },
    "wear_total_mean_stderr": Column("mm/s", "standard error of the plate-mean wear depth rate"),
    "wear_r2": Column("1", "R2 of the cumulative wear against a straight line (description)"),
    "wear_batches": Column("1", "batches of increments behind the standard error", "int32"),
    "wear_lag1": Column("1", "lag-1 correlation of the batches"),
    "worn_volume_rate": Column("m3/s", "worn volume of the whole plate per time"),
    "wear_per_kg": Column("m3/kg", "worn volume per mass delivered"),
    "quality": Column("1", "ok, or the flags of the case joined by +", "string"),
}

_LEARNING = {
    "model": Column("1", "model", "string"),
    "protocol": Column("1", "protocol of training and evaluation", "string"),
    "table": Column("1", "table learned from", "string"),
    "split": Column("1", "kind of rows evaluated", "string"),
    "repeat": Column("1", "number of the random split, -1 for all rows", "int32"),
    "metric": Column("1", "metric", "string"),
    "value": Column("1", "value of the metric, in the unit that the column unit names"),
    "unit": Column("1", "unit of the value", "string"),
    "symbol": Column("1", "symbol of the feature", "string"),
    "feature": Column("1", "feature", "string"),
    "coefficient": Column("1", "coefficient between standardised feature and target"),
    "standard_error": Column("1", "standard error of the coefficient"),
    "lower": Column("1", "lower end of the interval"),
    "upper": Column("1", "upper end of the interval"),
    "identified": Column("1", "whether the rows determine this coefficient", "bool"),
    "actual": Column(TARGET.unit, "simulated wear depth rate"),
    "predicted": Column(TARGET.unit, "predicted wear depth rate"),
    "variance_inflation": Column("1", "variance inflation factor"),
    "fitted": Column("1", "fitted target, in its standard deviations"),
    "residual": Column("1", "residual, in standard deviations of the target"),
    "leverage": Column("1", "leverage of the row"),
    "studentised": Column("1", "residual over its own standard error"),
    "normal_quantile": Column("1", "quantile of the normal distribution at the residual's rank"),
    "printed": Column("1", "coefficient as printed"),
    "refitted": Column("1", "coefficient by the same steps"),
    "verdict": Column("1", "whether print and refit agree", "string"),
    "weight": Column("1", "weight between standardised feature and target"),
    "survives": Column("1", "share of the fits in which the feature stays"),
    "alpha": Column("1", "penalty"),
    "mean": Column("1", "mean R2 over the folds"),
    "stderr_of_mean": Column("1", "standard error of that mean"),
    "chosen": Column("1", "whether this one was chosen", "bool"),
    "component": Column("1", "principal component", "int32"),
    "components": Column("1", "number of principal components", "int32"),
    "loading": Column("1", "loading of the feature on the component"),
    "correlation": Column("1", "Pearson correlation"),
    "other": Column("1", "the other quantity", "string"),
    "variance": Column("1", "variance along the component, of scaled features"),
    "share": Column("1", "share of the variance"),
    "cumulative": Column("1", "share of the variance up to this component"),
    "explained": Column("1", "what the regression explains", "string"),
    "r2": Column("1", "R2"),
    "r2_lower": Column("1", "lower end of the interval of R2"),
    "r2_upper": Column("1", "upper end of the interval of R2"),
    "lasso_weight": Column("1", "standardised weight of the lasso"),
    "ridge_weight": Column("1", "standardised weight of the ridge regression"),
    "leading_share": Column("1", "share in the leading principal components"),
    "chosen_by": Column("1", "weight, loading, or empty if not chosen", "string"),
    "in_paper": Column("1", "whether the study chose the feature", "bool"),
    "depth": Column("1", "largest depth of the tree", "int32"),
    "node": Column("1", "number of the node", "int32"),
    "parent": Column("1", "node above, -1 at the root", "int32"),
    "left": Column("1", "node where feature <= threshold, -1 at a leaf", "int32"),
    "right": Column("1", "node where feature > threshold, -1 at a leaf", "int32"),
    "threshold": Column("1", "threshold, in the unit that the column unit names"),
    "rows": Column("1", "rows in the node", "int64"),
    "importance": Column("1", "share of the variance removed by splits on the feature"),
    "generation": Column("1", "generation of the search", "int32"),
    "individual": Column("1", "number in the generation", "int32"),
    "layers": Column("1", "neurons of the hidden layers", "string"),
    "parameters": Column("1", "weights and biases", "int64"),
    "weights_seed": Column("1", "seed of the start weights", "int64"),
    "parent_a": Column("1", "first parent in the generation before, -1 for none", "int32"),
    "parent_b": Column("1", "second parent in the generation before, -1 for none", "int32"),
    "origin": Column("1", "how the individual came about", "string"),
    "fitness": Column("1", "R2 on the rows that the protocol names"),
    "basis": Column("1", "what the score and its interval rest on", "string"),
    "repeats": Column("1", "number of scores behind it", "int32"),
    "printed_r2": Column("1", "R2 as printed"),
    "as_published_r2": Column("1", "R2 by the steps as published"),
    "honest_r2": Column("1", "R2 by the honest protocol"),
    "honest_lower": Column("1", "lower end of the interval of the honest R2"),
    "honest_upper": Column("1", "upper end of the interval of the honest R2"),
    "remark": Column("1", "what to know about the printed figure", "string"),
}

_MODELS = {
    "target": Column("1", "column of the data set that is explained", "string"),
    "raised": Column("1", "targets that were not positive and were raised", "int32"),
    "r2_log": Column("1", "R2 of the logarithm"),
    "term": Column("1", "term of the power law", "string"),
    "kind": Column("1", "whether the term is a quantity or a dimensionless group", "string"),
    "tex": Column("1", "symbol in TeX", "string"),
    "words": Column("1", "what it is, in words", "string"),
    "exponent": Column("1", "exponent, or coefficient in the exponential"),
    "method": Column("1", "how the interval is made", "string"),
    "level": Column("1", "nominal level of the interval"),
    "coverage": Column("1", "share of held-out rows inside the interval"),
    "band_lower": Column("1", "lower end of the binomial band of the coverage"),
    "band_upper": Column("1", "upper end of the binomial band of the coverage"),
    "width": Column("1", "median of upper end over prediction, less 1"),
    "tested": Column("1", "rows held out", "int64"),
    "trained": Column("1", "rows trained on", "int64"),
    "test": Column("1", "test of extrapolation", "string"),
    "mape": Column("1", "mean absolute relative error"),
    "within_r2": Column("1", "R2 on the same rows of models that saw such rows"),
    "within_mape": Column("1", "mean absolute relative error of models that saw such rows"),
    "first": Column("1", "first-order Sobol index"),
    "first_lower": Column("1", "lower end of the interval of the first-order index"),
    "first_upper": Column("1", "upper end of the interval of the first-order index"),
    "total": Column("1", "total Sobol index"),
    "total_lower": Column("1", "lower end of the interval of the total index"),
    "total_upper": Column("1", "upper end of the interval of the total index"),
    "fall": Column("1", "fall of R2 when the quantity is shuffled among held-out rows"),
    "fall_lower": Column("1", "least fall of the splits"),
    "fall_upper": Column("1", "largest fall of the splits"),
    "setting": Column("1", "value the quantity is set to, in its own unit"),
    "replicate": Column("1", "number of the repetition with another seed", "int32"),
    "replicates": Column("1", "simulations of the same case", "int32"),
    "relative_spread": Column("1", "standard deviation over seeds by the mean"),
    "relative_stderr": Column("1", "standard error that the simulations state, by the mean"),
}

COLUMNS: dict[str, Column] = {
    **_KEYS,
    **{q.name: Column(q.unit, q.long_name) for q in QUANTITIES},
    **_CASES,
    **_SERIES,
    **_MAPS,
    **_RUNS,
    **_TIMES,
    **_WEAR_RATES,
    **_LEARNING,
    **_MODELS,
}
"""Every column of every table."""

DATASET_COLUMNS: tuple[str, ...] = (
    *_KEYS,
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

_ARROW_TYPES = {
    "float64": pa.float64(),
    "int64": pa.int64(),
    "int32": pa.int32(),
    "bool": pa.bool_(),
    "string": pa.string(),
}

# Of the depth rates only the headline must exceed zero: few large stones leave most facets
# untouched (p99 = 0), and sliding vanishes where stones stick from first touch to last.
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


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[IO[bytes]]:
    """A binary file that takes the place of ``path`` when the block ends well, else vanishes.

    What a killed process left of an earlier attempt is removed. An error of the file system
    names ``path``.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    _remove_left(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as sink:
            yield sink
            sink.flush()
            os.fsync(sink.fileno())
        os.replace(temporary, path)
    except OSError as error:
        if error.errno is None:
            raise
        raise type(error)(error.errno, os.strerror(error.errno), str(path)) from error
    finally:
        temporary.unlink(missing_ok=True)


def _remove_left(path: Path) -> None:
    """Remove temporary files of ``path`` whose process is gone."""
    for left in path.parent.glob(f".{glob.escape(path.name)}.*.tmp"):
        number = left.name.split(".")[-2]
        if number.isdecimal() and not _lives(int(number)):
            left.unlink(missing_ok=True)


def _lives(process: int) -> bool:
    if os.name == "nt":
        # There, os.kill would end it.
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        # Somebody else's.
        return True
    return True


def write_json(value, path: str | Path) -> None:
    """Write plain values as JSON: keys sorted, NaN as null, complete or not at all."""
    text = json.dumps(_plain(value), indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False)
    with replacing(path) as sink:
        sink.write(text.encode("utf-8") + b"\n")


def read_json(path: str | Path):
    """Read what `write_json` wrote; raises `TableError` if it is missing or corrupt."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise TableError(f"{path}: no such file") from None
    except ValueError as error:
        raise TableError(f"{path}: truncated, corrupt or not JSON ({error})") from None


def write_table(
    frame: pd.DataFrame, path: str | Path, extra: Mapping[str, Column] | None = None
) -> None:
    """Write a table as Parquet (zstd), complete or not at all, the same table to the same bytes.

    Parameters
    ----------
    frame : pandas.DataFrame
        The index is not stored.
    path : path-like
        Folders are made as needed.
    extra : mapping of str to Column, optional
        Columns that `COLUMNS` does not hold; they override it.

    Raises
    ------
    TableError
        If a column is unknown, stands twice or holds values of another type.
    """
    path = Path(path)
    known = {**COLUMNS, **(extra or {})}
    names = [str(name) for name in frame.columns]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise TableError(f"{path}: no unit is known for column {', '.join(unknown)}")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TableError(f"{path}: column {', '.join(twice)} stands twice")

    table = pa.Table.from_arrays(
        [_array(frame[name], known[name].dtype, f"{path}: column {name}") for name in names],
        schema=pa.schema([_field(name, known[name]) for name in names]),
    )
    with replacing(path) as sink:
        pq.write_table(table, sink, compression="zstd", write_page_checksum=True)


def read_table(path: str | Path, columns: Iterable[str] | None = None) -> pd.DataFrame:
    """Read a table written by `write_table`; ``columns`` selects and orders.

    Raises
    ------
    TableError
        If the file is missing, truncated, not Parquet, or lacks a column.
    """
    path = Path(path)
    columns = None if columns is None else list(columns)
    try:
        with open(path, "rb") as source:
            table = pq.ParquetFile(source, page_checksum_verification=True).read()
            names = table.column_names
    except FileNotFoundError:
        raise TableError(f"{path}: no such file") from None
    except _DAMAGED as error:
        raise _damaged(path, error) from None
    if columns is not None:
        missing = [name for name in columns if name not in names]
        if missing:
            raise TableError(f"{path}: lacks column {', '.join(missing)}")
        table = table.select(columns)
    return table.to_pandas()


def read_units(path: str | Path) -> dict[str, str]:
    """Units of the columns of a table, from the field metadata; raises as `read_table`."""
    try:
        return {
            field.name: (field.metadata or {}).get(b"units", b"").decode("utf-8")
            for field in pq.read_schema(path)
        }
    except _DAMAGED as error:
        raise _damaged(path, error) from None


# A name or a unit that is no UTF-8 is found only when it is asked for.
_DAMAGED = (pa.ArrowException, OSError, UnicodeDecodeError)


def _damaged(path: str | Path, error: Exception) -> TableError:
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return TableError(f"{path}: truncated, corrupt or not Parquet ({reason})")


def concatenate(frames: Iterable[pd.DataFrame], key: str = "case_id") -> pd.DataFrame:
    """Stack the tables of blocks or shards in the order of ``key``, rows of a key unmoved."""
    frames = list(frames)
    if not frames:
        raise TableError("no tables to join")
    return pd.concat(frames, ignore_index=True).sort_values(key, kind="stable", ignore_index=True)


def content_hash(frame: pd.DataFrame) -> str:
    """Hexadecimal SHA-256 of the columns and their values, independent of files and versions."""
    digest = hashlib.sha256()
    for name in frame.columns:
        values = frame[name].to_numpy()
        if values.dtype.kind in "OUT":
            data = "\0".join(map(str, values)).encode("utf-8")
        else:
            data = np.ascontiguousarray(values).tobytes()
        digest.update(f"{name}\0{len(data)}\0".encode() + data)
    return digest.hexdigest()


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
        From `abradem.wear_rate.wear_rates`, of all shards.
    runs : pandas.DataFrame
        One row per case simulated or rejected.
    damping_coefficient : {"table", "printed"}
        See `abradem.features.derive`.

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
    keys = cases[list(_KEYS)].reset_index(drop=True)
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


def _plain(value):
    """Numpy values as Python's, numbers that JSON cannot say as None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


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


def _field(name: str, column: Column) -> pa.Field:
    metadata = {"units": column.unit, "long_name": column.long_name}
    return pa.field(name, _ARROW_TYPES[column.dtype], metadata=metadata)


def _array(values: pd.Series, dtype: str, where: str) -> pa.Array:
    """Values as an Arrow array of a known type; NaN stays NaN, a missing text is an error."""
    if dtype == "string":
        texts = values.tolist()
        wrong = next((text for text in texts if not isinstance(text, str)), None)
        if any(not isinstance(text, str) for text in texts):
            raise TableError(f"{where} must hold text, got {wrong!r}")
        return pa.array(texts, type=pa.string())
    array = values.to_numpy()
    kind = {"float64": "fiu", "int64": "iu", "int32": "iu", "bool": "b"}[dtype]
    if array.dtype.kind not in kind and len(array):
        raise TableError(f"{where} must hold {dtype}, got {array.dtype}")
    cast = array.astype(dtype)
    if dtype in ("int64", "int32") and not np.array_equal(cast, array):
        raise TableError(f"{where}: a value does not fit {dtype}")
    return pa.array(cast)
