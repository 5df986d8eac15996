"""Checks of the verification study: definition, verdict, tables and files.

A check compares a result of the engine with a reference and a tolerance. All verdicts are computed
in this module.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from abradem.store.columns import VERIFICATION
from abradem.store.files import write_csv
from abradem.store.tables import write_table

HOLDS, FAILS = "holds", "FAILS"

KINDS = ("relative", "absolute", "at least", "at most")


@dataclass(frozen=True)
class Check:
    """One line of the table "law, ours, reference, difference, tolerance, verdict".

    Parameters
    ----------
    law : str
        Short description of the compared quantity.
    ours, reference : float
        Result of the engine, and the value that it is compared with.
    tolerance : float
        Share of the reference (``relative``), or in ``unit`` (``absolute``); not used for bounds
        (``at least``, ``at most``).
    unit : str
        "1" if dimensionless.
    kind : {"relative", "absolute", "at least", "at most"}
    note : str
        Source of the reference, or the choice that explains a difference.
    """

    law: str
    ours: float
    reference: float
    tolerance: float = 0.0
    unit: str = "1"
    kind: str = "relative"
    note: str = ""

    def __post_init__(self):
        if self.kind not in KINDS:
            raise ValueError(f"kind = {self.kind!r} is unknown; allowed: {', '.join(KINDS)}")

    @property
    def difference(self) -> float:
        """Difference from the reference: a share of it if relative, otherwise in ``unit``."""
        difference = float(self.ours) - float(self.reference)
        if self.kind != "relative":
            return difference
        return difference / abs(self.reference) if self.reference else math.inf

    @property
    def holds(self) -> bool:
        """Whether the check passes; nan never passes."""
        if self.kind == "at least":
            return self.ours >= self.reference
        if self.kind == "at most":
            return self.ours <= self.reference
        return abs(self.difference) <= self.tolerance


def checks_table(part: int, checks: Iterable[Check]) -> pd.DataFrame:
    """Return the checks of one part of the study as a table with verdicts."""
    return pd.DataFrame(
        [
            {
                "part": part,
                "law": check.law,
                "unit": check.unit,
                "ours": float(check.ours),
                "reference": float(check.reference),
                "difference": float(check.difference),
                "tolerance": float(check.tolerance),
                "kind": check.kind,
                "verdict": HOLDS if check.holds else FAILS,
                "note": check.note,
            }
            for check in checks
        ]
    )


def write(tables: Mapping[str, pd.DataFrame], paths: Mapping[str, str | Path]) -> None:
    """Write each table as a Parquet file and as a CSV file in the same folder.

    Parameters
    ----------
    tables, paths : mapping
        Tables, and paths of the Parquet files, with the same keys.

    Raises
    ------
    ValueError
        If the keys differ.
    """
    if set(tables) != set(paths):
        raise ValueError(f"tables {sorted(tables)} do not match files {sorted(paths)}")
    for name, frame in tables.items():
        write_table(frame, paths[name], extra=VERIFICATION)
        write_csv(frame, Path(paths[name]).with_suffix(".csv"))
