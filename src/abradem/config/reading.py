"""Reading of files and command line into a `Config`, with one line for each problem."""

from __future__ import annotations

import datetime
import itertools
import os
import stat
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from pydantic import ValidationError

from abradem.config.conflicts import conflicts
from abradem.config.declaration import Config
from abradem.config.explaining import allowed_for, explain, is_accepted, types_of
from abradem.config.keys import (
    COMMAND_LINE,
    MISSING,
    Key,
    dotted,
    lookup,
    origin_of,
    show,
    shown_path,
    shown_word,
)
from abradem.config.scalars import misread

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


def read_config(
    *paths: str | os.PathLike, command_line: Sequence[str] = (), leave_out: Sequence[str] = ()
) -> Config:
    """Read a configuration from files and from the command line of Snakemake.

    Parameters
    ----------
    *paths : path
        Each file overrides the keys of the earlier ones.
    command_line : sequence of str
        Entries ``key=value`` of ``--config``, which override the files. The value is YAML.
    leave_out : sequence of str
        Dotted keys that are taken from the command line alone, with all below them.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    sources: list[tuple[str, dict]] = []
    problems: list[str] = []
    faulty: list[Key] = []
    unreadable = False
    for path in (Path(path).resolve() for path in paths):
        try:
            values, found = _parse_file(path)
        except ConfigError as error:
            problems += error.problems
            unreadable = True
        else:
            problems += found.lines
            faulty += found.keys
            for name in leave_out:
                _remove(values, name.split("."))
            sources.append((shown_path(path), values))
    if unreadable:
        raise ConfigError(list(dict.fromkeys(problems)))
    given, found = _parse_entries(command_line)
    sources.append((COMMAND_LINE, given))
    merged: dict = {}
    for _, values in sources:
        _merge(merged, values)
    return _checked(merged, sources, problems + found.lines, faulty + found.keys)


def origin_in_files(
    key: Key, paths: Sequence[str | os.PathLike], command_line: Sequence[str] = ()
) -> str:
    """Return the last source of a configuration that gives a key; else the first file, or ""."""
    sources = [
        (shown_path(path), _parse_file(path)[0])
        for path in (Path(path).resolve() for path in paths)
    ]
    sources.append((COMMAND_LINE, _parse_entries(command_line)[0]))
    given = [shown for shown, values in sources if lookup(values, key) is not MISSING]
    return given[-1] if given else sources[0][0] if paths else ""


def refuse_all_but_data(path: str | os.PathLike) -> None:
    """Raise if a file is not YAML with plain data only, or requests to be run as a template.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    values, _ = _parse_file(Path(path))
    if "__use_yte__" in values:
        raise ConfigError([f"{shown_path(Path(path))}: __use_yte__: templates are refused"])


def load_config(values: Mapping, origin: str = COMMAND_LINE) -> Config:
    """Check a configuration that is in no file, such as that of a module of Snakemake.

    Parameters
    ----------
    values : mapping
        All keys.
    origin : str
        Origin of the values in error messages.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    plain = _plain(values)
    return _checked(plain, [(origin, plain)], [], [])


class _Found(NamedTuple):
    """Problems of a source text: a line for each, and the keys with a wrong value."""

    lines: list[str]
    keys: list[Key]


def _remove(values: Any, path: Sequence[str]) -> None:
    """Remove what nested mappings hold under a key, if anything."""
    *above, last = path
    for name in above:
        values = values.get(name) if isinstance(values, dict) else None
    if isinstance(values, dict):
        values.pop(last, None)


def _checked(
    values: dict, sources: list[tuple[str, dict]], problems: list[str], faulty: list[Key]
) -> Config:
    """Return the configuration; raise with the ``problems`` of the sources and all others.

    Keys that are ``faulty`` in a source already have a line.
    """
    resolved: dict = {}

    def line(key: Key, problem: str, allowed: str = "") -> str:
        value = lookup(values, key)
        given = value is not MISSING
        if not given:
            value = lookup(resolved, key)
        shown = "(missing)" if value is MISSING else show(value) + ("" if given else " (default)")
        tail = f" (allowed {allowed})" if allowed else ""
        origin = origin_of(key, value, sources, given)
        return f"{origin}: {dotted(key)}: {shown}: {problem}{tail}"

    problems = list(problems)
    try:
        config = Config.model_validate(values)
    except ValidationError as error:
        told = [explain(details) for details in error.errors()]
        problems += [
            line(*one)
            for one in told
            if not any(one[0] == key[: len(one[0])] or key == one[0][: len(key)] for key in faulty)
        ]
    else:
        # A default can be in conflict with a given key.
        resolved.update(config.model_dump(mode="json"))
        problems += [line(key, problem) for key, problem in conflicts(config) if key not in faulty]
    if problems:
        raise ConfigError(list(dict.fromkeys(problems)))
    return config


def _parse_entries(entries: Sequence[str]) -> tuple[dict, _Found]:
    """Return the values of ``key=value`` entries, and their problems.

    Snakemake turns the values into numbers without a word (010 into 10, 1_000 into 1000) and
    loses the quotes of texts, so the entries are read again.
    """
    values: dict = {}
    found = _Found([], [])
    for entry in entries:
        name, _, text = entry.partition("=")
        bare = text.strip("'\"")
        try:
            node = yaml.compose(bare, Loader=yaml.SafeLoader) if bare else None
            if not isinstance(node, yaml.CollectionNode):
                # Quotes around a section are those of a shell, around a word they make it text.
                node = yaml.compose(text, Loader=yaml.SafeLoader) if text else None
            room = itertools.count(_MOST_VALUES, -1)
            value = None
            if node is not None:
                value = _construct(node, (name,), COMMAND_LINE, found, room)
        except RecursionError:
            found.lines.append(f"{COMMAND_LINE}: {name}: nested more than {_DEEPEST} levels deep")
            found.keys.append((name,))
        except yaml.MarkedYAMLError as error:
            reason = _tag_problem(error) or f"not valid YAML: {error.problem}"
            found.lines.append(f"{COMMAND_LINE}: {name}: {show(text)}: {reason}")
            found.keys.append((name,))
        except yaml.YAMLError as error:
            reason = " ".join(str(error).split())
            found.lines.append(f"{COMMAND_LINE}: {name}: {show(text)}: not valid YAML: {reason}")
            found.keys.append((name,))
        except ConfigError as error:
            found.lines.extend(error.problems)
            found.keys.append((name,))
        else:
            _merge(values, {name: value})
    return values, found


def _parse_file(path: Path) -> tuple[dict, _Found]:
    """Return the file's values, and the problems of single keys; raise if it is unreadable."""
    shown = shown_path(path)
    try:
        mode = path.stat().st_mode
        if not stat.S_ISREG(mode):
            # A pipe would wait for a writer.
            kind = "a folder" if stat.S_ISDIR(mode) else "a pipe or a device"
            raise ConfigError([f"{shown}: is {kind}, not a file"])
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
    found = _Found([], [])
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        room = itertools.count(_MOST_VALUES, -1)
        values = None if node is None else _construct(node, (), shown, found, room)
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
    return values, found


def _tag_problem(error: yaml.MarkedYAMLError) -> str:
    """Return a clear message if the error is a tag for other than plain data, otherwise ""."""
    text = error.problem or ""
    if not text.startswith("could not determine a constructor for the tag"):
        return ""
    tag = text.split("'")[1].replace("tag:yaml.org,2002:", "!!")
    return f"the tag {tag} is refused; only plain numbers, text, lists and keys are read"


def _construct(node: yaml.Node, key: Key, shown: str, found: _Found, room: Iterator[int]) -> Any:
    """Convert a YAML node into plain data.

    Keys that are given twice, and words that YAML turns into something else, are added to
    ``found``. ``room`` counts down the number of further values allowed; values of an anchor
    count at each use.
    """
    line = node.start_mark.line + 1
    if len(key) > _DEEPEST:
        raise ConfigError([f"{shown}: line {line}: nested more than {_DEEPEST} levels deep"])
    if next(room) <= 0:
        raise ConfigError([f"{shown}: line {line}: holds more than {_MOST_VALUES} values"])
    if isinstance(node, yaml.SequenceNode) and node.tag == "tag:yaml.org,2002:seq":
        return [
            _construct(item, (*key, index), shown, found, room)
            for index, item in enumerate(node.value)
        ]
    if not isinstance(node, yaml.MappingNode) or node.tag != "tag:yaml.org,2002:map":
        return _construct_scalar(node, key, shown, found)
    values: dict = {}
    first_line: dict[str, int] = {}
    for name_node, value_node in node.value:
        line = name_node.start_mark.line + 1
        if not isinstance(name_node, yaml.ScalarNode) or name_node.tag != "tag:yaml.org,2002:str":
            raise ConfigError([f"{shown}: line {line}: a key must be a plain word"])
        name = name_node.value
        value = _construct(value_node, (*key, name), shown, found, room)
        if name in values:
            found.lines.append(
                f"{shown}: {dotted((*key, name))}: {show(value)}: given twice, on lines "
                f"{first_line[name]} and {line}; a key may be given only once"
            )
            found.keys.append((*key, name))
        values[name] = value
        first_line.setdefault(name, line)
    return values


def _construct_scalar(node: yaml.Node, key: Key, shown: str, found: _Found) -> Any:
    """Convert a value; one that YAML turns into something else stays as it is written."""
    loader = yaml.SafeLoader("")
    impossible = ""
    try:
        value = loader.construct_object(node, deep=True)
    except (ValueError, OverflowError) as error:  # such as the date 2024-13-45
        if not isinstance(node, yaml.ScalarNode):
            raise yaml.constructor.ConstructorError(
                None, None, str(error), node.start_mark
            ) from None
        value, impossible = node.value, str(error)
        if node.tag == "tag:yaml.org,2002:timestamp":
            value = datetime.date.min
    finally:
        loader.dispose()
    if not isinstance(node, yaml.ScalarNode):
        return value
    types = types_of(key)
    # The value of a key that does not exist is shown as it is written.
    problem = misread(
        node.value,
        value,
        types or {"integer", "number", "boolean"},
        lambda other: not types or is_accepted(key, other),
    )
    if impossible and isinstance(value, datetime.date) and ";" not in problem:
        problem = "there is no such day"
    elif impossible and not problem:
        problem = f"not valid YAML: {impossible}"
    if problem and ";" not in problem and (allowed := allowed_for(key)):
        problem += f" (allowed {allowed})"
    if not problem or not types:
        return node.value if problem or isinstance(value, datetime.date) else value
    found.lines.append(f"{shown}: {dotted(key)}: {shown_word(node.value)}: {problem}")
    found.keys.append(key)
    return node.value


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
