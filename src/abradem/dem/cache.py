"""On-disk cache of the compiled kernels, in a folder named by a hash of the engine's sources.

numba's own cache does not notice an edit of a function that is in *another* file than its
caller, and would silently run outdated machine code. The folder name contains a hash of all
sources of the engine, so every edit leads to a new folder.

numba also has a folder for each path of the source, and compiles again after a new checkout. Here
the hash says all, so clones and installations with the same engine share their machine code.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

ENVIRONMENT_VARIABLE = "ABRADEM_CACHE_DIR"


def engine_hash(folder: Path | None = None) -> str:
    """Return a hexadecimal hash of the names and contents of the engine's source files."""
    folder = Path(__file__).parent if folder is None else folder
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@functools.cache
def cache_folder() -> Path:
    """Return the folder for the compiled kernels of this version of the engine.

    It is below ``ABRADEM_CACHE_DIR`` if that is set, otherwise below the user's cache folder.
    If that folder cannot be written, or the user has none, it is below the temporary folder.
    """
    base: str | Path | None = os.environ.get(ENVIRONMENT_VARIABLE)
    name = f"kernels-{engine_hash()}"
    try:
        folder = Path(base or _user_folder()) / name
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError):
        # Path.home() raises a RuntimeError for a user without a home, as in some containers.
        return _private_folder() / name


def is_compiled(stepping: str, on_surface: bool = False) -> bool:
    """Whether the kernels of a stepping are in the cache of this version of the engine.

    Those for a surface are compiled apart. Numba's index of a kernel holds the types of its
    arguments, and of a surface that is a `mesh.Mesh`.
    """
    found = cache_folder().glob(f"**/{stepping}.advance-*.nbi")
    return any(not on_surface or b"abradem.dem.mesh" in path.read_bytes() for path in found)


def compiling_words(on_surface: bool = False) -> str:
    """How often and how long the kernels are compiled, as text."""
    least = "two minutes" if on_surface else "half a minute"
    return f"once for this version of it on this machine: {least} or more"


@contextlib.contextmanager
def compiling():
    """Context in which one process at a time compiles; others wait, and then find it done."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            _lock(stack.enter_context(open(cache_folder() / "compiling", "ab")))
        yield


def _user_folder() -> Path:
    """Return the folder for caches of this package below the user's."""
    base: str | Path
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "abradem"


def _private_folder() -> Path:
    """Return a temporary folder that only this user can write.

    Files in it are executed as code, so a folder that another user created is not used.
    """
    folder = Path(tempfile.gettempdir()) / f"abradem-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700)
    except OSError:
        found = folder.lstat() if folder.exists() else None
        if found is None or found.st_uid != os.getuid() or found.st_mode & 0o022:
            return Path(tempfile.mkdtemp(prefix="abradem-"))
    return folder


def kernel(function=None, *, inline: bool = False, nogil: bool = False):
    """Compile ``function`` with numba and cache its machine code in `cache_folder`.

    With ``inline`` the function is inlined into its callers: a call that passes the state of a
    simulation, dozens of arrays, costs more than most steps of a particle. With ``nogil`` other
    threads of Python run while it does.

    numba chooses the folder when a function is decorated, so its setting is changed only during
    the decoration. Division by zero follows IEEE 754, as in numpy.

    Raises
    ------
    RuntimeError
        If numba was imported with NUMBA_DISABLE_JIT; its own functions are then not compiled
        either. Imported by this package it is not, see
        `abradem.dem.before_numba`.
    """
    if function is None:
        return functools.partial(kernel, inline=inline, nogil=nogil)
    import numba

    if numba.config.DISABLE_JIT:
        raise RuntimeError(
            "NUMBA_DISABLE_JIT was set when numba was imported; the engine runs as compiled code "
            "alone, so unset it"
        )
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        compiled = numba.njit(cache=True, error_model="numpy", forceinline=inline, nogil=nogil)(
            function
        )
    finally:
        numba.config.CACHE_DIR = before
    _make_robust(compiled)
    if Path(function.__code__.co_filename).parent == Path(__file__).parent:
        _share(compiled, cache_folder())
    return compiled


def _share(compiled, folder: Path) -> None:
    """Keep the machine code of a kernel of the engine in ``folder``, wherever its source is.

    The folder stands for the content of all sources, so their paths and times do not matter.
    """
    cache: Any = getattr(compiled, "_cache", None)
    file: Any = getattr(cache, "_cache_file", None)
    locator: Any = getattr(getattr(cache, "_impl", None), "locator", None)
    known = type(file) is _robust_file() and hasattr(locator, "_cache_path")
    if not known:
        # Another version of numba is organised differently: its own folders are used.
        return
    folder.mkdir(parents=True, exist_ok=True)
    cache._cache_path = file._cache_path = locator._cache_path = str(folder)
    file._index_path = str(folder / file._index_name)
    file._source_stamp = folder.name


def _make_robust(compiled) -> None:
    """Replace the cache file of the kernel by the class of `_robust_file`."""
    from numba.core.caching import IndexDataCacheFile

    file = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    # If another version of numba is organised differently, its own cache files are used.
    if type(file) is IndexDataCacheFile:
        file.__class__ = _robust_file()


@functools.cache
def _robust_file() -> type:
    """Return a class of cache files for which a failure only causes a new compilation.

    numba's own class has three weaknesses. If processes compile different signatures of a
    function at the same time, the index can refer to the machine code of another signature. A
    file emptied by a power failure aborts every later run. A full disk aborts the current run.
    In this class the file name depends on the signature, the file is written before the index
    and under a lock, and files that cannot be read are treated as missing.
    """
    from numba.core.caching import IndexDataCacheFile

    class RobustFile(IndexDataCacheFile):
        def _load_index(self):
            try:
                return super()._load_index()
            except Exception:
                return {}

        def load(self, key):
            try:
                return super().load(key)
            except Exception:
                return None

        def save(self, key, data):
            digest = hashlib.sha256(repr(key).encode()).digest()
            name = self._data_name(int.from_bytes(digest[:8], "big"))
            with (
                contextlib.suppress(OSError),
                open(Path(self._cache_path, "lock"), "ab") as lock,
            ):
                _lock(lock)
                self._save_data(name, data)
                self._save_index({**self._load_index(), key: name})

    return RobustFile


def _lock(file) -> None:
    """Wait for the lock; it is released when the file is closed."""
    with contextlib.suppress(ImportError, OSError):
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX)
