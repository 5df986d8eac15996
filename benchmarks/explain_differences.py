"""Plant another code's choice into a copy of the engine and see whether a difference vanishes.

    python benchmarks/explain_differences.py

prints, for every variant whose differences `abradem.verification.codes` explains, the largest
difference of each quantity with our own choice and with theirs.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from planted_errors import ERRORS, ROOT

QUESTION = """
import sys
import pandas as pd
from abradem.verification import codes
table = pd.read_csv(sys.argv[1])
found = codes.compare(table[table["variant"] == sys.argv[2]])
found = found[found["restitution"] < 1.0]
for quantity, part in found.groupby("quantity", sort=False):
    scale = part["reference"].abs().max()
    print(quantity, f"{(part['ours'] - part['reference']).abs().max() / scale:.2g}")
"""

_REWIND = next(error for error in ERRORS if error.name == "spring set to cap minus damping")

CHOICES = {
    "incremental, capped, clipped": (_REWIND.file, _REWIND.before, _REWIND.after),
    "displacement, uncapped, attractive, rolling": (
        "motion.py",
        "particle.rolling += law.rolling_friction * max(fn, 0.0) * radius",
        "particle.rolling += law.rolling_friction * law.kn * overlap * math.sqrt(overlap) * radius",
    ),
}
"""By variant: the file of the engine, our choice and theirs."""


def differences(variant: str, theirs: bool, folder: Path) -> str:
    """Largest differences of a variant's quantities, of their largest value over the angles."""
    package = folder / "abradem"
    shutil.copytree(ROOT / "src" / "abradem", package, ignore=shutil.ignore_patterns("__pycache__"))
    if theirs:
        name, before, after = CHOICES[variant]
        source = package / "dem" / name
        text = source.read_text(encoding="utf-8")
        if text.count(before) != 1:
            raise ValueError(f"{variant}: {name} holds our choice {text.count(before)} times")
        source.write_text(text.replace(before, after), encoding="utf-8")
    environment = os.environ | {
        "PYTHONPATH": str(folder),
        "ABRADEM_CACHE_DIR": str(folder / "cache"),
    }
    table = ROOT / "tests" / "data" / "codes" / "single_impacts.csv"
    return subprocess.run(
        [sys.executable, "-c", QUESTION, str(table), variant],
        env=environment, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip


def main() -> None:
    """Print the differences of every variant, with our choice and with theirs."""
    for variant in CHOICES:
        for theirs in (False, True):
            with tempfile.TemporaryDirectory() as folder:
                found = differences(variant, theirs, Path(folder))
            print(
                f"{variant}, {'their' if theirs else 'our'} choice:", "; ".join(found.split("\n"))
            )


if __name__ == "__main__":
    main()
