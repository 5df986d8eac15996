"""Records of the files that a job has written, see `abradem.store.checksums`."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

from abradem.store.checksums import (
    FOLDER,
    LOGS,
    Checksum,
    is_inside,
    record_path,
    sha256_of,
)
from abradem.store.files import write_json


def job_of(log: str | Path) -> tuple[Path, str] | None:
    """Return study and name of a job, from its log ``<study>/logs/<name>.log``; None without."""
    path = Path(log)
    for folder in path.parents:
        if folder.name == LOGS:
            return folder.parent, path.relative_to(folder).with_suffix("").as_posix()
    return None


def record_outputs(
    study: Path, job: str, outputs: Iterable[str | Path], folders: Iterable[str | Path] = ()
) -> None:
    """Record the checksums of all files that a job has written.

    Parameters
    ----------
    study : path
        Folder of the study.
    job : str
    outputs : iterable of path
        Files, and folders with all their files. Those outside the study and those that were not
        written are left out.
    folders : iterable of path
        Further folders that the job writes as a whole.
    """
    targets = list(map(Path, outputs))
    places = [(Path(folder), targets[0]) for folder in folders]
    for place, target in [*places, *((target, target) for target in targets)]:
        name, made_by = (Path(os.path.relpath(path, study)).as_posix() for path in (place, target))
        if not (is_inside(name) and is_inside(made_by)):
            continue
        if place.is_dir():
            # Records of files that an earlier job wrote there.
            shutil.rmtree(study / FOLDER / name, ignore_errors=True)
        for file in _files(place):
            path = Path(os.path.relpath(file, study)).as_posix()
            record = Checksum(sha256_of(file), file.stat().st_size, job, made_by)
            write_json(record._asdict(), record_path(study, path))


def _files(target: Path) -> Iterator[Path]:
    """The file, or all files in the folder; hidden ones are not results."""
    if target.is_file():
        yield target
    for path in sorted(target.rglob("*")) if target.is_dir() else ():
        if path.is_file() and not path.name.startswith("."):
            yield path
