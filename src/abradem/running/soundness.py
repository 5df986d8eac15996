"""Soundness of the files of a study: those with a record are compared with it, others parsed.

A record (`abradem.store.checksums`) finds any change. Files that Snakemake itself writes have none;
they are only checked for what their format tells: a file that is cut off, is empty, or cannot be
parsed. All others without a record were not written by a job; they are the user's own.
"""

from __future__ import annotations

import csv
import os
import stat
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from abradem.store.checksums import FOLDER, LOGS, difference, recorded, sound_record
from abradem.store.files import TableError, read_arrays, read_json
from abradem.store.tables import read_table

NO_RESULTS = (FOLDER, LOGS)
"""Folders of a study that hold no results."""

BENCHMARKS = "benchmarks"
"""Folder of the measurements of Snakemake; each has the name of its job."""

REPORT = "report.html"
"""The report that Snakemake writes."""


class Finding(NamedTuple):
    """A file of a study that is not sound.

    Attributes
    ----------
    name : str
        Path in the study.
    reason : str
    target : str
        Output of a job, in the study, by which Snakemake makes the file again.
    siblings : tuple of str
        All targets of the job, if it wrote the file.
    removable : tuple of str
        Files to remove so that Snakemake makes the file again: itself, and what else its job
        wrote, as Snakemake does not miss a single file that nothing reads. Empty if its record
        is damaged: nothing tells then that a job wrote it.
    """

    name: str
    reason: str
    target: str
    siblings: tuple[str, ...]
    removable: tuple[str, ...]


class Examination(NamedTuple):
    """What was found in a study.

    Attributes
    ----------
    recorded, parsed : int
        Numbers of files that were compared with a record, and of Snakemake's own, only parsed.
    findings : list of Finding
    foreign : list of (str, str)
        Path and fault by its format, or "", of each file that no job of the study wrote.
    """

    recorded: int
    parsed: int
    findings: list[Finding]
    foreign: list[tuple[str, str]]


def examine(study: Path) -> Examination:
    """Check all results in the folder of a study."""
    known = dict.fromkeys(recorded(study))
    records = {name: sound_record(study, name) for name in known}
    targets: dict[str, dict[str, None]] = {}
    written: dict[str, list[str]] = {}
    for name, record in records.items():
        if record is not None:
            targets.setdefault(record.job, {})[record.target] = None
            if name == record.target or name.startswith(f"{record.target}/"):
                written.setdefault(record.job, []).append(name)
    found = []
    for name, record in records.items():
        reason = difference(study, name)
        if reason and record is not None:
            removable = dict.fromkeys((name, *written.get(record.job, ())))
            siblings = tuple(targets[record.job])
            found.append(Finding(name, reason, record.target, siblings, tuple(removable)))
        elif reason:
            found.append(Finding(name, reason, name, (), ()))
    parsed, foreign = 0, []
    for name in _results(study):
        if name in known:
            continue
        path = study / name
        reason = fault_of_format(path) if path.suffix in CHECKS else None
        target = _target_of_snakemake(name, targets)
        if target is None:
            foreign.append((name, reason or ""))
            continue
        parsed += 1
        if reason:
            found.append(Finding(name, reason, target, (), (name,)))
    return Examination(len(known), parsed, sorted(found), foreign)


def _target_of_snakemake(name: str, targets: Mapping[str, Mapping[str, None]]) -> str | None:
    """What makes a file that Snakemake itself writes again; None for other files."""
    if name == REPORT:
        return name
    if name.startswith(f"{BENCHMARKS}/") and name.endswith(".tsv"):
        # Only written with the outputs of the job.
        job = name.removeprefix(f"{BENCHMARKS}/").removesuffix(".tsv")
        measured = targets.get(job) or targets.get(job.replace("/", "_"))
        return next(iter(measured)) if measured else None
    return None


def _results(study: Path) -> Iterator[str]:
    """Paths of all results in the study; hidden files are not results."""
    for folder, folders, files in os.walk(study):
        inside = Path(folder).relative_to(study)
        top = inside == Path()
        folders[:] = sorted(
            name
            for name in folders
            if not name.startswith(".") and not (top and name in NO_RESULTS)
        )
        yield from (
            (inside / name).as_posix() for name in sorted(files) if not name.startswith(".")
        )


def fault_of_format(path: Path) -> str | None:
    """Return what is wrong with a file by its format, or None.

    Raises
    ------
    KeyError
        If the format, by the suffix, is none of `CHECKS`.
    """
    check = CHECKS[path.suffix]
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            return "is no file"
        if status.st_size == 0:
            return "empty"
        check(path)
    except TableError as error:
        return str(error).removeprefix(f"{path}: ")
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"
    except (ValueError, SyntaxError, RecursionError, struct.error) as error:
        return " ".join(str(error).split()) or type(error).__name__
    return None


def _text(path: Path) -> str:
    text = path.read_bytes().decode("utf-8")
    if "\0" in text:
        raise ValueError("damaged, holds NUL")
    return text


def _whole_lines(path: Path) -> None:
    if not _text(path).endswith("\n"):
        raise ValueError("truncated, ends within a line")


def _csv(path: Path) -> None:
    text = _text(path)
    if not text.endswith("\n"):
        raise ValueError("truncated, ends within a line")
    lines = [line for line in text.splitlines(keepends=True) if not line.startswith("#")]
    rows = list(csv.reader(lines, delimiter="\t" if path.suffix == ".tsv" else ",", strict=True))
    for number, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise ValueError(
                f"damaged, row {number} has {len(row)} fields and the header {len(rows[0])}"
            )


def _tex(path: Path) -> None:
    _whole_lines(path)
    text = _text(path)
    for name in ("tabular", "table"):
        if text.count(rf"\begin{{{name}}}") != text.count(rf"\end{{{name}}}"):
            raise ValueError(f"truncated, {name} is not closed")


def _html(path: Path) -> None:
    if not _text(path).rstrip().lower().endswith("</html>"):
        raise ValueError("truncated, has no end of the page")


def _xml(path: Path) -> None:
    try:
        ElementTree.parse(path)
    except ElementTree.ParseError as error:
        raise ValueError(f"truncated or damaged XML ({error})") from None


def _yaml(path: Path) -> None:
    import yaml

    try:
        found = yaml.safe_load(_text(path))
    except yaml.YAMLError as error:
        raise ValueError(f"damaged YAML ({' '.join(str(error).split())})") from None
    if not isinstance(found, Mapping):
        raise ValueError("damaged YAML (holds no keys)")
    _whole_lines(path)


def _png(path: Path) -> None:
    """Check the checksum of every chunk, and the end."""
    content = path.read_bytes()
    if not content.startswith(b"\x89PNG\r\n\x1a\n"):
        raise ValueError("damaged, no PNG")
    place = 8
    while place < len(content):
        (length,) = struct.unpack(">I", content[place : place + 4])
        body = content[place + 4 : place + 8 + length]
        (expected,) = struct.unpack(">I", content[place + 8 + length : place + 12 + length])
        if zlib.crc32(body) != expected:
            raise ValueError("damaged, a chunk of the PNG differs from its checksum")
        place += 12 + length
        if body[:4] == b"IEND" and place == len(content):
            return
    raise ValueError("truncated, the PNG has no end")


def _pdf(path: Path) -> None:
    content = path.read_bytes()
    if not content.startswith(b"%PDF-"):
        raise ValueError("damaged, no PDF")
    if not content.rstrip().endswith(b"%%EOF"):
        raise ValueError("truncated, the PDF has no end")
    tail = content[content.rindex(b"startxref") if b"startxref" in content else 0 :].split()
    if len(tail) < 2 or not tail[1].isdigit() or int(tail[1]) >= len(content):
        raise ValueError("damaged, the PDF has no table of its objects")
    at = content[int(tail[1]) : int(tail[1]) + 40].lstrip()
    if not (at.startswith(b"xref") or b" obj" in at):
        raise ValueError("damaged, the PDF has no table of its objects")


def _mp4(path: Path) -> None:
    """Check that the boxes fill the file."""
    size = path.stat().st_size
    kinds, place = set(), 0
    with open(path, "rb") as source:
        while place < size:
            source.seek(place)
            length, kind = struct.unpack(">I4s", source.read(8))
            if length == 1:
                (length,) = struct.unpack(">Q", source.read(8))
            if length < 8 or place + length > size:
                raise ValueError("truncated, a box of the MP4 is not complete")
            kinds.add(kind)
            place += length
    if not {b"ftyp", b"moov", b"mdat"} <= kinds:
        raise ValueError("damaged, the MP4 lacks a part")


CHECKS: dict[str, Callable[[Path], object]] = {
    ".parquet": read_table,
    ".json": read_json,
    ".safetensors": read_arrays,
    ".csv": _csv, ".tsv": _csv,
    ".png": _png, ".pdf": _pdf, ".svg": _xml, ".mp4": _mp4,
    ".vtp": _xml, ".pvd": _xml,
    ".html": _html, ".md": _whole_lines, ".tex": _tex, ".yaml": _yaml,
}  # fmt: skip
"""Check of each format, by suffix; it raises an error that says what is wrong."""
