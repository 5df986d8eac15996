"""Error reporting of workflow jobs: the traceback goes to the log, one line to the user."""

from __future__ import annotations

import contextlib
import sys
import traceback
from pathlib import Path

CLEAR = "\r\x1b[2K"
"""Control sequence that clears the current line of a terminal."""


_WORDS = {MemoryError: "there was too little memory"}
"""Messages for errors that have none."""


def log_to(path: str | Path) -> None:
    """Redirect standard error of this process to a log file.

    If an error ends the process, the traceback is written to the file; the message and the name
    of the file go to the original standard error.

    Parameters
    ----------
    path : path-like
        The log file, which is overwritten.
    """
    terminal = sys.stderr
    log = open(path, "w", buffering=1, encoding="utf-8")

    def report(kind, error, trace):
        # The current line of a terminal may be the line of progress.
        start = CLEAR if terminal.isatty() else ""
        said = str(error) or _WORDS.get(kind, kind.__name__)
        print(f"{start}{said} (see {path})", file=terminal, flush=True)
        # Writing fails if the error is a full disk.
        with contextlib.suppress(OSError):
            traceback.print_exception(kind, error, trace, file=log)

    sys.stderr = log
    sys.excepthook = report
