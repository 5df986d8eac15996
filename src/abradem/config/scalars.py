"""Numbers and words as they are written, and what YAML 1.1 makes of them.

YAML 1.1, which Snakemake and PyYAML read, turns some words into other values: ``010`` into 8,
``1_000`` into 1000, ``1:30`` into 90, ``no`` into false, ``2026-11-27`` into a date. It reads
other numbers, such as ``1e5``, ``-.5`` and ``0o10``, as text. A configuration in which a word and
its value differ is refused with the word as it is written.
"""

from __future__ import annotations

import datetime
import json
import math
import re
from collections.abc import Callable, Collection
from decimal import Decimal
from typing import Any

STUDY_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"
"""The name of a study is a folder under results/, so separators, dots and blanks are excluded."""

_PLAIN_WHOLE = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_PLAIN_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_WITH_BASE = re.compile(r"[-+]?0[xXoObB][0-9a-fA-F_]+")

_SCALARS = {"string", "integer", "number", "boolean"}

_LARGEST_EXPONENT = 30
"""Numbers beyond ten to this power are not written out in a hint."""


def yaml_float(text: str) -> str:
    """Return the text of a number as YAML 1.1 needs it: 1e-10 is read as text, 1.0e-10 is not."""
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text
    sign = "" if exponent[0] in "+-" else "+"
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{sign}{exponent}"


def number_meant(text: str) -> int | float | None:
    """Return the number that a text stands for to a reader, or None if it is no number."""
    text = text.strip()
    try:
        if _WITH_BASE.fullmatch(text):
            return int(text, 0)
        plain = re.sub(r"(?<=[0-9])_(?=[0-9])", "", text)
        if not _PLAIN_NUMBER.fullmatch(plain):
            return None
        exact = Decimal(plain)
        if exact == exact.to_integral_value() and abs(exact.adjusted()) <= _LARGEST_EXPONENT:
            return int(exact) if exact else 0
        number = float(plain)
    except (ValueError, ArithmeticError):
        return None
    return number if math.isfinite(number) else None


def written(number: int | float, whole: bool) -> str:
    """Return a number as it must be written in a configuration."""
    return str(number) if whole and isinstance(number, int) else yaml_float(repr(float(number)))


def misread(text: str, value: Any, wanted: Collection[str], accepted: Callable[[Any], bool]) -> str:
    """Return why a word of a file must be written otherwise, or "".

    Parameters
    ----------
    text : str
        The word as it is written, without quotes.
    value
        What YAML 1.1 makes of it.
    wanted : collection of str
        Types of the key as in a JSON schema: string, integer, number, boolean, null.
    accepted : callable
        Whether the key may have a value; no other value is proposed.
    """
    if value is None or isinstance(value, str) or _SCALARS.isdisjoint(wanted):
        return ""
    of_number = not {"integer", "number"}.isdisjoint(wanted)
    if isinstance(value, bool):
        if "boolean" in wanted:
            return ""
        # The words true and false are no riddle; that they are no number is said elsewhere.
        if of_number and text in ("true", "false"):
            return ""
    elif not isinstance(value, (datetime.date, datetime.datetime)):
        finite = isinstance(value, int) or math.isfinite(value)
        pattern = _PLAIN_WHOLE if isinstance(value, int) else _PLAIN_NUMBER
        if of_number or "string" not in wanted:
            if not finite or pattern.fullmatch(text):
                return ""
        elif text == (str(value) if isinstance(value, int) else yaml_float(repr(value))):
            return ""
    instead = _instead(text, value, wanted, accepted)
    return f"YAML reads this as {_called(value)}{'; ' if instead else ''}{instead}"


def _called(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return f"the number {written(value, isinstance(value, int))}"
    return "a date"


def _instead(
    text: str, value: Any, wanted: Collection[str], accepted: Callable[[Any], bool]
) -> str:
    """What to write instead, or "" if nothing is known that would be accepted."""
    if {"integer", "number"}.isdisjoint(wanted):
        if "boolean" in wanted:
            return "write true or false"
        return f"write {json.dumps(text, ensure_ascii=False)} in quotes" if accepted(text) else ""
    whole = "integer" in wanted
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "write a whole number" if whole else "write a number"
    meant = number_meant(text)
    proposed = []
    if meant is not None and accepted(meant):
        proposed.append(written(meant, isinstance(meant, int)))
    if meant != value and accepted(value):
        proposed.append(f"{written(value, isinstance(value, int))} if that is meant")
    return f"write {', or '.join(proposed)}" if proposed else ""
