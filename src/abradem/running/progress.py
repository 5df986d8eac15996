"""Progress of the simulations: a line every few seconds with the cases done and the time left.

The process that starts the jobs watches the files that the batches write. A finished batch has a
``runs`` table; a running one stores each finished case in a folder (see
`abradem.simulation.batch`). The jobs themselves report nothing, so that results cannot depend on
the progress display.
"""

from __future__ import annotations

import contextlib
import logging
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from abradem.running.job_log import CLEAR
from abradem.simulation.batch import STARTED, finished_cases, resumed_cases

LEAST_COMPUTED = 2.0
"""Estimated computing time, s, that must be worked off before the time left is told: until then
the start of the jobs decides it, and it would be hours."""


@dataclass(frozen=True)
class BatchOfCases:
    """A batch of cases that the targets of a run need.

    Parameters
    ----------
    runs : path
        The ``runs`` table.
    finished : path
        Folder of finished cases.
    seconds : sequence of float
        Estimated computing time of each case, s, in the order in which they are simulated.
    """

    runs: Path
    finished: Path
    seconds: Sequence[float]

    @property
    def cases(self) -> int:
        """Number of cases."""
        return len(self.seconds)

    def work_of(self, cases: int, running: float = 0.0) -> float:
        """Estimated computing time of its first cases, s.

        The next one, which has run for some time (s), counts with this time, but with no more
        than its estimate.
        """
        following = self.seconds[cases] if cases < len(self.seconds) else 0.0
        return sum(self.seconds[:cases]) + min(running, following)


class _MakeRoom(logging.Handler):
    """Clears the line of progress before a log message is printed."""

    def __init__(self, monitor: Monitor):
        super().__init__()
        self.monitor = monitor

    def emit(self, record) -> None:
        self.monitor.clear()


class Monitor:
    """Prints the number of finished cases, from a separate thread.

    Parameters
    ----------
    folder : path
        Folder for a marker file. Results newer than the marker are those of this run.
    stream : text file, optional
        By default standard error. On a terminal the line is updated in place; otherwise a new
        line is written.
    beside : str
        Name of the logger whose messages appear on the same terminal.
    """

    def __init__(
        self,
        folder: Path,
        stream: TextIO | None = None,
        beside: str = "snakemake.logging",
    ):
        self.beside = beside
        self.total = 0
        self.folder = Path(folder)
        self._mark = self.folder / "began"
        self.stream = sys.stderr if stream is None else stream
        self.in_place = self.stream.isatty()
        self.interval = 2.0 if self.in_place else 5.0
        self._waiting: dict[str, BatchOfCases] = {}
        self._done = 0
        self._work = self._worked = self._running = 0.0
        self._resumed: dict[str, float] = {}
        self._seen: dict[str, tuple[int, float]] = {}
        self._began = self._ended = 0
        self._clock = 0.0
        self._in_line = False
        self._make_room = _MakeRoom(self)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self, batches: Mapping[str, BatchOfCases], total: int) -> None:
        """Start the thread, if there is anything to simulate.

        Parameters
        ----------
        batches : mapping of str to BatchOfCases
            The batches that this run has to simulate.
        total : int
            Number of cases that the targets of the run need; those that are in none of the
            batches count as done.
        """
        if batches:
            self.begin(batches, total)
            if self.in_place:
                # The first handler, so that the line is cleared before the message is printed.
                logging.getLogger(self.beside).handlers.insert(0, self._make_room)
            self._thread = threading.Thread(target=self._watch, daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Print the last line and stop the thread."""
        if self._thread is not None:
            self._stop.set()
            self._thread.join()
            self._thread = None
            logging.getLogger(self.beside).removeHandler(self._make_room)
            if self._waiting:
                self._print(self.line(), last=True)
        self._tidy()

    def begin(self, batches: Mapping[str, BatchOfCases], total: int) -> None:
        """Set the time from which results count as those of this run; see `start`."""
        self._waiting = dict(batches)
        self.total = total
        self._done = self.total - sum(batch.cases for batch in batches.values())
        self._worked = self._running = 0.0
        self._work = sum(batch.work_of(batch.cases) for batch in batches.values())
        self.folder.mkdir(parents=True, exist_ok=True)
        self._mark.write_text("", encoding="utf-8")
        # Use the clock of the file system, which the machines of a cluster share.
        self._began = self._ended = self._mark.stat().st_mtime_ns
        self._clock = time.monotonic()

    def count(self) -> int:
        """Number of finished cases among those that the targets need."""
        running, self._running = 0, 0.0
        for name, batch in list(self._waiting.items()):
            written = _modified(batch.runs)
            if written >= self._began:
                del self._waiting[name]
                self._done += batch.cases
                self._worked += batch.work_of(batch.cases)
                self._ended = max(self._ended, written)
            elif _modified(batch.finished / STARTED) >= self._began:
                finished = finished_cases(batch.finished)
                running += finished
                self._running += batch.work_of(finished, self._running_for(name, finished))
                self._resumed[name] = batch.work_of(resumed_cases(batch.finished))
        return self._done + running

    def _running_for(self, name: str, finished: int) -> float:
        """Time for which a batch was seen with this number of finished cases, s.

        A case of a study can take most of its time. If only finished cases counted, the time left
        would grow as long as it runs.
        """
        now = time.monotonic()
        if self._seen.get(name, (-1, now))[0] != finished:
            self._seen[name] = finished, now
        return now - self._seen[name][1]

    def line(self) -> str:
        """The line of progress."""
        done = self.count()
        text = f"simulations: {done} of {self.total} cases done"
        if done >= self.total:
            return f"{text} in {duration((self._ended - self._began) / 1e9)}"
        worked = self._worked + self._running
        computed = worked - sum(self._resumed.values())
        if computed >= LEAST_COMPUTED:
            elapsed = time.monotonic() - self._clock
            return f"{text}, about {duration(elapsed * (self._work - worked) / computed)} left"
        return text

    def clear(self) -> None:
        """Remove the line from the terminal until it is printed again."""
        if self._in_line:
            self._in_line = False
            self.stream.write(CLEAR)
            self.stream.flush()

    def _watch(self) -> None:
        shown = ""
        while self._waiting and not self._stop.wait(self.interval):
            line = self.line()
            if self.in_place or line != shown:
                self._print(line, last=not self._waiting)
            shown = line
        if not self._waiting:
            self._tidy()

    def _tidy(self) -> None:
        """Remove the marker file, also one left by a killed run."""
        self._mark.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            # Fails, as intended, if an interrupted batch left finished cases in the folder.
            self.folder.rmdir()

    def _print(self, line: str, last: bool = False) -> None:
        if self.in_place:
            self.stream.write(f"{CLEAR}{line}" + ("\n" if last else ""))
            self._in_line = not last
        else:
            self.stream.write(line + "\n")
        self.stream.flush()


def duration(seconds: float) -> str:
    """A duration in s, min or h."""
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60:02d} min"


def _modified(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return -1
