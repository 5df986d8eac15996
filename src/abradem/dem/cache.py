"""Where the compiled kernels are kept: a folder named by the content of the engine's sources.

numba's own on-disk cache does not notice an edit of a function in *another* file than the one
that calls it and would silently run the old machine code. Naming the folder by the content of
all sources of the engine makes an edit a new folder.
"""

from __future__ import annotations

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
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"abradem-{os.getuid()}" / folder.name
        folder.mkdir(parents=True, exist_ok=True)
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
        compiled = numba.njit(cache=True, error_model="numpy", forceinline=inline)
        return compiled(function)
    finally:
        numba.config.CACHE_DIR = before
