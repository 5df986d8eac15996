"""Where the compiled kernels are kept: a folder named by the content of the engine's sources.

numba's own on-disk cache does not notice an edit of a function in *another* file than the one
that calls it and would silently run the old machine code. Naming the folder by the content of
all sources of the engine makes an edit a new folder.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import sys
import tempfile
from pathlib import Path

ENVIRONMENT_VARIABLE = "ABRADEM_CACHE_DIR"


def engine_hash(folder: Path | None = None) -> str:
    """Return a hexadecimal hash of the names and contents of the engine's sources."""
    folder = Path(__file__).parent if folder is None else folder
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@functools.cache
def cache_folder() -> Path:
    """Return the folder for the compiled kernels of this version of the engine.

    It lies below ``ABRADEM_CACHE_DIR``, else the user's cache folder, else, where that cannot
    be written, the temporary folder.
    """
    base = os.environ.get(ENVIRONMENT_VARIABLE)
    if not base:
        if sys.platform == "win32":
            base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local"
        elif sys.platform == "darwin":
            base = Path.home() / "Library/Caches"
        else:
            base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        base = Path(base) / "abradem"
    folder = Path(base) / f"kernels-{engine_hash()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return _private_folder() / folder.name


def _private_folder() -> Path:
    """Return a temporary folder that nobody else can write.

    Kernels are read as code, so a folder that someone else made is not used.
    """
    folder = Path(tempfile.gettempdir()) / f"abradem-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700)
    except OSError:
        found = folder.lstat() if folder.exists() else None
        if found is None or found.st_uid != os.getuid() or found.st_mode & 0o022:
            return Path(tempfile.mkdtemp(prefix="abradem-"))
    return folder


def kernel(function=None, *, inline: bool = False):
    """Compile ``function`` with numba, its machine code kept in `cache_folder`.

    ``inline`` puts it into its callers: a call that passes the state of a simulation, which is
    dozens of arrays, costs more than most steps of a particle.

    numba picks the folder when a function is decorated, so the setting is changed, for this
    process and for that moment, only here. Division by zero follows IEEE 754, as in numpy.
    """
    if function is None:
        return functools.partial(kernel, inline=inline)
    import numba

    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        compiled = numba.njit(cache=True, error_model="numpy", forceinline=inline)(function)
    finally:
        numba.config.CACHE_DIR = before
    _make_robust(compiled)
    return compiled


def _make_robust(compiled) -> None:
    """Let the kernel keep its machine code in files as `_robust_file` describes."""
    from numba.core.caching import IndexDataCacheFile

    file = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    # Another version of numba may arrange this otherwise; its own files then do.
    if type(file) is IndexDataCacheFile:
        file.__class__ = _robust_file()


@functools.cache
def _robust_file() -> type:
    """Return a class of cache files that can cost a compilation, but nothing else.

    With numba's own, processes that compile different signatures of a function at the same time
    may leave an index that names the machine code of another signature; a file that a power
    failure emptied ends every later run; a full disk ends this one. Here a file is named by what
    it holds and written before the index, under a lock, and what cannot be read is not there.
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
    """Wait until no other process holds the lock; it ends with the file."""
    with contextlib.suppress(ImportError, OSError):
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX)
