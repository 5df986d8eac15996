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
import re
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

FOLDER = "checksums"
"""Folder of the records in the folder of a study."""

SUFFIX = ".sha256"

LOGS = "logs"
"""Folder, in that of the study, of the logs of its jobs."""

CONFIG_FILE = "config.yaml"
"""The configuration of a study with all defaults, among its results."""

_LARGEST_RECORD = 100_000
"""Largest size of a record, bytes."""

_STUDY_KEY = re.compile(rb"^study:[ \t]*\S", re.MULTILINE)


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
        if _has_records(folder, os.path.relpath(full, folder)):
            parents = Path(path).parents
            return parents[number] if number < len(parents) else folder
    return None


def is_study(folder: Path) -> bool:
    """Whether a folder holds the results of a study.

    It has records of this format, and the configuration of the study. As long as a run has not
    written that, and in studies without it, the log of a recorded job stands for it.
    """
    records = _sound_records(folder)
    first = next(records, None)
    if first is None:
        return False
    if record_path(folder, CONFIG_FILE).is_file() or _names_a_study(folder / CONFIG_FILE):
        return True
    return any(
        (folder / LOGS / f"{record.job}.log").is_file()
        for record in (first, *records)
        if is_inside(record.job)
    )


def _has_records(folder: Path, name: str) -> bool:
    """Whether a folder has sound records; that of a file in it is looked at first."""
    if not (folder / FOLDER).is_dir():
        return False
    own = sound_record(folder, name)
    return own is not None or next(_sound_records(folder), None) is not None


def _sound_records(folder: Path) -> Iterator[Checksum]:
    """The records of a folder that have the format of this module, in any order."""
    for path in Path(folder, FOLDER).rglob(f"*{SUFFIX}"):
        name = path.relative_to(folder / FOLDER).as_posix().removesuffix(SUFFIX)
        if (record := sound_record(folder, name)) is not None:
            yield record


def sound_record(folder: Path, name: str) -> Checksum | None:
    """Return the record of a file, or None if there is none or it is damaged."""
    try:
        return read_record(folder, name)
    except ValueError:
        return None


def _names_a_study(path: Path) -> bool:
    try:
        return path.is_file() and bool(_STUDY_KEY.search(path.read_bytes()))
    except OSError:
        return False


def is_inside(name: str) -> bool:
    """Whether a text is the path of a result below the folder of a study, as it is recorded."""
    parts = name.split("/")
    plain = name.isprintable() and not any(part in ("", ".", "..") for part in parts)
    return plain and "\\" not in name and parts[0] not in (FOLDER, LOGS)


def stays_inside(study: Path, name: str) -> bool:
    """Whether a file in the study is there itself, and not elsewhere by a link to a folder."""
    return Path(study, name).parent.resolve().is_relative_to(study.resolve())


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
        status = path.stat()
        # A pipe would wait for a writer.
        if not stat.S_ISREG(status.st_mode) or status.st_size > _LARGEST_RECORD:
            raise ValueError
        record = Checksum(**json.loads(path.read_text(encoding="utf-8")))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, TypeError, RecursionError):
        record = None
    if record is None or not _is_record(record, name):
        raise ValueError(f"its record {path} is damaged")
    return record


def _is_record(record: Checksum, name: str) -> bool:
    """Whether a record is one that a job wrote for a file of the study."""
    return (
        [type(value) for value in record] == [str, int, str, str]
        and re.fullmatch("[0-9a-f]{64}", record.sha256) is not None
        and record.size >= 0
        and record.job != ""
        and is_inside(name)
        and is_inside(record.target)
    )


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
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            return "is no file"
        size = status.st_size
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
    if study is None or not is_study(study):
        return ""
    try:
        written = read_record(study, os.path.relpath(path, study)) is not None
    except ValueError:
        return f"; `abradem doctor {study}` names the command that makes both again"
    if not written:
        return ""
    return (
        f"; `abradem doctor {study} --delete` removes what is damaged, and the next run makes it "
        "again"
    )
