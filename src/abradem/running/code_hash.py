"""Hash of the code that a workflow step depends on, determined from the imports of its script.

Snakemake does not detect edits in an imported package. Every rule therefore has a parameter with
a hash of the *content* of its script and of every module that the script imports, directly or
indirectly. An edit reruns the step and all steps that depend on it; touching or reverting a file
reruns nothing. Imports inside functions count; imports under TYPE_CHECKING do not.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import abradem

NEUTRAL = {
    "abradem": "names and the version only",
    "abradem.running.job_log": "reports errors and records finished files",
    "abradem.running.outputs": "records finished files",
    "abradem.running.provenance": "records a run, computes no result",
    "abradem.store": "stores values unchanged, with units and long names",
}
"""Modules and packages (with all their modules) that cannot change a result, and the reason."""


def step_hash(script: Path, modules: Iterable[str] = ()) -> str:
    """Hash of all code that a workflow step depends on, 16 hexadecimal digits.

    Parameters
    ----------
    script : path
        Script of the rule.
    modules : iterable of str
        Further modules, which the script imports by name from its parameters.
    """
    return files_hash(Path(script), *map(source_file, closure(script, modules)))


def files_hash(*files: Path) -> str:
    """Hash of the names and the content of files, 16 hexadecimal digits.

    Files of the package enter with their path in the package, other files with their name only,
    so that the hash does not depend on the location of either.
    """
    root = Path(abradem.__path__[0])
    named = {
        path.relative_to(root).as_posix()
        if path.is_relative_to(root)
        else f"file {path.name}": path
        for path in map(Path, files)
    }
    digest = hashlib.sha256()
    for name in sorted(named):
        digest.update(name.encode() + b"\0" + _digest(_content(named[name])))
    return digest.hexdigest()[:16]


def closure(script: Path, modules: Iterable[str] = ()) -> set[str]:
    """All modules of the package that a script imports, also indirectly, except `NEUTRAL`."""
    found: set[str] = set()
    waiting = [*imported_modules(Path(script)), *modules]
    while waiting:
        module = waiting.pop()
        if module not in found and not is_neutral(module):
            found.add(module)
            waiting += imported_modules(source_file(module))
    return found


def is_neutral(module: str) -> bool:
    """Whether a module or a package that contains it is in `NEUTRAL`."""
    if module == "abradem":
        return True
    parts = module.split(".")
    return any(".".join(parts[: count + 1]) in NEUTRAL for count in range(1, len(parts)))


def source_file(module: str) -> Path:
    """Source file of a module, or ``__init__.py`` of a package, found without importing it.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    path = Path(abradem.__path__[0]).joinpath(*module.split(".")[1:])
    for file in (path.with_suffix(".py"), path / "__init__.py"):
        if file.is_file():
            return file
    raise ValueError(f"{module}: no such module in {abradem.__path__[0]}")


def imported_modules(path: Path) -> list[str]:
    """Modules of the package that a file imports, in the order of appearance."""
    root = str(abradem.__path__[0])
    pairs = _imports(_content(path))
    return list(dict.fromkeys(_module_of(root, *pair) for pair in pairs))


_IMPORT = re.compile(
    r"^[ \t]*(?:from (abradem[\w.]*) import (\([^)]*\)|[^\n]*)|import (abradem[\w.]*))",
    re.MULTILINE,
)
_FOR_TYPE_CHECKERS = re.compile(r"^if TYPE_CHECKING:\n(?:[ \t]+[^\n]*\n|\n)*", re.MULTILINE)


def _content(path: Path) -> bytes:
    """Content of a file, read once as long as it keeps its time and its size."""
    stat = path.stat()
    return _read(path, stat.st_mtime_ns, stat.st_size)


@cache
def _read(path: Path, time: int, size: int) -> bytes:
    return path.read_bytes()


@cache
def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


@cache
def _imports(source: bytes) -> tuple[tuple[str, str | None], ...]:
    """(module, name) of every import from the package in a source text.

    The text is searched rather than parsed: parsing all sources would lengthen every start of the
    workflow by a third. A test compares the result with the syntax tree of every file.
    """
    found: list[tuple[str, str | None]] = []
    for module, names, whole in _IMPORT.findall(_FOR_TYPE_CHECKERS.sub("", source.decode("utf-8"))):
        if whole:
            found.append((whole, None))
        for name in re.sub(r"#[^\n]*|[()]", " ", names).split(","):
            if name.strip():
                found.append((module, name.split()[0]))
    return tuple(found)


@cache
def _module_of(root: str, module: str, name: str | None) -> str:
    """The module that ``from module import name`` loads; ``name`` may itself be a module."""
    folder = Path(root).joinpath(*module.split(".")[1:])
    if name and (folder.joinpath(name).is_dir() or folder.joinpath(f"{name}.py").is_file()):
        return f"{module}.{name}"
    return module
