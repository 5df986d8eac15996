"""Run times of the jobs of a study, from the benchmark files of Snakemake."""

from __future__ import annotations

import contextlib
import csv
from pathlib import Path


def run_times(folder: str | Path) -> list[dict]:
    """Number of jobs and run time of each measured rule, the most expensive first.

    Parameters
    ----------
    folder : path-like
        Contains a folder for each rule, or a file ``<rule>.tsv`` for a rule with one job.

    Returns
    -------
    list of dict
        rule, jobs, seconds (sum of their wall times), longest (s).
    """
    seconds: dict[str, list[float]] = {}
    for path in sorted(Path(folder).rglob("*.tsv")):
        rule = path.relative_to(folder).parts[0].removesuffix(".tsv")
        # The file of a running job is missing or incomplete.
        with contextlib.suppress(OSError, KeyError, ValueError, TypeError):
            with open(path, encoding="utf-8", newline="") as source:
                rows = [float(row["s"]) for row in csv.DictReader(source, delimiter="\t")]
            seconds.setdefault(rule, []).extend(rows)
    times = [
        {"rule": rule, "jobs": len(all_of), "seconds": sum(all_of), "longest": max(all_of)}
        for rule, all_of in seconds.items()
        if all_of
    ]
    return sorted(times, key=lambda row: -row["seconds"])
