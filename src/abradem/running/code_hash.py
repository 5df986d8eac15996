"""Which code a step of the workflow uses, found from its imports, and a hash of its content.

Snakemake does not see an edit in an imported package. Every rule therefore carries, as a
parameter, a hash of the *content* of its script and of every module that the script reaches: an
edit reruns that step and what follows; a touch or a revert reruns nothing. Imports inside
functions count. Imports for type checkers alone do not.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import abradem

NEUTRAL = {
    "abradem": "names and the version only",
    "abradem.running.job_log": "says what went wrong",
    "abradem.running.provenance": "records results, does not make them",
    "abradem.store": "keeps values as they are, with units and long names beside them",
}
"""Modules, or packages with all below them, whose content cannot change a result, and why."""


def step_hash(script: Path, modules: Iterable[str] = ()) -> str:
    """Hash of all code that a step of the workflow depends on, 16 hexadecimal digits.

    Parameters
    ----------
    script : path
        Script of the rule.
    modules : iterable of str
        Modules that the script imports by a name it is given.
    """
    return files_hash(Path(script), *map(source_file, closure(script, modules)))


def files_hash(*files: Path) -> str:
    """Hash of the names and the content of files, 16 hexadecimal digits.

    Files of the package count by their place in it, others by their name alone, so that the hash
    does not depend on where they lie.
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
        digest.update(name.encode() + b"\0" + hashlib.sha256(named[name].read_bytes()).digest())
    return digest.hexdigest()[:16]


def closure(script: Path, modules: Iterable[str] = ()) -> set[str]:
    """All modules of the package that a script reaches, without those of `NEUTRAL`."""
    found: set[str] = set()
    waiting = [*imported_modules(Path(script)), *modules]
    while waiting:
        module = waiting.pop()
        if module not in found and not is_neutral(module):
            found.add(module)
            waiting += imported_modules(source_file(module))
    return found


def is_neutral(module: str) -> bool:
    """Whether a module is in `NEUTRAL`, itself or with its package."""
    if module == "abradem":
        return True
    parts = module.split(".")
    return any(".".join(parts[: count + 1]) in NEUTRAL for count in range(1, len(parts)))


def source_file(module: str) -> Path:
    """Source file of a module, without importing it; of a package its ``__init__.py``.

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
    """Modules of the package that a file imports, in the order of its text."""
    return list(dict.fromkeys(_module_of(*pair) for pair in _pairs(path.read_bytes())))


@cache
def _pairs(source: bytes) -> tuple[tuple[str, str | None], ...]:
    """(module, name) of every import from the package in a source text."""
    return tuple(_imports(ast.parse(source)))


def _module_of(module: str, name: str | None) -> str:
    """The module that ``from module import name`` reads: ``name`` may be one itself."""
    folder = Path(abradem.__path__[0]).joinpath(*module.split(".")[1:])
    if name and (folder.joinpath(name).is_dir() or folder.joinpath(f"{name}.py").is_file()):
        return f"{module}.{name}"
    return module


def _imports(node: ast.AST) -> Iterator[tuple[str, str | None]]:
    """(module, name) of every import from the package below a node of a syntax tree."""
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        return
    if isinstance(node, ast.Import):
        yield from ((one.name, None) for one in node.names if _is_ours(one.name))
    elif isinstance(node, ast.ImportFrom):
        if node.level == 0 and node.module and _is_ours(node.module):
            yield from ((node.module, one.name) for one in node.names)
    elif not isinstance(node, ast.expr):
        for child in ast.iter_child_nodes(node):
            yield from _imports(child)


def _is_ours(module: str) -> bool:
    return module.split(".")[0] == "abradem"
