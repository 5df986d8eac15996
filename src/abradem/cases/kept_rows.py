"""Rows of the finished cases of a sweep, kept in a file until the sweep is complete."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import IO

from abradem.store.errors import TableError
from abradem.store.files import errors_naming


class KeptRows:
    """Finished rows in a file of JSON lines, one for each case, written when the case ends.

    A row is found again by a hash of all that decides it, so a sweep that goes on may have more or
    other cases. JSON holds every bit of a number. A line that was cut by an interruption is left
    out. Without a path nothing is kept.

    Parameters
    ----------
    path : path-like, optional
    code : str
        Hash of the code and of the files, other than the set-up, that decide the rows.
    """

    def __init__(self, path: Path | None = None, code: str = ""):
        self.path, self.code = path, code
        if path is not None and path.is_dir():
            raise TableError(f"{path}: is a folder; the finished cases of the sweep are kept there")
        self._rows = _read(path) if path is not None and path.is_file() else {}
        self._file: IO[bytes] | None = None

    def __enter__(self) -> KeptRows:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            # Closing writes again what did not fit on a full disk.
            with errors_naming(self._file.name):
                self._file.close()
            self._file = None

    def key(self, case: Mapping, setup: Mapping, options: Mapping) -> str:
        """Hash of a case, its set-up, the options of its rates and the code."""
        text = json.dumps([self.code, case, setup, options], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def find(self, key: str) -> dict | None:
        """Return the row of a key, or None."""
        return self._rows.get(key)

    def add(self, key: str, row: dict) -> None:
        """Keep a row; it is on the disk when this returns."""
        if self.path is None:
            return
        with errors_naming(self.path):
            if self._file is None:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._file = open(self.path, "ab")
                # After a line that was cut.
                self._file.write(b"\n")
            self._file.write(json.dumps({"key": key, "row": row}).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())

    def remove(self) -> None:
        """Remove the file; the rows are in the table of the sweep."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)


def _read(path: Path) -> dict[str, dict]:
    """Rows by key; lines that are not whole are left out."""
    rows = {}
    for line in path.read_bytes().splitlines():
        try:
            found = json.loads(line)
            rows[found["key"]] = dict(found["row"])
        except (ValueError, TypeError, KeyError):
            continue
    return rows
