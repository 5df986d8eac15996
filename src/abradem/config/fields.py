"""What the keys of all sections are made of: base class, help texts, units and limits."""

from __future__ import annotations

import math
import unicodedata
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)

from abradem.config.quantity_texts import read_quantity
from abradem.config.scalars import number_meant, written, yaml_float
from abradem.quantities import Quantity

_BIDIRECTIONAL = {*range(0x202A, 0x202F), *range(0x2066, 0x206A)}

"""Characters that turn the direction of the text that follows."""


def check_text(value: str) -> str:
    if not value.strip():
        raise ValueError("must not be empty")
    for char in value:
        if unicodedata.category(char) in ("Cc", "Cs", "Zl", "Zp") or ord(char) in _BIDIRECTIONAL:
            raise ValueError(f"contains the control character U+{ord(char):04X}")
    return value


Text = Annotated[
    str, AfterValidator(check_text), WithJsonSchema({"type": "string", "pattern": r"\S"})
]

"""A name, a title or a path: one line with something in it."""


class Section(BaseModel):
    # Strict: a number in quotes is a mistake, and true is not 1.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, value: Any, info: ValidationInfo) -> Any:
        """Read "2 cm" as a number in the unit of its key."""
        extra = cls.model_fields[str(info.field_name)].json_schema_extra
        unit = extra.get("unit", "") if isinstance(extra, dict) else ""
        return read_quantity(value, str(unit))


def setting(default: Any, description: str, *, unit: str = "", allowed: str = "", **bounds) -> Any:
    """Return a field with its help text, its unit and, if bounds do not suffice, its limits."""
    given = {"unit": unit, "allowed": allowed}
    extra: dict[str, Any] = {name: text for name, text in given.items() if text}
    return Field(default, description=description, json_schema_extra=extra or None, **bounds)


def interval_text(low: float, high: float, unit: str = "", above: bool = False) -> str:
    first = f"above {number_text(low)} up to" if above else f"{number_text(low)} ..."
    return f"{first} {number_text(high)}{f' {unit}' if unit else ''}"


def number_text(value: float) -> str:
    return str(value) if isinstance(value, int) else yaml_float(f"{value:g}")


def to_si(row: Quantity, value: float) -> float:
    """Return ``value`` of the configuration in the unit of the quantity in tables."""
    if row.config_factor < 1.0:
        # 7 / 1000 is the double nearest to 0.007; 7 * 1e-3 need not be.
        return value / round(1.0 / row.config_factor)
    return value * row.config_factor


def require_number(value: Any, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(not_a_number(value, "a number", low, high))
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("must be a finite number")


def not_a_number(
    value: Any, wanted: str, low: float = -math.inf, high: float = math.inf, above: bool = False
) -> str:
    """Return why ``value`` is not a number, with a hint if it looks like one.

    The number of the hint is accepted: it is within the bounds, and YAML reads it as a number.

    Parameters
    ----------
    value
    wanted : str
        ``a number``, ``a whole number`` or ``auto or a whole number``.
    low, high : float
        Bounds of the key.
    above : bool
        Whether the lower bound itself is not allowed.
    """
    whole = "whole" in wanted
    if isinstance(value, float) and whole and value.is_integer():
        meant: int | float | None = int(value)
    else:
        meant = number_meant(value) if isinstance(value, str) else None
    if meant is None:
        if isinstance(value, str) and number_meant(value.replace(",", ".", 1)) is not None:
            return f"must be {wanted}, with a decimal point instead of a comma"
        return f"must be {wanted}"
    if not low <= meant <= high or (above and meant == low):
        return f"must be {wanted} in the allowed range"
    if whole and not isinstance(meant, int):
        return f"must be {wanted}"
    if not isinstance(value, str):
        return f"must be {wanted}; write {meant}"
    same = value.strip() == written(meant, isinstance(meant, int))
    if same:
        return f"must be {wanted}, not text; write it without quotes"
    return f"must be {wanted}; YAML reads this as text, write {written(meant, whole)}"
