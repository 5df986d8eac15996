"""Error texts for a single value: the problem, and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from abradem.config.declaration import Config, Section, interval_text, not_a_number
from abradem.config.keys import Key, dotted


def explain(details: Mapping) -> tuple[Key, str, str]:
    """Return key, problem and allowed values for one error of pydantic."""
    key: Key = details["loc"]
    value = details["input"]
    kind = details["type"]
    if kind == "extra_forbidden":
        return key, *_unknown_key(key)
    field = _field(key)
    allowed = allowed_text(field) if field else ""
    if kind == "missing":
        return key, "is required", allowed
    if kind == "value_error":
        return key, str(details["ctx"]["error"]), allowed
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        section = _section(key)
        names = ", ".join(section.model_fields) if section else ""
        if value is None:
            return key, "is an empty section; give keys or remove the line", names
        return key, "must be a section of keys", names
    problems = {
        "float_type": not_a_number(value, "number"),
        "int_type": not_a_number(value, "whole number"),
        "int_from_float": "must be a whole number",
        "finite_number": "must be a finite number",
        "string_type": "must be text; put it in quotes",
        "string_pattern_mismatch": "has the wrong form",
        "literal_error": "is unknown",
        "list_type": "must be a list",
        "too_short": "must not be empty",
    }
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        return key, "is out of range", allowed
    return key, problems.get(kind, details["msg"]), allowed


def _unknown_key(key: Key) -> tuple[str, str]:
    """Return the problem, with the most similar known key, and the keys allowed there."""
    *parents, name = key
    name = str(name)
    section = _section(tuple(parents)) or Config
    names = list(section.model_fields)
    close = [known for known in names if known.startswith(name + "_") or _stem(known) == name]
    close += difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        unit = _extra(section.model_fields[close[0]], "unit")
        return f"unknown key, did you mean {close[0]}{f' (in {unit})' if unit else ''}?", ""
    elsewhere = [path for path, _ in leaves() if path[-1] == name]
    if elsewhere:
        return f"unknown key here, did you mean {dotted(elsewhere[0])}?", ""
    return "unknown key", ", ".join(names)


def _stem(name: str) -> str:
    """Return a key without its suffix for the unit."""
    for suffix in ("_gpa", "_mm", "_kg_s", "_per_s", "_s"):
        if name.endswith(suffix):
            return name.removesuffix(suffix)
    return name


def section_class(annotation: Any) -> type[Section] | None:
    """Return the section class if the annotation is a section, or a section or null."""
    for candidate in (annotation, *get_args(annotation)):
        if isinstance(candidate, type) and issubclass(candidate, Section):
            return candidate
    return None


def _section(key: Key) -> type[Section] | None:
    section: type[Section] | None = Config
    for part in key:
        field = section.model_fields.get(str(part)) if section else None
        section = section_class(field.annotation) if field else None
    return section


def _field(key: Key) -> FieldInfo | None:
    """Return the field of ``key``; for an item of a list, the field of the list."""
    names = [part for part in key if isinstance(part, str)]
    section = _section(tuple(names[:-1]))
    return section.model_fields.get(names[-1]) if section and names else None


def leaves(section: type[Section] = Config, above: Key = ()) -> Iterator[tuple[Key, FieldInfo]]:
    """Yield every key with a value and its field, in order."""
    for name, field in section.model_fields.items():
        inner = section_class(field.annotation)
        if inner is not None:
            yield from leaves(inner, (*above, name))
        else:
            yield (*above, name), field


def _extra(field: FieldInfo, name: str) -> str:
    extra = field.json_schema_extra
    return str(extra.get(name, "")) if isinstance(extra, dict) else ""


def allowed_text(field: FieldInfo) -> str:
    """Return a short text with the allowed values of a field."""
    text = _extra(field, "allowed")
    if text:
        return text
    annotation = field.annotation
    optional = False
    if get_origin(annotation) in (Union, UnionType):
        optional = True
        annotation = next(part for part in get_args(annotation) if part is not NoneType)
    if get_origin(annotation) is Literal:
        text = ", ".join(get_args(annotation))
    elif section_class(annotation):
        text = "a section of keys"
    else:
        bounds: dict[str, float] = {}
        for constraint in _constraints(field):
            for side in ("gt", "ge", "lt", "le"):
                if hasattr(constraint, side):
                    bounds[side] = getattr(constraint, side)
        unit = _extra(field, "unit")
        low = bounds["ge" if "ge" in bounds else "gt"]
        high = bounds["le" if "le" in bounds else "lt"]
        text = interval_text(low, high, unit, above="gt" in bounds)
    return text + (" or null" if optional else "")


def _constraints(field: FieldInfo) -> list:
    """Return the bounds of a number, or of the number in "number or null"."""
    found = list(field.metadata)
    for part in get_args(field.annotation):
        found += getattr(part, "__metadata__", ())
    return found
