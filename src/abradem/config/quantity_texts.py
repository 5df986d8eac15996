"""Values of the configuration as text: a number with a unit, or the name of a material.

``particle_radius_mm: 2 cm``, ``plate_angle: [0°, 45°]`` and ``particle_density: granite`` are read
as numbers in the unit of the key.
"""

from __future__ import annotations

from typing import Any

from abradem.config.materials import (
    PARTICLE_MATERIALS,
    PLATE_MATERIALS,
    material_name,
    similar_material,
)
from abradem.units import has_unit, parse_quantity

PATTERN = r"^[-+−]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+−]?[0-9]+)?\s*[^\s0-9.,eE+-].*$"
"""Regular expression for the schema: a number with something behind it."""


def read_quantity(value: Any, unit: str) -> Any:
    """Return a value, or a list of values, with texts that have a unit as numbers.

    Parameters
    ----------
    value
    unit : str
        Unit of the key.

    Raises
    ------
    ValueError
        If a unit is unknown or of another dimension.
    """
    if isinstance(value, list):
        return [read_quantity(one, unit) for one in value]
    if isinstance(value, str) and unit and has_unit(value) and not _is_bare_number(value):
        return parse_quantity(value, unit)
    return value


def _is_bare_number(text: str) -> bool:
    """Whether a text such as "1e5" or "1_000" is a number that YAML reads as text."""
    return not any((char.isalpha() and char not in "eExXoObB") or char in "°%/" for char in text)


def of_material(value: Any, name: str) -> float | None:
    """Return a quantity of the material that a text names, in the unit of the quantity, or None.

    Raises
    ------
    ValueError
        If the material does not have the quantity.
    """
    material = material_name(value) if isinstance(value, str) else None
    if material is None:
        return None
    values = {**PLATE_MATERIALS, **PARTICLE_MATERIALS}[material].values
    if name not in values:
        raise ValueError(f"{material} has no {name} (it has {', '.join(values)})")
    return values[name]


def material_meant(value: Any, name: str) -> str:
    """Return the material with a quantity whose name a text resembles, or ""."""
    if not isinstance(value, str):
        return ""
    materials = {**PLATE_MATERIALS, **PARTICLE_MATERIALS}
    known = [material for material, preset in materials.items() if name in preset.values]
    return similar_material(value, known)


def with_texts(schema: dict) -> dict:
    """Return the schema of the configuration with the texts that its numbers may be."""
    definitions = dict(schema.get("$defs", {}))
    for name, definition in definitions.items():
        materials = name == "Ranges"
        definitions[name] = {
            **definition,
            "properties": {
                key: _or_text(found, materials) if "unit" in found or materials else found
                for key, found in definition.get("properties", {}).items()
            },
        }
    return {**schema, "$defs": definitions}


def _or_text(schema: Any, materials: bool) -> Any:
    if isinstance(schema, list):
        return [_or_text(one, materials) for one in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") == "number":
        text: list[dict] = [{"type": "string", "pattern": PATTERN}]
        if materials:
            text.append({"enum": sorted({*PARTICLE_MATERIALS, *PLATE_MATERIALS})})
        kept = {key: value for key, value in schema.items() if key in _OF_NUMBER}
        rest = {key: value for key, value in schema.items() if key not in _OF_NUMBER}
        return {**rest, "anyOf": [kept, *text]}
    return {
        key: _or_text(value, materials) if key in ("anyOf", "items") else value
        for key, value in schema.items()
    }


_OF_NUMBER = {"type", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}
