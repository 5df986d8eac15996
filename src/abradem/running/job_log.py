"""Where a job of the workflow says what went wrong: all of it in its log, one line to the user."""

from __future__ import annotations

import contextlib
import sys
import traceback
from pathlib import Path

CLEAR = "\r\x1b[2K"
"""What makes a terminal forget the line it is in."""


_WORDS = {MemoryError: "there was too little memory"}
"""What errors say that say nothing themselves."""


def log_to(path: str | Path) -> None:
    """Send standard error of this process to a file.

    An error that ends the process leaves its traceback in the file; its message and the file's
    name still go to where standard error went before.

    Parameters
    ----------
    path : path-like
        The log; what it held before is lost.
    """
    terminal = sys.stderr
    log = open(path, "w", buffering=1, encoding="utf-8")

    def report(kind, error, trace):
        # On a terminal, the line of progress may stand where this goes.
        start = CLEAR if terminal.isatty() else ""
        said = str(error) or _WORDS.get(kind, kind.__name__)
        print(f"{start}{said} (see {path})", file=terminal, flush=True)
        # The disk may be what is full.
        with contextlib.suppress(OSError):
            traceback.print_exception(kind, error, trace, file=log)

    sys.stderr = log
    sys.excepthook = report
