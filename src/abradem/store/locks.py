"""Locks that end with the process that holds them, however it ends, so that none is ever stale."""

from __future__ import annotations

import contextlib
import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO


class Lock:
    """A lock file that one process at a time holds.

    Where the file system has no locks, or Python none for the system, it holds nobody back.

    Parameters
    ----------
    path : path-like
        The file; it is there while the lock is held, or after a kill.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._file: IO[bytes] | None = None

    def take(self, wait: bool = False) -> bool:
        """Take the lock; return whether it is held now, which it always is after waiting."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        while True:
            file = open(self.path, "a+b")
            if not _lock(file, wait):
                file.close()
                return False
            # Who held it before may have removed the file meanwhile.
            if _is_at(file, self.path):
                break
            file.close()
        file.truncate(0)
        file.write(f"process {os.getpid()} on {platform.node()}".encode())
        file.flush()
        self._file = file
        return True

    def holder(self) -> str:
        """Who holds the lock, or held it last."""
        try:
            return self.path.read_text(encoding="utf-8") or "unknown"
        except OSError:
            return "unknown"

    def release(self) -> None:
        """End the lock, if it is held, and remove its file."""
        if self._file is not None:
            self.path.unlink(missing_ok=True)
            self._file.close()
            self._file = None


@contextlib.contextmanager
def locked(path: str | Path) -> Iterator[None]:
    """Hold a lock for a block of code; wait for it if need be."""
    lock = Lock(path)
    if not lock.take():
        print(f"{path}: waiting for {lock.holder()}, which is at work here", file=sys.stderr)
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
        # A file system without locks.
        return True
    return True


def _is_at(file: IO[bytes], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False
