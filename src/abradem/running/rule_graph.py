"""Graph of the workflow rules as a table, obtained from Snakemake."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from abradem.store.columns import RULE_GRAPH

TARGETS = ("all",)
"""Rules that only collect files and are left out."""


def rule_graph(snakefile: Path, rule_files: Iterable[Path], options: Sequence[str] = ()):
    """Rules of the whole study and their dependencies.

    Parameters
    ----------
    snakefile : path
    rule_files : iterable of path
        Files that define the rules; their names are the stages.
    options : sequence of str
        Further arguments of snakemake, such as configuration files.

    Returns
    -------
    pandas.DataFrame
        rule, stage, needs: one row for each dependency; ``needs`` is empty for a rule without any.

    Raises
    ------
    RuntimeError
        If snakemake fails or prints no graph.
    """
    command = [
        sys.executable, "-m", "snakemake", "--snakefile", str(snakefile), "--rulegraph", "dot",
        "--nolock", *options,
    ]  # fmt: skip
    asked = subprocess.run(command, capture_output=True, text=True, check=False)
    if asked.returncode or "digraph" not in asked.stdout:
        last = (asked.stderr.strip() or "no output").splitlines()[-1]
        raise RuntimeError(f"snakemake --rulegraph failed: {last}")
    return from_dot(asked.stdout, stages(rule_files))


def stages(rule_files: Iterable[Path]) -> dict[str, str]:
    """Stage of each rule: the name of the first file that defines it."""
    found: dict[str, str] = {}
    for path in rule_files:
        text = Path(path).read_text(encoding="utf-8")
        for name in re.findall(r"^ *rule (\w+):", text, re.MULTILINE):
            found.setdefault(name, Path(path).stem)
    return found


def from_dot(text: str, stage_of: dict[str, str]) -> pd.DataFrame:
    """The table of `rule_graph` from a graph in the DOT language of Graphviz."""
    names = dict(re.findall(r'^\s*(\d+)\[label = "(\w+)', text, re.MULTILINE))
    pairs = sorted(
        (names[late], names[early])
        for early, late in re.findall(r"^\s*(\d+) -> (\d+)", text, re.MULTILINE)
    )
    fed = {rule for rule, _ in pairs}
    rows = pairs + [(rule, "") for rule in names.values() if rule not in fed]
    return pd.DataFrame(
        [
            {"rule": rule, "stage": stage_of.get(rule, ""), "needs": needs}
            for rule, needs in sorted(rows)
            if rule not in TARGETS
        ],
        columns=list(RULE_GRAPH),
    )
