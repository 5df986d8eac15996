"""Environment variables that would change or break a run, set before anything reads them.

Python, numba and matplotlib read variables when they start or are imported. A value that was meant
for another program, such as the backend of a notebook, must neither break a study nor change its
files. The process that calls `force_environment` and all that it starts, among them the jobs of
the workflow, get these values.
"""

from __future__ import annotations

import os
import re
import sys
import warnings
from pathlib import Path

FORCED: dict[str, str | None] = {
    "MPLBACKEND": "agg",  # of a notebook: the module of its backend is not in this environment
    "MATPLOTLIBRC": None,  # figures have a style of their own
    "SOURCE_DATE_EPOCH": None,  # figures have no dates; matplotlib stops at a value that is none
    "NUMBA_DISABLE_JIT": None,  # kernels run as compiled code alone
    "NUMBA_NUM_THREADS": None,  # kernels use one thread; numba stops at 0
    "PYTHONOPTIMIZE": None,  # some libraries need their docstrings and assertions
    "PYTHONWARNINGS": None,  # "error" stops a run at every deprecation in a library
    "PYTHONIOENCODING": None,  # texts and tables are UTF-8
    "PYTHONUTF8": "1",
}
"""Values that are set; None removes a variable."""


_FAILING = ("strict", "surrogateescape")
"""Ways of a stream to deal with a character that its encoding lacks, which are errors."""


def force_environment() -> None:
    """Set `FORCED` for this process and all that it starts.

    The streams of this process print characters that their encoding lacks as escapes.
    """
    if "error" in os.environ.get("PYTHONWARNINGS", ""):
        warnings.simplefilter("default")
    for name, value in FORCED.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None and getattr(stream, "errors", "") in _FAILING:
            reconfigure(errors="backslashreplace")


def environment_problems(home: Path, python: str = sys.executable) -> list[str]:
    """Return one line for each path with which Snakemake cannot run this workflow.

    Parameters
    ----------
    home : path
        Folder of the workflow.
    python : str
        The Python that runs its scripts.
    """
    # Imported here, as the command needs `force_environment` alone and starts fast.
    from abradem.store.files import why_not_written

    problems = []
    if re.search(r"""[\s"'$`\\&;|<>()*?\[\]{}!]""", python):
        problems.append(
            f"{python}: the path of Python holds a blank or another character of the shell, with "
            "which Snakemake cannot start a script; make the environment in another folder"
        )
    if {"{", "}"} & set(str(home)):
        problems.append(
            f"{home}: the path of the workflow holds braces, which Snakemake takes for variables; "
            "move or rename the folder"
        )
    if reason := why_not_written(Path(".snakemake")):
        problems.append(f"{reason}; Snakemake keeps its records there")
    settings = Path("matplotlibrc")
    if settings.is_file():
        try:
            settings.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            problems.append(
                f"{settings.resolve()}: matplotlib reads this file of the working folder, and it "
                "is not UTF-8 text; move it elsewhere"
            )
    return problems
