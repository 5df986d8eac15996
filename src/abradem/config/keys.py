"""Origin of a key, and the text of keys and values in messages."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from abradem.config.scalars import yaml_float

COMMAND_LINE = "command line"
"""Origin that is reported instead of a file for a value from ``--config``."""

_SHOWN = 60
"""Largest number of characters of a value in a message."""

MISSING = object()
"""Marker of a value that is not given."""

Key = tuple[str | int, ...]
"""Path of a key: the names of its sections and its own name."""


def origin_of(key: Key, value: Any, sources: Sequence[tuple[str, dict]], given: bool = True) -> str:
    """Return the file in which ``key`` has this value, or "command line".

    ``given`` is False for a default, which is neither in a file nor on the command line.
    """
    for shown, values in reversed(sources):
        found = lookup(values, key)
        if isinstance(value, dict):
            # A section is merged from several files; the last file that contains it is reported.
            if isinstance(found, dict):
                return shown
        elif found is not MISSING and repr(found) == repr(value):
            return shown
    if sources and (value is MISSING or not given):
        # For a missing key: the last file with its section, otherwise the first file.
        for shown, values in reversed(sources):
            if len(key) > 1 and isinstance(lookup(values, key[:-1]), dict):
                return shown
        return sources[0][0]
    return COMMAND_LINE


def lookup(values: Any, key: Key) -> Any:
    for part in key:
        if isinstance(values, dict) and part in values:
            values = values[part]
        elif isinstance(values, list) and isinstance(part, int) and part < len(values):
            values = values[part]
        else:
            return MISSING
    return values


def dotted(key: Key) -> str:
    text = ""
    for part in key:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text.encode("unicode_escape").decode("ascii") or "(all keys)"


def show(value: Any) -> str:
    """Return ``value`` in one short line, as in the flow style of YAML."""
    if isinstance(value, float) and not math.isfinite(value):
        text = {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    elif isinstance(value, float):
        text = yaml_float(repr(value))
    elif isinstance(value, dict):
        text = (
            "{" + ", ".join(f"{_name(name)}: {show(inner)}" for name, inner in value.items()) + "}"
        )
    elif isinstance(value, list):
        text = "[" + ", ".join(show(inner) for inner in value) + "]"
    else:
        text = json.dumps(value, default=str)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 4] + " ..."


def _name(name: Any) -> str:
    return name if isinstance(name, str) and name.isprintable() else json.dumps(name, default=str)


def shown_word(text: str) -> str:
    """Return a word of a file in one short line, as it is written."""
    line = "".join(char if char.isprintable() else " " for char in text)
    line = " ".join(line.split())
    return line if len(line) <= _SHOWN else line[: _SHOWN - 4] + " ..."


def shown_path(path: Path) -> str:
    """Return the path as a user would write it: relative if it is below the working folder."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)
