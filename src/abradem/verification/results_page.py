"""The page of results: every check of the study with its verdict, written from the tables.

``python -m abradem.verification.results_page`` puts the page of the last ``make verify`` into
docs/verification.md, between the two marks.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd

from abradem.store.files import write_text
from abradem.verification.checks import HOLDS

PARTS = {
    1: "Closed forms",
    2: "Chung & Ooi's particle-level tests",
    3: "Independent codes",
    4: "Time step",
    5: "Statistics",
    6: "The paper's steady-state study",
    7: "The paper's screw-conveyor check",
    8: "Trends",
    9: "Facets",
    10: "Bed",
}

BEGIN = "<!-- generated: begin (make verify, then python -m abradem.verification.results_page) -->"
END = "<!-- generated: end -->"


def results_page(checks: pd.DataFrame) -> str:
    """Markdown page of all checks.

    Parameters
    ----------
    checks : pandas.DataFrame
        As `abradem.verification.checks.checks_table` makes them, all parts together.
    """
    holds = int((checks["verdict"] == HOLDS).sum())
    lines = [f"{holds} of {len(checks)} checks hold.", ""]
    for part, rows in checks.groupby("part", sort=True):
        lines += [f"### {part}. {PARTS[int(part)]}", ""]
        lines += ["| law | ours | reference | difference | tolerance | verdict |"]
        lines += ["| --- | ---: | ---: | ---: | ---: | --- |"]
        lines += [_line(row) for row in rows.to_dict("records")]
        notes = [row for row in rows.to_dict("records") if row["note"]]
        lines += [""]
        seen = dict.fromkeys(row["note"] for row in notes)
        if 0 < len(seen) <= _MOST_NOTES:
            lines += [f"- {note}" for note in seen] + [""]
    return "\n".join(lines)


_MOST_NOTES = 12


def verdict_counts(checks: pd.DataFrame) -> dict:
    """Number of checks, of those that hold, and the laws that fail."""
    failing = checks.loc[checks["verdict"] != HOLDS, "law"]
    return {
        "checks": len(checks),
        "hold": int((checks["verdict"] == HOLDS).sum()),
        "failing": list(failing),
    }


def _line(row: dict) -> str:
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    reference = f"{plain_number(row['reference'])}{unit}"
    if row["kind"] == "relative":
        difference, tolerance = (f"{plain_number(100.0 * row[k], 2)} %" for k in
                                 ("difference", "tolerance"))  # fmt: skip
    elif row["kind"] == "absolute":
        difference, tolerance = (
            plain_number(row["difference"], 2),
            plain_number(row["tolerance"], 2),
        )
    else:
        reference, difference, tolerance = f"{row['kind']} {reference}", "", ""
    cells = [
        row["law"], f"{plain_number(row['ours'])}{unit}", reference, difference, tolerance,
        row["verdict"],
    ]  # fmt: skip
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def plain_number(value: float, digits: int = 4) -> str:
    """A number as printed in the page."""
    return f"{value:.{digits}g}"


def into_document(page: str, document: str) -> str:
    """The document with the page between its marks."""
    head, _, rest = document.partition(BEGIN)
    _, found, tail = rest.partition(END)
    if not found:
        raise ValueError("docs/verification.md lacks the marks between which the page stands")
    return f"{head}{BEGIN}\n\n{page.strip()}\n\n{END}{tail}"


def main(root: Path = Path(".")) -> None:
    """Write the page of the last study into the documentation."""
    page = Path(root, "results/verification/results.md")
    if not page.is_file():
        sys.exit(f"{page} is missing: run `make verify` first")
    document = Path(root, "docs/verification.md")
    write_text(into_document(page.read_text(), document.read_text()), document)


if __name__ == "__main__":
    main()
