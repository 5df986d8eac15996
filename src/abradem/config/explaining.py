"""Error texts for a single value: the problem, and what is allowed."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator, Mapping
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from abradem.config.declaration import Config
from abradem.config.fields import Section, interval_text, not_a_number
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
        "float_type": not_a_number(value, "a number", *_bounds(key)),
        "int_type": not_a_number(value, "a whole number", *_bounds(key)),
        "int_from_float": not_a_number(value, "a whole number", *_bounds(key)),
        "bool_type": "must be true or false",
        "finite_number": "must be a finite number",
        "string_type": "must be text" + _quotes(key, value),
        "string_pattern_mismatch": "has the wrong form",
        "literal_error": "is unknown",
        "list_type": "must be a list",
        "too_short": "must not be empty",
    }
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        return key, "is out of range", allowed
    return key, problems.get(kind, details["msg"]), allowed


def _quotes(key: Key, value: Any) -> str:
    """The hint to put a number in quotes, if that is accepted; else ""."""
    plain = isinstance(value, (int, float)) and not isinstance(value, bool)
    return "; put it in quotes" if plain and is_accepted(key, str(value)) else ""


def is_accepted(key: Key, value: Any) -> bool:
    """Whether a key, or an item of its list, may have a value, apart from the other keys."""
    field = _field(key)
    if field is None or not _is_of_field(key):
        return True
    kind: Any = field.annotation
    adapter = TypeAdapter(Annotated[kind, *field.metadata] if field.metadata else kind)
    # The item of a list that needs one, or two.
    tried = [[value], [value, value]] if isinstance(key[-1], int) else [value]
    for one in tried:
        try:
            adapter.validate_python(one, strict=True)
        except ValidationError:
            continue
        return True
    return False


def _is_of_field(key: Key) -> bool:
    """Whether a key is that of a field or of an item of its list, not one within a mapping."""
    names = key[:-1] if isinstance(key[-1], int) else key
    return all(isinstance(part, str) for part in names)


def allowed_for(key: Key) -> str:
    """Return a short text with what is allowed for a key; "" if the key is unknown."""
    field = _field(key)
    return allowed_text(field) if field else ""


def types_of(key: Key) -> set[str]:
    """Return the types that a value of ``key`` may have, as in a JSON schema; empty if unknown."""
    return {
        found.get("type", "string") for found in _schemas(key) if "type" in found or "enum" in found
    }


def _bounds(key: Key) -> tuple[float, float, bool]:
    """Return the bounds of the number of ``key``, and whether the lower one is excluded."""
    for found in _schemas(key):
        if found.get("type") in ("integer", "number"):
            low = found.get("minimum", found.get("exclusiveMinimum", -math.inf))
            return low, found.get("maximum", math.inf), "exclusiveMinimum" in found
    return -math.inf, math.inf, False


@cache
def _whole_schema() -> dict:
    return Config.model_json_schema()


def _schemas(key: Key) -> list[dict]:
    """Return the schemas of ``key``, one for each kind of value; empty if the key is unknown."""
    found = _alternatives(_whole_schema())
    for part in key:
        inner = []
        for one in found:
            if isinstance(part, int):
                inner.append(one.get("items"))
            else:
                other = one.get("additionalProperties")
                inner.append(one.get("properties", {}).get(part, other))
        found = [last for one in inner if isinstance(one, dict) for last in _alternatives(one)]
    return found


def _alternatives(schema: dict) -> list[dict]:
    if "$ref" in schema:
        return _alternatives(_whole_schema()["$defs"][schema["$ref"].rpartition("/")[2]])
    if "anyOf" in schema:
        return [last for one in schema["anyOf"] for last in _alternatives(one)]
    return [schema]


def _unknown_key(key: Key) -> tuple[str, str]:
    """Return the problem, with the most similar known key, and the keys allowed there."""
    *parents, name = key
    name = str(name)
    section = _section(tuple(parents)) or Config
    names = list(section.model_fields)
    if radius := _radius_meant(name, names):
        return f"unknown key, give half of the diameter as {radius}", ""
    close = [known for known in names if known.startswith(name + "_") or _stem(known) == name]
    close += difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        unit = _extra(section.model_fields[close[0]], "unit")
        return f"unknown key, did you mean {close[0]}{f' (in {unit})' if unit else ''}?", ""
    elsewhere = [path for path, _ in leaves() if path[-1] == name]
    if elsewhere:
        return f"unknown key here, did you mean {dotted(elsewhere[0])}?", ""
    return "unknown key", ", ".join(names)


def _radius_meant(name: str, names: list[str]) -> str:
    """Return the key of the radius for that of a diameter, or "" if none is meant."""
    plain = name.lower()
    if "diameter" not in plain:
        return ""
    wanted = _stem(plain.replace("diameter", "radius"))
    for known in names:
        if "radius" in known and (_stem(known) in (wanted, f"particle_{wanted}")):
            return known
    radii = [known for known in names if "radius" in known]
    if len(radii) == 1:
        return radii[0]
    elsewhere = [path for path, _ in leaves() if _stem(str(path[-1])) == wanted]
    return dotted(elsewhere[0]) if elsewhere else ""


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
