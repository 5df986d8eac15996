"""Typesetting of a LaTeX text with the tables, numbers and figures of a study."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from abradem.store.files import replacing

PROGRAMS = ("latexmk", "tectonic", "pdflatex")
"""Programs for typesetting, in order of preference."""


class TypesetError(ValueError):
    """LaTeX is missing or fails; the message is one line."""


def find_program() -> str | None:
    """The first of `PROGRAMS` that is installed, or None."""
    return next((name for name in PROGRAMS if shutil.which(name)), None)


def why_not_typeset() -> str:
    """Return in one line why no text can be typeset here, or ""."""
    if find_program() is None:
        return f"no LaTeX is installed (looked for {', '.join(PROGRAMS)})"
    return ""


def typeset(text: str | Path, study: str | Path, output: str | Path) -> None:
    r"""Typeset a text in which ``\study`` is the folder of a study's results.

    Parameters
    ----------
    text : path-like
        Such as ``paper/main.tex``.
    study : path-like
        Such as ``results/paper``; holds ``latex/`` and ``figures/``.
    output : path-like
        The PDF.

    Raises
    ------
    TypesetError
        If LaTeX is not installed or stops with an error.
    """
    program = find_program()
    if program is None:
        raise TypesetError(
            f"{why_not_typeset()}; the tables and numbers in {study}/latex can be used elsewhere"
        )
    with tempfile.TemporaryDirectory() as folder:
        main = Path(folder, "main.tex")
        # TeX acts on blanks, braces, % and # in a path, so it sees links with plain names.
        Path(folder, "study").symlink_to(Path(study).resolve())
        Path(folder, "text.tex").symlink_to(Path(text).resolve())
        main.write_text("\\def\\study{study}\\input{text.tex}\n", encoding="utf-8")
        for arguments in _commands(program):
            done = subprocess.run(
                [*arguments, main.name], cwd=folder, capture_output=True, text=True,
                errors="replace", check=False, stdin=subprocess.DEVNULL,
                # Without fixed dates the files would differ between runs.
                env={**os.environ, "SOURCE_DATE_EPOCH": "0", "FORCE_SOURCE_DATE": "1"},
            )  # fmt: skip
            if done.returncode:
                lines = (done.stdout + done.stderr).splitlines()
                first = next((line for line in lines if line.startswith("!") or "error:" in line),
                             "no reason given")  # fmt: skip
                raise TypesetError(f"{text}: {program} stopped: {first}")
        with replacing(output) as sink:
            sink.write(main.with_suffix(".pdf").read_bytes())


def _commands(program: str) -> list[list[str]]:
    quiet = ["-interaction=nonstopmode", "-halt-on-error"]
    if program == "latexmk":
        return [["latexmk", "-pdf", *quiet]]
    if program == "tectonic":
        return [["tectonic"]]
    # Two passes, as the second one resolves the labels.
    return [["pdflatex", *quiet]] * 2
