"""Checksums of the files of a study, kept in ``checksums/`` of its folder.

The job that writes a file records it (`abradem.running.outputs`): the record of
``learning/linear.json`` is ``checksums/learning/linear.json.sha256``. Each file has a record of its
own, so studies that grow or run at the same time share nothing. A job whose record is missing has
not ended, and is repeated. Jobs compare their inputs with the records before they read them, and
`abradem doctor` compares all files.

Only the standard library is imported, so that damage is found before anything heavy is loaded.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

FOLDER = "checksums"
"""Folder of the records in the folder of a study."""

SUFFIX = ".sha256"


class Checksum(NamedTuple):
    """The record of a file.

    Attributes
    ----------
    sha256 : str
    size : int
        Bytes.
    job : str
        Name of the job that wrote it: that of its log.
    target : str
        Output of the job, relative to the study: the file, or the folder that it lies in.
    """

    sha256: str
    size: int
    job: str
    target: str


def sha256_of(path: str | Path) -> str:
    """SHA-256 of the content of a file, hexadecimal."""
    with open(path, "rb") as source:
        return hashlib.file_digest(source, "sha256").hexdigest()


def study_of(path: str | Path) -> Path | None:
    """Folder of the study that a file belongs to: the nearest one with records; None if none has.

    It is written as ``path`` is, relative or absolute, as far as that is possible.
    """
    full = Path(os.path.abspath(path))
    for number, folder in enumerate(full.parents):
        if (folder / FOLDER).is_dir():
            parents = Path(path).parents
            return parents[number] if number < len(parents) else folder
    return None


def record_path(study: Path, name: str) -> Path:
    """The record of a file with the given path in the study."""
    return Path(study, FOLDER, f"{name}{SUFFIX}")


def read_record(study: Path, name: str) -> Checksum | None:
    """Return the record of a file, or None if there is none.

    Raises
    ------
    ValueError
        If the record itself is damaged.
    """
    path = record_path(study, name)
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        record = Checksum(**found)
        types = [type(value) for value in record]
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, TypeError, RecursionError):
        types = []
    if types != [str, int, str, str]:
        raise ValueError(f"its record {path} is damaged")
    return record


def recorded(study: str | Path) -> Iterator[str]:
    """Paths, in the study, of all files with a record, sorted."""
    folder = Path(study, FOLDER)
    for path in sorted(folder.rglob(f"*{SUFFIX}")):
        yield path.relative_to(folder).as_posix().removesuffix(SUFFIX)


def difference(study: Path, name: str) -> str | None:
    """Return how a file differs from its record, or None if it does not or has no record."""
    try:
        record = read_record(study, name)
    except ValueError as error:
        return str(error)
    if record is None:
        return None
    path = Path(study, name)
    try:
        size = path.stat().st_size
        if size != record.size:
            kind = "truncated" if size < record.size else "damaged"
            return f"{kind}, has {size} of {record.size} bytes"
        if sha256_of(path) != record.sha256:
            return "damaged, differs from what its job wrote"
    except (FileNotFoundError, NotADirectoryError):
        return "missing"
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"
    return None


def damage(path: str | Path) -> str | None:
    """Return the line for a file that differs from its record, with the remedy, or None."""
    study = study_of(path)
    if study is None:
        return None
    reason = difference(study, os.path.relpath(path, study))
    return reason and f"{path}: {reason}{remedy(path)}"


def remedy(path: str | Path) -> str:
    """End of a line on a damaged file of a study: the command that heals it; else ''."""
    study = study_of(path)
    if study is None:
        return ""
    return (
        f"; `abradem doctor {study} --delete` removes what is damaged, and the next run makes it "
        "again"
    )
