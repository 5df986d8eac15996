"""Tables of the verification study: a check, its verdict, units of all columns, files.

A check compares a number of ours with a reference and a tolerance. Verdicts are computed here
and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from abradem.dataset import Column, write_table
from abradem.provenance import write_text

HOLDS, FAILS = "holds", "FAILS"

KINDS = ("relative", "absolute", "at least", "at most")


@dataclass(frozen=True)
class Check:
    """One line of the table "law, ours, reference, difference, tolerance, verdict".

    Parameters
    ----------
    law : str
        What is compared, in words.
    ours, reference : float
    tolerance : float
        Share of the reference (``relative``), or in the unit of the numbers (``absolute``);
        without meaning for bounds.
    unit : str
        "1" where dimensionless.
    kind : {"relative", "absolute", "at least", "at most"}
    note : str
        Where the reference is from, or the choice that explains a difference.
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
        """Of ours from the reference: a share of it if relative, else in the unit."""
        difference = float(self.ours) - float(self.reference)
        if self.kind != "relative":
            return difference
        return difference / abs(self.reference) if self.reference else math.inf

    @property
    def holds(self) -> bool:
        """Whether the check is passed; a number that is nan never passes."""
        if self.kind == "at least":
            return self.ours >= self.reference
        if self.kind == "at most":
            return self.ours <= self.reference
        return abs(self.difference) <= self.tolerance


def checks_table(part: int, checks: Iterable[Check]) -> pd.DataFrame:
    """Return checks of one part of the study as a table with their verdicts."""
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


def _columns(unit: str, dtype: str = "float64", /, **names: str) -> dict[str, Column]:
    return {name: Column(unit, words, dtype) for name, words in names.items()}


COLUMNS = {
    **_columns("1", "int64", part="part of the study", steps="steps per contact",
               replicate="number of the replicate", facets="facets along the length"),
    **_columns(
        "1", "string",
        law="what is compared", unit="unit of ours and reference", kind="kind of tolerance",
        verdict="whether the check holds", note="source, or choice that explains a difference",
        variant="options of the law", code="program", reading="wear reading", test="test",
        quantity="quantity", source="where the value is from", feed="kind of feed",
        scene="what is simulated",
    ),
    **_columns(
        "1",
        ours="ours", plain="ours, integrated anew",
        theirs="integrated anew under the other code's choices", reference="reference",
        difference="difference, relative or in the unit",
        tolerance="tolerance", restitution="coefficient of restitution",
        static_friction="coefficient of static friction", rolling_friction="rolling friction",
        exact_beta="damping that rebounds at e", nominal_beta="textbook damping",
        rebound_exact="rebound with the exact damping",
        rebound_clipped="rebound with textbook damping, clipped",
        rebound_attractive="rebound with textbook damping, attractive",
        scaled="reading over m v^2", exact="exact value",
        tangential="tangential velocity after over speed before",
        spin_scaled="spin after times R over speed before",
        error="relative error against the converged step",
        fraction="step as a share of the Rayleigh time", bias="relative bias of the reading",
        bias_stderr="standard error of the bias", phase="phase at which the surfaces meet",
        value="value", exponent="exponent", exponent_stderr="standard error of the exponent",
        expected="expected value", relative_stderr="relative standard error",
        r2="R2 of the cumulative wear against a straight line",
        covered="whether the interval holds the mean", steps_per_contact="steps per contact",
        factor="factor by which the quantity was changed",
    ),
    **_columns("W/m2", mean="mean over the plate", footprint="mean over the footprint",
               p99="99th percentile of facets", max="worst facet"),
    **_columns("deg", angle="angle from the normal", plate_angle="plate angle",
               factory_angle="factory angle", rebound_angle="rebound angle"),
    **_columns("m/s", speed="speed"),
    **_columns("rad/s", spin="spin"),
    **_columns("s", time="time"),
    **_columns("mm", depth="mean wear depth of the plate"),
    **_columns("mm/s", depth_rate="depth rate of the plate mean",
               depth_stderr="standard error of the depth rate"),
    **_columns("J", work="work"),
    **_columns("W", rate="rate of F_n ds, W = 1", rate_stderr="standard error of the rate"),
    **_columns("N", tangential_force="tangential force", normal_force="normal force",
        our_normal="normal force, ours", our_tangential="tangential force, ours",
        their_normal="normal force, integrated anew under the other code's choices",
        their_tangential="tangential force, integrated anew under the other code's choices"),
    **_columns("m", x="position along x", height="height over the plate", z="position along z"),
    **_columns("kg/s", mass_rate="mass rate"),
}  # fmt: skip
"""Unit and meaning of every column of the study's tables."""


def write(tables: Mapping[str, pd.DataFrame], paths: Mapping[str, str | Path]) -> None:
    """Write tables as Parquet and, beside each, as CSV for reading.

    Parameters
    ----------
    tables, paths : mapping
        Tables and Parquet files by the same names.
    """
    if set(tables) != set(paths):
        raise ValueError(f"tables {sorted(tables)} do not match files {sorted(paths)}")
    for name, frame in tables.items():
        write_table(frame, paths[name], extra=COLUMNS)
        write_text(frame.to_csv(index=False), Path(paths[name]).with_suffix(".csv"))
