"""Where a key stands, and how keys and values are written in a line."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from abradem.config.declaration import yaml_float

COMMAND_LINE = "command line"
"""Named instead of a file where a value came through ``--config``."""

_SHOWN = 60
"""Characters of a wrong value that are repeated in its line."""

MISSING = object()
"""Stands for a value that is not given."""

Key = tuple[str | int, ...]
"""Path of a key through the sections."""


def origin_of(key: Key, value: Any, sources: Sequence[tuple[str, dict]], given: bool = True) -> str:
    """Return the file in which ``key`` has this value, or "command line".

    ``given`` is False for a default that stands neither in a file nor on the command line.
    """
    for shown, values in reversed(sources):
        found = lookup(values, key)
        if isinstance(value, dict):
            # A section is merged from several files; the last that has it is named.
            if isinstance(found, dict):
                return shown
        elif found is not MISSING and repr(found) == repr(value):
            return shown
    if sources and (value is MISSING or not given):
        # What is missing belongs where its section was last given, else in the first file.
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
    """Return ``value`` in one short line, as it would stand in YAML's flow style."""
    if isinstance(value, float) and not math.isfinite(value):
        text = {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    elif isinstance(value, float):
        text = yaml_float(repr(value))
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{name}: {show(inner)}" for name, inner in value.items()) + "}"
    elif isinstance(value, list):
        text = "[" + ", ".join(show(inner) for inner in value) + "]"
    else:
        text = json.dumps(value, default=str)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 4] + " ..."


def shown_path(path: Path) -> str:
    """Return the path as the user would write it: relative where it is below the folder."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)
