"""Tables as Parquet files, with unit and long name of each column in the field metadata."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from abradem.store.columns import COLUMNS, Column
from abradem.store.files import TableError, read_json, replacing, unreadable

_ARROW_TYPES = {
    "float64": pa.float64(),
    "float32": pa.float32(),
    "int64": pa.int64(),
    "int32": pa.int32(),
    "bool": pa.bool_(),
    "string": pa.string(),
}


def write_table(
    frame: pd.DataFrame, path: str | Path, extra: Mapping[str, Column] | None = None
) -> None:
    """Write a table as Parquet (zstd), complete or not at all; equal tables give equal bytes.

    Parameters
    ----------
    frame : pandas.DataFrame
        The index is not stored.
    path : path-like
        Missing folders are created.
    extra : mapping of str to Column, optional
        Additional columns; they override those of `COLUMNS`.

    Raises
    ------
    TableError
        If a column is unknown, appears twice or contains values of another type.
    """
    path = Path(path)
    known = {**COLUMNS, **(extra or {})}
    names = [str(name) for name in frame.columns]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise TableError(f"{path}: no unit is known for column {', '.join(unknown)}")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TableError(f"{path}: column {', '.join(twice)} appears twice")

    table = pa.Table.from_arrays(
        [_array(frame[name], known[name].dtype, f"{path}: column {name}") for name in names],
        schema=pa.schema([_field(name, known[name]) for name in names]),
    )
    with replacing(path) as sink:
        pq.write_table(table, sink, compression="zstd", write_page_checksum=True)


def read_table(path: str | Path, columns: Iterable[str] | None = None) -> pd.DataFrame:
    """Read a Parquet file; ``columns`` selects columns and their order.

    The columns are those of the file: metadata for pandas, which may turn columns into an index or
    rename them, are not obeyed.

    Raises
    ------
    TableError
        If the file is missing, truncated, not Parquet, lacks a column, or holds values that have
        no counterpart in pandas.
    """
    columns = None if columns is None else list(columns)
    try:
        with open(path, "rb") as source:
            table = pq.ParquetFile(source, page_checksum_verification=True).read()
        names = table.column_names
    except Exception as error:
        raise unreadable(path, "Parquet", error) from None
    for name in columns or []:
        if names.count(name) > 1:
            raise TableError(f"{path}: column {name!r} appears twice")
    missing = [name for name in columns or [] if name not in names]
    if missing:
        raise TableError(f"{path}: lacks column {', '.join(missing)}")
    table = table if columns is None else table.select(columns)
    table = table.replace_schema_metadata(None)
    try:
        # Whole numbers with gaps stay whole, as objects.
        return table.to_pandas(ignore_metadata=True, integer_object_nulls=True)
    except Exception as error:
        # Arrow, pandas and the modules of time zones raise errors of many types.
        raise unreadable(path, "Parquet", error, _unconvertible(table)) from None


def _unconvertible(table: pa.Table) -> str:
    """Return the first column whose values pandas cannot hold, with its type."""
    for name, field, values in zip(table.column_names, table.schema, table.columns, strict=True):
        try:
            values.to_pandas()
        except Exception:
            return f"column {name!r} of type {field.type}"
    return "the columns together"


class StoredColumn(NamedTuple):
    """A column of a Parquet file: name, type, and unit and long name ("" if unknown)."""

    name: str
    type: str
    unit: str
    long_name: str


def read_columns(path: str | Path) -> list[StoredColumn]:
    """Return the columns of a Parquet file, from its schema; raises as `read_table` does."""
    try:
        with open(path, "rb") as source:
            schema = pq.read_schema(source)
        return [
            StoredColumn(
                field.name,
                str(field.type),
                _metadata(field, UNIT_KEYS),
                _metadata(field, ("long_name",)),
            )
            for field in schema
        ]
    except Exception as error:
        # A name or a unit that is not UTF-8 raises only when it is accessed.
        raise unreadable(path, "Parquet", error) from None


UNIT_KEYS = ("units", "unit", "uom")
"""Keys of the metadata of a field that name its unit, whatever their case; ours is the first."""


def _metadata(field: pa.Field, keys: Iterable[str]) -> str:
    """Return the first value with one of these keys, or ""."""
    found = {
        key.decode("utf-8").lower(): value.decode("utf-8")
        for key, value in (field.metadata or {}).items()
        if key.decode("utf-8", "replace").lower() in keys
    }
    return next((found[key] for key in keys if key in found), "")


def range_index(path: str | Path) -> str:
    """Return the name of an index that only the metadata for pandas hold, or ""."""
    try:
        with open(path, "rb") as source:
            metadata = pq.read_schema(source).metadata or {}
        indexes = json.loads(metadata.get(b"pandas", b"{}")).get("index_columns", [])
        names = [one.get("name") for one in indexes if isinstance(one, dict)]
    except Exception:
        # Metadata of any content are not obeyed.
        return ""
    return next((str(name) for name in names if name), "")


def read_units(path: str | Path) -> dict[str, str]:
    """Return the units of the columns of a table; raises as `read_table` does."""
    return {column.name: column.unit for column in read_columns(path)}


def concatenate(frames: Iterable[pd.DataFrame], key: str = "case_id") -> pd.DataFrame:
    """Concatenate the tables of blocks or batches, sorted by ``key`` (stable)."""
    frames = list(frames)
    if not frames:
        raise TableError("no tables to join")
    return pd.concat(frames, ignore_index=True).sort_values(key, kind="stable", ignore_index=True)


def content_hash(frame: pd.DataFrame) -> str:
    """Return the SHA-256 of the columns and their values, independent of the file format."""
    digest = hashlib.sha256()
    for name in frame.columns:
        values = frame[name].to_numpy()
        if values.dtype.kind in "OUT":
            data = "\0".join(map(str, values)).encode("utf-8")
        else:
            data = np.ascontiguousarray(values).tobytes()
        digest.update(f"{name}\0{len(data)}\0".encode() + data)
    return digest.hexdigest()


def _field(name: str, column: Column) -> pa.Field:
    metadata = {"units": column.unit, "long_name": column.long_name}
    return pa.field(name, _ARROW_TYPES[column.dtype], metadata=metadata)


def _array(values: pd.Series, dtype: str, where: str) -> pa.Array:
    """Return values as an Arrow array of a known type; NaN stays NaN, missing text is an error."""
    if dtype == "string":
        texts = values.tolist()
        wrong = next((text for text in texts if not isinstance(text, str)), None)
        if any(not isinstance(text, str) for text in texts):
            raise TableError(f"{where} must contain text, got {wrong!r}")
        return pa.array(texts, type=pa.string())
    array = values.to_numpy()
    kind = {"float64": "fiu", "float32": "f", "int64": "iu", "int32": "iu", "bool": "b"}[dtype]
    if array.dtype.kind not in kind and len(array):
        raise TableError(f"{where} must contain {dtype}, got {array.dtype}")
    cast = array.astype(dtype)
    if dtype in ("int64", "int32") and not np.array_equal(cast, array):
        raise TableError(f"{where}: a value does not fit {dtype}")
    return pa.array(cast)


def read_result(path: str | Path):
    """Return the content of a result file: a table (Parquet, CSV) or plain data (JSON)."""
    suffix = Path(path).suffix
    if suffix == ".parquet":
        return read_table(path)
    if suffix != ".csv":
        return read_json(path)
    try:
        return pd.read_csv(path, comment="#")
    except (ValueError, OSError) as error:
        raise unreadable(path, "CSV", error) from None


def read_results(paths: Iterable[tuple[str, str | list[str]]]) -> dict:
    """Return the contents of named files.

    Parameters
    ----------
    paths : iterable of (str, path or list of path)
        For example the named inputs of a rule.

    Returns
    -------
    dict
        For a path the content by `read_result`, for an empty list None, and for a list an
        iterator that reads each file when it is reached, because the tables of a large study do
        not fit into memory together.
    """
    return {
        name: read_result(path)
        if isinstance(path, str)
        else map(read_result, path)
        if len(path)
        else None
        for name, path in paths
    }
