"""Errors of files and of memory, in words.

Only the standard library is imported, so that an error can be said when nothing else can be loaded.
"""

from __future__ import annotations

import errno
import importlib.util
import re
from collections.abc import Iterator
from pathlib import Path

TOO_LITTLE_MEMORY = "there was too little memory"
"""Beginning of every line on a lack of memory."""


class TableError(ValueError):
    """A table that cannot be written, read or used; the message is one line per problem."""


class DamagedError(TableError):
    """A file that is truncated, corrupt, or not what its job wrote; the message is one line."""


def memory_problem(error: BaseException) -> str | None:
    """Return the words for an error that is due to too little memory, or None for other errors.

    Without memory, libraries raise errors that name other causes: a shared object that cannot be
    found or mapped, a thread that cannot be started.
    """
    if not any(_lacks_memory(one) for one in _chain(error)):
        return None
    if "too little memory" in str(error):
        return str(error)
    reason = " ".join(str(error).split())
    library = _LIBRARY.search(reason)
    if library:
        # The rest of such messages guesses at other causes, at length.
        reason = f"{library[0]} could not be loaded"
    return _too_little(reason)


def too_small_limit(name: str, megabytes: int) -> str | None:
    """Return the line if the address space is limited to less than a program needs, or None.

    To be asked before anything large is loaded: where too little memory ends a library in the
    middle of its own start, it ends or hangs the process without an error of Python.
    """
    limit = memory_limit()
    if limit is None or limit >= megabytes * 2**20:
        return None
    return _too_little(f"{name} needs {megabytes} MB")


def _too_little(reason: str) -> str:
    limit = memory_limit()
    place = "" if limit is None else f" (limited to {limit // 2**20} MB by `ulimit -v`)"
    return f"{TOO_LITTLE_MEMORY}{place}" + (f": {reason}" if reason else "")


def memory_limit() -> int | None:
    """Largest address space of this process, bytes; None if it is not limited."""
    try:
        import resource
    except ImportError:
        return None
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if soft == resource.RLIM_INFINITY else soft


_WORDS = re.compile(
    "cannot allocate memory|failed to map segment|cannot map zero-fill|unable to allocate|"
    "failed to launch worker thread|can't start new thread|out of memory|"
    r"malloc of size \d+ failed",
    re.IGNORECASE,
)
"""What the loader of the operating system, numpy, pyarrow, Python and LLVM say."""


_LIBRARY = re.compile(r"[\w.+-]+\.(?:so|dylib|dll)\b[\w.]*")


def _lacks_memory(error: BaseException) -> bool:
    if isinstance(error, MemoryError):
        return True
    if isinstance(error, OSError) and error.errno == errno.ENOMEM:
        return True
    if isinstance(error, SystemError) and memory_limit() is not None:
        # A library that failed without an error of its own.
        return True
    text = str(error)
    # llvmlite calls its library missing, whatever kept it from being loaded.
    return bool(_WORDS.search(text)) or ("libllvmlite" in text and _has_llvm())


def _has_llvm() -> bool:
    """Whether the library that llvmlite could not load is in its place."""
    found = importlib.util.find_spec("llvmlite")
    if found is None or not found.submodule_search_locations:
        return False
    folders = (Path(folder, "binding") for folder in found.submodule_search_locations)
    return memory_limit() is not None and any(any(folder.glob("*llvmlite*")) for folder in folders)


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """The error, and those that it follows from."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
