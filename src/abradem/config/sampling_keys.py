"""Keys of `sampling`: ranges and draw of the cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, WithJsonSchema, create_model

from abradem.config.fields import Section, interval_text, number_text, require_number, setting
from abradem.config.quantity_texts import material_meant, of_material
from abradem.quantities import SAMPLED, Quantity
from abradem.words.labels import LABELS


def _range_field(row: Quantity) -> tuple[Any, Any]:
    """Return annotation and field for the range of a quantity, in the unit of its key."""
    low, high = (_from_si(row, bound) for bound in row.limits)

    def check(value: Any) -> tuple[float, float]:
        bounds = value if isinstance(value, (list, tuple)) else [value, value]
        if len(bounds) != 2:
            raise ValueError("must be one number or two, [lower bound, upper bound]")
        found = [of_material(bound, row.name) for bound in bounds]
        bounds = [
            bound if of is None else _from_si(row, of)
            for bound, of in zip(bounds, found, strict=True)
        ]
        for bound in bounds:
            if material := material_meant(bound, row.name):
                raise ValueError(f"must be a number; did you mean {material}?")
            require_number(bound, low, high)
            if not low <= bound <= high:
                raise ValueError(f"{number_text(bound)} is out of range{_unit_slip(row, bounds)}")
        if bounds[0] > bounds[1]:
            raise ValueError("lower bound must not exceed the upper bound")
        return float(bounds[0]), float(bounds[1])

    number = {"type": "number", "minimum": low, "maximum": high}
    pair = {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    annotation = Annotated[Any, PlainValidator(check), WithJsonSchema({"anyOf": [number, pair]})]
    unit = "" if row.config_unit == "1" else row.config_unit
    default = tuple(_from_si(row, bound) for bound in row.paper_range)
    help_text = f"{row.symbol}, {LABELS[row.name].long_name}."
    return annotation, setting(
        default, help_text, unit=unit, allowed=interval_text(low, high, unit)
    )


def _from_si(row: Quantity, value: float) -> float:
    """Return ``value`` in the unit of its key, without the rounding error of 40e-3 / 1e-3."""
    return float(f"{value / row.config_factor:.12g}")


def _unit_slip(row: Quantity, bounds: Sequence[float]) -> str:
    """Return a hint if ``bounds`` are plausible in the SI unit instead of the unit of the key."""
    low, high = row.limits
    if not row.config_suffix or not all(
        isinstance(bound, (int, float)) and low <= bound <= high for bound in bounds
    ):
        return ""
    meant = ", ".join(number_text(_from_si(row, bound)) for bound in bounds)
    return f"; the key is in {row.config_unit}, for values in {row.unit} write [{meant}]"


_FIELDS: dict[str, Any] = {row.config_key: _range_field(row) for row in SAMPLED}

_RANGES: Any = create_model("Ranges", __base__=Section, **_FIELDS)


class Ranges(_RANGES):
    """Ranges of the 14 sampled quantities.

    Each is [lower bound, upper bound], or one number for a fixed quantity. A number may have a
    unit (``2 cm``), and the name of a material, such as ``granite``, stands for its value
    (``abradem predict --help`` lists them). The default of each key is the range of the paper.
    """


class Sampling(Section):
    """Which parameter sets are simulated."""

    method: Literal["lhs", "sobol", "uniform"] = setting(
        "lhs",
        "How the parameter sets of a block are drawn: Latin hypercube (covers the range of each "
        "quantity evenly), scrambled Sobol sequence (fills the space evenly, best with 2^n cases "
        "in total) or independent uniform random numbers.",
    )
    blocks: int = setting(
        2,
        "Number of blocks. More blocks add cases; all existing cases stay the same.",
        ge=1,
        le=10_000,
    )
    cases_per_block: int = setting(
        100,
        "Cases in one block. If it is changed, all blocks are drawn again; to enlarge a study, add "
        "blocks instead.",
        ge=1,
        le=100_000,
    )
    ranges: Ranges = Field(
        default_factory=Ranges, description="Ranges of the 14 sampled quantities."
    )
