"""Reading of files and command line into a `Config`, with one line for each problem."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from abradem.config.conflicts import conflicts
from abradem.config.declaration import Config
from abradem.config.explaining import explain
from abradem.config.keys import (
    COMMAND_LINE,
    MISSING,
    Key,
    dotted,
    lookup,
    origin_of,
    show,
    shown_path,
)

_DEEPEST = 8
"""Largest number of nested levels; a file with more is not a configuration, or refers to itself."""

_LARGEST_FILE = 1_000_000
"""Largest size of a configuration file, bytes."""

_MOST_VALUES = 20_000
"""Largest number of values in a file; a few YAML anchors can expand to billions of values."""


class ConfigError(ValueError):
    """One or several problems of a configuration; the message has one line for each."""

    def __init__(self, problems: Sequence[str]):
        self.problems = list(problems)
        super().__init__("\n".join(self.problems))


def read_config(*paths: str | os.PathLike) -> Config:
    """Read a configuration from files; each file overrides the keys of the earlier ones.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    merged: dict = {}
    problems = []
    for path in paths:
        try:
            values, _ = _parse_file(Path(path))
        except ConfigError as error:
            problems += error.problems
        else:
            _merge(merged, values)
    if problems:
        raise ConfigError(problems)
    return load_config(merged, [Path(path) for path in paths])


def refuse_all_but_data(path: str | os.PathLike) -> None:
    """Raise if a file is not YAML with plain data only, or requests to be run as a template.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    values, problems = _parse_file(Path(path))
    if "__use_yte__" in values:
        problems = [f"{shown_path(Path(path))}: __use_yte__: templates are refused"]
    if problems:
        raise ConfigError(problems)


def load_config(
    merged: Mapping, files: Sequence[str | os.PathLike] = (), elsewhere: str = COMMAND_LINE
) -> Config:
    """Check a configuration that is already merged, as Snakemake passes it.

    Parameters
    ----------
    merged : mapping
        All keys; those of the command line override those of the files.
    files : sequence of path
        The files of the configuration. They are read again to find duplicate keys and to report
        the file of a wrong value.
    elsewhere : str
        Origin that is reported for a value that is in none of these files.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    sources: list[tuple[str, dict]] = []
    problems: list[str] = []
    for path in dict.fromkeys(Path(file).resolve() for file in files):
        try:
            values, found = _parse_file(path)
        except ConfigError as error:
            problems += error.problems
        else:
            problems += found
            sources.append((shown_path(path), values))
    if problems:
        raise ConfigError(problems)

    values = _read_command_line_text(_plain(merged), sources)

    resolved: dict = {}

    def line(key: Key, problem: str, allowed: str = "") -> str:
        value = lookup(values, key)
        given = value is not MISSING
        if not given:
            value = lookup(resolved, key)
        shown = "(missing)" if value is MISSING else show(value) + ("" if given else " (default)")
        tail = f" (allowed {allowed})" if allowed else ""
        origin = origin_of(key, value, sources, given)
        if origin == COMMAND_LINE:
            origin = elsewhere
        return f"{origin}: {dotted(key)}: {shown}: {problem}{tail}"

    try:
        config = Config.model_validate(values)
    except ValidationError as error:
        raise ConfigError([line(*explain(details)) for details in error.errors()]) from None
    # A default can be in conflict with a given key.
    resolved.update(config.model_dump(mode="json"))
    problems = [line(key, problem) for key, problem in conflicts(config)]
    if problems:
        raise ConfigError(problems)
    return config


def _parse_file(path: Path) -> tuple[dict, list[str]]:
    """Return the file's values and one line for each duplicate key; raise if unreadable."""
    shown = shown_path(path)
    try:
        with open(path, "rb") as file:
            content = file.read(_LARGEST_FILE + 1)
        if len(content) > _LARGEST_FILE:
            raise ConfigError([f"{shown}: is larger than {_LARGEST_FILE // 1000} kB"])
        text = content.decode("utf-8-sig")
    except FileNotFoundError:
        raise ConfigError([f"{shown}: there is no such file"]) from None
    except OSError as error:
        raise ConfigError([f"{shown}: cannot be read: {error.strerror}"]) from None
    except UnicodeDecodeError as error:
        raise ConfigError(
            [f"{shown}: byte {error.start + 1} is not UTF-8; save the file as UTF-8 text"]
        ) from None
    problems: list[str] = []
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        room = itertools.count(_MOST_VALUES, -1)
        values = None if node is None else _construct(node, (), shown, problems, room)
    except RecursionError:
        raise ConfigError([f"{shown}: nested more than {_DEEPEST} levels deep"]) from None
    except yaml.MarkedYAMLError as error:
        where = error.problem_mark or error.context_mark
        place = f"line {where.line + 1}: " if where else ""
        reason = _tag_problem(error) or f"not valid YAML: {error.problem}"
        raise ConfigError([f"{shown}: {place}{reason}"]) from None
    except yaml.YAMLError as error:
        raise ConfigError([f"{shown}: not valid YAML: {' '.join(str(error).split())}"]) from None
    if values is None:
        raise ConfigError([f"{shown}: the file is empty; it must contain keys, such as study"])
    if not isinstance(values, dict):
        raise ConfigError(
            [f"{shown}: contains {show(values)}, not keys; it must begin with a key, such as study"]
        )
    return values, problems


def _tag_problem(error: yaml.MarkedYAMLError) -> str:
    """Return a clear message if the error is a tag for other than plain data, otherwise ""."""
    text = error.problem or ""
    if not text.startswith("could not determine a constructor for the tag"):
        return ""
    tag = text.split("'")[1].replace("tag:yaml.org,2002:", "!!")
    return f"the tag {tag} is refused; only plain numbers, text, lists and keys are read"


def _construct(
    node: yaml.Node, key: Key, shown: str, problems: list[str], room: Iterator[int]
) -> Any:
    """Convert a YAML node into plain data, and report keys that are given twice.

    ``room`` counts down the number of further values allowed; values of an anchor count at each
    use.
    """
    line = node.start_mark.line + 1
    if len(key) > _DEEPEST:
        raise ConfigError([f"{shown}: line {line}: nested more than {_DEEPEST} levels deep"])
    if next(room) <= 0:
        raise ConfigError([f"{shown}: line {line}: holds more than {_MOST_VALUES} values"])
    if isinstance(node, yaml.SequenceNode) and node.tag == "tag:yaml.org,2002:seq":
        return [
            _construct(item, (*key, index), shown, problems, room)
            for index, item in enumerate(node.value)
        ]
    if not isinstance(node, yaml.MappingNode) or node.tag != "tag:yaml.org,2002:map":
        return _construct_scalar(node)
    values: dict = {}
    first_line: dict[str, int] = {}
    for name_node, value_node in node.value:
        line = name_node.start_mark.line + 1
        if not isinstance(name_node, yaml.ScalarNode) or name_node.tag != "tag:yaml.org,2002:str":
            raise ConfigError([f"{shown}: line {line}: a key must be a plain word"])
        name = name_node.value
        value = _construct(value_node, (*key, name), shown, problems, room)
        if name in values:
            problems.append(
                f"{shown}: {dotted((*key, name))}: {show(value)}: given twice, on lines "
                f"{first_line[name]} and {line}; a key may be given only once"
            )
        values[name] = value
        first_line.setdefault(name, line)
    return values


def _construct_scalar(node: yaml.Node) -> Any:
    loader = yaml.SafeLoader("")
    try:
        return loader.construct_object(node, deep=True)
    except (ValueError, OverflowError) as error:  # such as the date 2024-13-45
        raise yaml.constructor.ConstructorError(None, None, str(error), node.start_mark) from None
    finally:
        loader.dispose()


def _merge(base: dict, overlay: Mapping) -> None:
    """Merge ``overlay`` recursively into ``base`` in place, as Snakemake does."""
    for name, value in overlay.items():
        if isinstance(value, Mapping):
            inner = base.get(name)
            base[name] = dict(inner) if isinstance(inner, Mapping) else {}
            _merge(base[name], value)
        else:
            base[name] = value


def _plain(value: Any) -> Any:
    """Return ``value`` with all mappings and sequences converted to dicts and lists."""
    if isinstance(value, Mapping):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    return value


def _read_command_line_text(values: dict, sources: Sequence[tuple[str, dict]]) -> dict:
    """Parse nested values of ``--config``, which Snakemake passes as text.

    ``--config sampling='{blocks: 3}'`` arrives as the text "3". Only values that are in none of
    the files are parsed; a number in quotes in a file stays text.
    """

    def read(value: Any, key: Key) -> Any:
        if isinstance(value, dict):
            return {name: read(inner, (*key, name)) for name, inner in value.items()}
        if origin_of(key, value, sources) != COMMAND_LINE or not sources:
            return value
        if isinstance(value, list):
            return [read(inner, (*key, index)) for index, inner in enumerate(value)]
        if isinstance(value, str):
            try:
                scalar = yaml.safe_load(value)
            except yaml.YAMLError:
                return value
            return value if isinstance(scalar, (dict, list)) else scalar
        return value

    return read(values, ())
