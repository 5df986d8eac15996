"""Reading and writing of files: a file is complete or absent, and equal content has equal bytes.

All files are written with `replacing`: a temporary file is flushed to the disk and renamed. Text,
CSV, JSON and arrays use it in this module, tables use it in `abradem.store.tables`.
"""

from __future__ import annotations

import contextlib
import glob
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from abradem.store.checksums import remedy
from abradem.store.errors import DamagedError, TableError, memory_problem

if TYPE_CHECKING:
    import pandas as pd

MOST_OF_A_REASON = 300
"""Longest reason, in characters, of a library that a line repeats."""


@contextlib.contextmanager
def errors_naming(path: str | Path) -> Iterator[None]:
    """Let an error of the file system in the block name ``path``: a full disk names no file."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise type(error)(error.errno, os.strerror(error.errno), str(path)) from error


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[IO[bytes]]:
    """Open a binary file that replaces ``path`` if the block succeeds, and is removed otherwise.

    Temporary files of an earlier, killed attempt are removed. An error of the file system names
    ``path``.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    _remove_left(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with errors_naming(path):
            with open(temporary, "wb") as sink:
                yield sink
                sink.flush()
                os.fsync(sink.fileno())
            os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def why_no_folder(folder: str | Path) -> str:
    """Return in one line why a folder cannot be made or used, or ""; nothing is written."""
    for path in reversed([Path(folder), *Path(folder).parents]):
        try:
            if path.is_symlink() and not path.exists():
                return f"{path}: is a link to {os.readlink(path)}, which does not exist"
            if path.exists() and not path.is_dir():
                return f"{path}: is a file, where a folder must be"
        except OSError as error:
            return f"{path}: cannot be read: {error.strerror}"
    return ""


def why_not_written(folder: str | Path) -> str:
    """Return in one line why no file can be written in a folder, or "".

    A temporary file is written in the folder, or in the last folder above it that exists, and
    removed.
    """
    if reason := why_no_folder(folder):
        return reason
    place = Path(folder)
    while not place.exists() and place != place.parent:
        place = place.parent
    try:
        with tempfile.TemporaryFile(dir=place):
            return ""
    except OSError as error:
        return f"{place}: cannot be written: {error.strerror}"


def _remove_left(path: Path) -> None:
    """Remove temporary files of ``path`` from processes that no longer exist."""
    for left in path.parent.glob(f".{glob.escape(path.name)}.*.tmp"):
        number = left.name.split(".")[-2]
        if number.isdecimal() and not _lives(int(number)):
            left.unlink(missing_ok=True)


def _lives(process: int) -> bool:
    if os.name == "nt":
        # On Windows, os.kill would terminate the process.
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        # The process belongs to another user.
        return True
    return True


def write_json(value, path: str | Path) -> None:
    """Write plain values as JSON with sorted keys and NaN as null, complete or not at all."""
    text = json.dumps(_plain(value), indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False)
    write_text(f"{text}\n", path)


def read_json(path: str | Path):
    """Read a file of `write_json`; raise `TableError` if it is missing, corrupt or holds NaN."""
    try:
        text = Path(path).read_text(encoding="utf-8")
        return json.loads(text, parse_constant=_refused_constant)
    except (ValueError, RecursionError, OSError) as error:
        raise unreadable(path, "JSON", error) from None


def _refused_constant(name: str):
    raise ValueError(f"{name} is no number of JSON")


def unreadable(path: str | Path, kind: str, error: Exception, part: str = "") -> TableError:
    """Return the error of one line for a file that cannot be read as ``kind``.

    Parameters
    ----------
    path : path-like
    kind : str
        What the file should be: Parquet, JSON.
    error : Exception
        What the library for this kind raised.
    part : str
        The part of a readable file whose values cannot be converted.

    Raises
    ------
    MemoryError
        If the cause is too little memory, and not the file.
    """
    if memory_problem(error):
        raise MemoryError(f"{path}: {error}") from error
    if isinstance(error, FileNotFoundError):
        return TableError(f"{path}: no such file")
    # Errors of the operating system have a number; pyarrow raises OSError for damage too.
    if isinstance(error, OSError) and error.errno is not None:
        return TableError(f"{path}: cannot be read ({os.strerror(error.errno)})")
    reason = " ".join(str(error).split()) or type(error).__name__
    shown = reason if len(reason) <= MOST_OF_A_REASON else f"{reason[:MOST_OF_A_REASON]}..."
    if part:
        return TableError(f"{path}: {part} cannot be converted ({shown}){remedy(path)}")
    return DamagedError(f"{path}: truncated, corrupt or not {kind} ({shown}){remedy(path)}")


def _plain(value):
    """Convert numpy values to Python values, and numbers that JSON lacks (nan, inf) to None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def write_text(text: str, path: str | Path) -> None:
    """Write a text file (UTF-8), complete or not at all."""
    with replacing(path) as sink:
        sink.write(text.encode("utf-8"))


def write_csv(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a table as CSV without its index, complete or not at all."""
    write_text(frame.to_csv(index=False), path)


def write_arrays(arrays: dict[str, np.ndarray], path: str | Path) -> None:
    """Write arrays as safetensors, complete or not at all; equal arrays give equal bytes."""
    from safetensors.numpy import save

    with replacing(path) as sink:
        sink.write(save({name: np.ascontiguousarray(array) for name, array in arrays.items()}))


def read_arrays(path: str | Path) -> dict[str, np.ndarray]:
    """Read arrays; raise `TableError` if the file is missing or damaged."""
    from safetensors.numpy import load_file

    try:
        # safetensors itself words this error in another way.
        if not Path(path).exists():
            raise FileNotFoundError(path)
        return load_file(path)
    except Exception as error:
        # Apart from its own error, the library raises KeyError for types that numpy lacks.
        raise unreadable(path, "safetensors", error) from None
