"""Locks that are released when their process ends, in any way, so they never become stale."""

from __future__ import annotations

import contextlib
import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO


class Lock:
    """A lock file that can be held by one process at a time.

    If the file system, or Python on this operating system, does not support locks, every process
    gets the lock.

    Parameters
    ----------
    path : path-like
        The lock file. It exists while the lock is held, and after a process was killed.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._file: IO[bytes] | None = None

    def take(self, wait: bool = False) -> bool:
        """Take the lock; return whether it is held, which is always True with ``wait``."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        while True:
            file = open(self.path, "a+b")
            if not _lock(file, wait):
                file.close()
                return False
            # The previous holder may have removed the file in the meantime.
            if _is_at(file, self.path):
                break
            file.close()
        file.truncate(0)
        file.write(f"process {os.getpid()} on {platform.node()}".encode())
        file.flush()
        self._file = file
        return True

    def holder(self) -> str:
        """Return the process that holds the lock, or held it last."""
        try:
            return self.path.read_text(encoding="utf-8") or "unknown"
        except OSError:
            return "unknown"

    def release(self) -> None:
        """Release the lock, if it is held, and remove its file."""
        if self._file is not None:
            self.path.unlink(missing_ok=True)
            self._file.close()
            self._file = None


def lock_of_study(study: str, root: str | Path = "") -> Lock:
    """Return the lock of the runs of a study, by its name and the folder with ``results/``."""
    return Lock(Path(root, ".snakemake", f"abradem-{study}.lock"))


@contextlib.contextmanager
def locked(path: str | Path) -> Iterator[None]:
    """Hold a lock during a block of code; wait for it if necessary."""
    lock = Lock(path)
    if not lock.take():
        print(f"{path}: waiting for {lock.holder()}, which holds the lock", file=sys.stderr)
        lock.take(wait=True)
    try:
        yield
    finally:
        lock.release()


def _lock(file: IO[bytes], wait: bool) -> bool:
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        return False
    except OSError:
        # The file system does not support locks.
        return True
    return True


def _is_at(file: IO[bytes], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False
