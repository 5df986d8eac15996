"""Start and end of a job: errors go to its log and as one line to the user, files are recorded.

Scripts call `start_job` before they import anything else, so that an error of an import is one
line too.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import sys
import traceback
from pathlib import Path

from abradem.store.checksums import damage
from abradem.store.errors import DamagedError, memory_problem, too_small_limit

CLEAR = "\r\x1b[2K"
"""Control sequence that clears the current line of a terminal."""

LEAST_MEMORY = 1000
"""Address space, MB, below which a job cannot load what it needs."""


def start_job(snakemake, *folders: str | Path) -> None:
    """Begin the job of a script.

    Standard error goes to the log of the job, see `log_to`. Inputs are compared with their records
    in ``checksums/`` before they are read. If the script ends without an error, its outputs are
    recorded there.

    Parameters
    ----------
    snakemake : object
        The variable that Snakemake gives to scripts.
    folders : path-like
        Folders whose files the job writes, beside those that the rule names.

    Raises
    ------
    DamagedError
        If an input is not what its job wrote, with one line for each such file.
    """
    log_to(snakemake.log[0])
    if line := too_small_limit("a job", LEAST_MEMORY):
        raise MemoryError(line)
    lines = [line for path in snakemake.input if (line := damage(path))]
    if lines:
        raise DamagedError("\n".join(lines))
    atexit.register(_end_job, os.getpid(), snakemake.log[0], [*snakemake.output], folders)


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
        said = memory_problem(error) or str(error) or kind.__name__
        print(f"{start}{said} (see {path})", file=terminal, flush=True)
        atexit.unregister(_end_job)
        # Writing fails if the error is a full disk.
        with contextlib.suppress(OSError):
            traceback.print_exception(kind, error, trace, file=log)

    sys.stderr = log
    sys.excepthook = report


def _end_job(process: int, log: str, outputs: list, folders: tuple) -> None:
    """Record the outputs of a job that has ended without an error."""
    # Processes that the job started inherit the call.
    if os.getpid() != process:
        return
    from abradem.running.outputs import job_of, record_outputs

    job = job_of(log)
    if job is None:
        return
    try:
        record_outputs(*job, outputs, folders)
    except BaseException as error:
        sys.excepthook(type(error), error, error.__traceback__)
        # An error at this time would not change the exit code, and the job would count as done.
        os._exit(1)
