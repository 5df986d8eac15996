"""The command `abradem doctor`: damaged, truncated and missing files of a study, and the remedy."""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
from collections.abc import Iterable
from pathlib import Path

from abradem.store.errors import TableError

DAMAGED = 1
"""Exit code if a file is damaged or missing, also if it was removed."""

MOST_TARGETS = 20
"""Largest number of files that one command names; for more, the command makes the whole study."""

CONFIG = "config.yaml"
"""The configuration of a study with all defaults, among its results."""

REPORT = "report.html"


def add_doctor(commands) -> None:
    """Add the command to the subparsers of the command line."""
    text = "find damaged, truncated and missing files of a study, and the command that heals it"
    parser = commands.add_parser(
        "doctor",
        help=text,
        description=f"{text[0].upper()}{text[1:]}. Files are compared with the checksums that "
        "their jobs recorded; files without a checksum are only parsed. Exit code 0: all is "
        "sound; 1: something is not; 2: invalid input.",
    )
    parser.add_argument(
        "study", type=Path, metavar="FOLDER", help="results of the study, such as results/paper"
    )
    parser.add_argument(
        "--delete",
        action="store_true",
        help="remove the damaged files, and what else their jobs wrote, so that the next run "
        "makes them again",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from abradem.store.locks import lock_of_study

    study: Path = options.study
    if not study.is_dir():
        raise TableError(f"{study}: there is no such folder; expected one such as results/paper")
    root = Path(os.path.abspath(study)).parents[1]
    lock = lock_of_study(Path(os.path.abspath(study)).name, root)
    # Without this folder no run has been here that could begin now.
    held = lock.path.parent.is_dir()
    if held and not lock.take():
        raise TableError(f"{study}: {lock.holder()} is at work here; wait for its end")
    try:
        return _examine(study, root, options.delete)
    finally:
        lock.release()


def _examine(study: Path, root: Path, delete: bool) -> int:
    from abradem.running.soundness import examine

    found = examine(study)
    count = found.recorded + found.parsed
    if not count + found.unknown:
        raise TableError(f"{study}: holds no results of a study")
    place = Path(os.path.relpath(study, root)).as_posix()
    unsound = {finding.name for finding in found.findings}
    begin = _snakemake(study, place, unsound)
    for finding in found.findings:
        said = _command(begin, place, [finding.target])
        if delete:
            said = _removed(study, finding)
        print(f"{study / finding.name}: {finding.reason}; {said}")
    rest = _rest(found)
    if not found.findings:
        print(f"{study}: all {count} files are sound{rest}")
        return 0
    print(f"{study}: {len(found.findings)} of {count} files are not sound{rest}")
    targets = dict.fromkeys(finding.target for finding in found.findings)
    where = "" if root == Path.cwd() else f" in {root}"
    print(f"all are made again by{where}: {_command(begin, place, targets)}")
    return DAMAGED


def _snakemake(study: Path, place: str, unsound: set[str]) -> str:
    """Beginning of a command that makes files of the study again."""
    if CONFIG in unsound:
        return "snakemake --configfile FILES-OF-THE-STUDY"
    if not (study / CONFIG).is_file():
        return "snakemake"
    return f"snakemake --configfile {shlex.quote(f'{place}/{CONFIG}')}"


def _command(begin: str, place: str, targets: Iterable[str]) -> str:
    """The command that makes the targets again."""
    names = [f"{place}/{target}" for target in targets]
    reports = [name for name in names if name == f"{place}/{REPORT}"]
    others = [shlex.quote(name) for name in names if name not in reports]
    commands = []
    if len(others) > MOST_TARGETS:
        commands.append(f"abradem doctor {shlex.quote(place)} --delete; {begin}")
    elif others:
        commands.append(f"{begin} --force {' '.join(others)}")
    commands += [f"{begin} --report {shlex.quote(name)}" for name in reports]
    return " && ".join(commands)


def _removed(study: Path, finding) -> str:
    """Remove a damaged file with what else its job wrote; say so."""
    if not (study / finding.name).exists():
        return "the next run makes it"
    others = 0
    for target in dict.fromkeys((*finding.siblings, finding.name)):
        path = study / target
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        elif path.exists() or path.is_symlink():
            path.unlink()
        else:
            continue
        others += target not in (finding.target, finding.name)
    more = f" with {others} other files of its job" if others else ""
    return f"removed{more}"


def _rest(found) -> str:
    """What was not compared with a checksum."""
    words = [
        f"{number} {what}"
        for number, what in (
            (found.parsed, "without a checksum, only parsed"),
            (found.unknown, "more of formats that cannot be checked"),
        )
        if number
    ]
    return f" ({', '.join(words)})" if words else ""
