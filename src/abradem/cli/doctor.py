"""The command `abradem doctor`: damaged, truncated and missing files of a study, and the remedy."""

from __future__ import annotations

import argparse
import contextlib
import os
import shlex
from collections.abc import Iterable
from pathlib import Path

from abradem.store.errors import TableError

DAMAGED = 1
"""Exit code if a file is damaged or missing, also if it was removed."""

MOST_TARGETS = 20
"""Largest number of files that one command names; for more, the command makes the whole study."""

STYLE = "--report-stylesheet workflow/report/report.css"
"""Option of snakemake for the look of the report, as in `make run`."""

MOST_FOREIGN = 20
"""Largest number of files that no job wrote that are listed."""


def add_doctor(commands) -> None:
    """Add the command to the subparsers of the command line."""
    text = "find damaged, truncated and missing files of a study, and the command that heals it"
    parser = commands.add_parser(
        "doctor",
        help=text,
        description=f"{text[0].upper()}{text[1:]}. Files are compared with the checksums that "
        "their jobs recorded; the report and benchmarks, which Snakemake writes, are only parsed. "
        "Files that no job wrote are listed and left alone. Exit code 0: all is sound; 1: "
        "something is not; 2: invalid input.",
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
    root = _root(study)
    lock = lock_of_study(Path(os.path.abspath(study)).name, root)
    # Without this folder no run has been here that could begin now.
    held = lock.path.parent.is_dir()
    if held and not lock.take():
        raise TableError(f"{study}: {lock.holder()} is at work here; wait for its end")
    try:
        return _examine(study, root, options.delete)
    finally:
        lock.release()


def _root(study: Path) -> Path:
    """Folder in which the study was run; raises if the folder is not that of a study."""
    from abradem.store.checksums import is_study, study_of

    if not study.is_dir():
        raise TableError(f"{study}: there is no such folder; expected one such as results/paper")
    parents = Path(os.path.abspath(study)).parents
    if len(parents) > 1 and is_study(study):
        return parents[1]
    above = study_of(study)
    inside = above is not None and is_study(above)
    raise TableError(
        f"{study}: is not the folder of a study, which has its config.yaml and the records of its "
        f"jobs in checksums/; give {above if inside else 'one such as results/paper'}"
    )


def _examine(study: Path, root: Path, delete: bool) -> int:
    from abradem.running.soundness import examine

    found = examine(study)
    count = found.recorded + found.parsed
    place = Path(os.path.relpath(study, root)).as_posix()
    unsound = {finding.name for finding in found.findings}
    begin = _snakemake(study, place, unsound)
    for finding in found.findings:
        said = _command(begin, place, [finding.target])
        if delete and finding.removable:
            said = _removed(study, finding)
        print(f"{study / finding.name}: {finding.reason}; {said}")
    for name, reason in found.foreign[:MOST_FOREIGN]:
        print(
            f"{study / name}: not written by a job of this study (no record)"
            + (f"; {reason}" if reason else "")
        )
    if more := len(found.foreign[MOST_FOREIGN:]):
        print(f"{study}: {more} more files not written by a job of this study (no record)")
    rest = f" ({found.parsed} without a checksum, only parsed)" if found.parsed else ""
    if not found.findings:
        print(f"{study}: all {count} files are sound{rest}")
        return 0
    print(f"{study}: {len(found.findings)} of {count} files are not sound{rest}")
    targets = dict.fromkeys(finding.target for finding in found.findings)
    kept = dict.fromkeys(one.target for one in found.findings if not one.removable)
    where = "" if root == Path.cwd() else f" in {root}"
    print(f"all are made again by{where}: {_command(begin, place, targets, kept)}")
    return DAMAGED


def _snakemake(study: Path, place: str, unsound: set[str]) -> str:
    """Beginning of a command that makes files of the study again."""
    from abradem.store.checksums import CONFIG_FILE

    if CONFIG_FILE in unsound:
        return "snakemake --configfile FILES-OF-THE-STUDY"
    if not (study / CONFIG_FILE).is_file():
        return "snakemake"
    return f"snakemake --configfile {shlex.quote(f'{place}/{CONFIG_FILE}')}"


def _command(begin: str, place: str, targets: Iterable[str], kept: Iterable[str] = ()) -> str:
    """The command that makes the targets again; those ``kept`` are not removed by --delete."""
    from abradem.running.soundness import REPORT

    names = [f"{place}/{target}" for target in targets]
    reports = [name for name in names if name == f"{place}/{REPORT}"]
    others = [shlex.quote(name) for name in names if name not in reports]
    forced = [shlex.quote(f"{place}/{target}") for target in kept]
    commands = []
    if len(others) > MOST_TARGETS:
        commands.append(f"abradem doctor {shlex.quote(place)} --delete; {begin}")
        if forced:
            commands.append(f"{begin} --force {' '.join(forced)}")
    elif others:
        commands.append(f"{begin} --force {' '.join(others)}")
    commands += [f"{begin} --report {shlex.quote(name)} {STYLE}" for name in reports]
    return " && ".join(commands)


def _removed(study: Path, finding) -> str:
    """Remove a damaged file with what else its job wrote; say so."""
    from abradem.store.checksums import stays_inside

    if not (study / finding.name).exists():
        return "the next run makes it"
    if not all(stays_inside(study, name) for name in finding.removable):
        return "not removed, as a link leads out of the study"
    others = 0
    for name in finding.removable:
        path = study / name
        if path.is_file() or path.is_symlink():
            path.unlink()
            others += name != finding.name
    left = sum(
        _left_in(study / target)
        for target in finding.siblings
        if (study / target).is_dir() and stays_inside(study, f"{target}/any")
    )
    more = f" with {others} other files of its job" if others else ""
    kept = f"; {left} files in its folder that no job wrote are kept" if left else ""
    return f"removed{more}{kept}"


def _left_in(folder: Path) -> int:
    """Remove the empty folders of an output that is a folder; return the number of files left."""
    left = 0
    for inside, _, names in os.walk(folder, topdown=False):
        # Snakemake keeps the time of the output here.
        stamp = Path(inside, ".snakemake_timestamp")
        stamp.unlink(missing_ok=True)
        left += sum(name != stamp.name for name in names)
        # One with a file in it stays.
        with contextlib.suppress(OSError):
            os.rmdir(inside)
    return left
