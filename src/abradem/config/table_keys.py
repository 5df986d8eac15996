"""Keys of `dataset` and `calibration`: tables from elsewhere, and the search that explains one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, PlainValidator, WithJsonSchema

from abradem import quantities
from abradem.config.fields import Section, Text, check_text, setting
from abradem.config.learning_keys import TARGETS
from abradem.config.quantity_texts import read_quantity
from abradem.config.simulation_keys import Simulation


def _check_columns(value: Any) -> dict[str, str | list[str]]:
    if not isinstance(value, Mapping):
        raise ValueError("must map names of quantities to columns of the table")
    for name, column in value.items():
        pair = isinstance(column, (list, tuple))
        parts = column if pair else [column]
        if not all(isinstance(part, str) and part for part in parts) or (pair and len(parts) != 2):
            raise ValueError(f"{name}: must be a column name, or [column, unit]")
        for part in (str(name), *parts):
            check_text(part)
    return {str(name): column for name, column in value.items()}


_COLUMNS_SCHEMA = WithJsonSchema(
    {
        "type": "object",
        "additionalProperties": {
            "anyOf": [
                {"type": "string"},
                {
                    "type": "array",
                    "items": {"type": "string"},
                    "minItems": 2,
                    "maxItems": 2,
                },
            ]
        },
    }
)


def _check_search(value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError("must map keys of simulation to what they may be")
    return {str(key): _in_units(str(key), values) for key, values in value.items()}


def _in_units(names: str, values: Any) -> Any:
    """Return what the keys of a search may be, with texts that have a unit as numbers."""
    keys = [key.strip() for key in names.split(",")]
    units = {_unit_of(key) for key in keys}
    given = values if isinstance(values, Mapping) else {"": values}
    try:
        read = {name: read_quantity(one, next(iter(units))) for name, one in given.items()}
    except ValueError as error:
        raise ValueError(f"{names}: {error}") from None
    if len(units) > 1 and read != given:
        raise ValueError(f"{names}: keys of different units share a value, give it without a unit")
    return read if isinstance(values, Mapping) else read[""]


def _unit_of(key: str) -> str:
    """Return the unit of a dotted key of `simulation`; "" if it has none or is unknown."""
    _, *path = key.split(".")
    section: Any = Simulation
    unit = ""
    for part in path:
        field = getattr(section, "model_fields", {}).get(part)
        if field is None:
            return ""
        extra = field.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        kinds = (field.annotation, *get_args(field.annotation))
        section = next((kind for kind in kinds if hasattr(kind, "model_fields")), None)
    return unit


_SEARCH_SCHEMA = WithJsonSchema(
    {"type": "object", "additionalProperties": {"anyOf": [{"type": "array"}, {"type": "object"}]}}
)

STATED, UNKNOWN = "stated", "unknown"


class Dataset(Section):
    """Your own table instead of simulations."""

    external: Text | None = setting(
        None,
        "CSV or Parquet file. Learning, figures and report then use this table, and nothing is "
        "simulated. With null the data set is simulated.",
        allowed="the path of a file or null",
    )
    columns: Annotated[Any, PlainValidator(_check_columns), _COLUMNS_SCHEMA] = setting(
        {},
        "Column of the table for each quantity with a different column name, or [column, unit] if "
        "the unit differs too. The names and units of the published table of the paper are known.",
        allowed="{name: column} or {name: [column, unit]}",
    )
    jet: Literal["stated", "unknown"] = setting(
        UNKNOWN,
        "Whether simulation.plate, simulation.factory (feed, patch, fall height) and "
        "simulation.gravity are those of the table. Unknown: the models use them as a reference "
        "alone, and the surrogate says so.",
    )
    rate: Literal["stated", "unknown"] = setting(
        UNKNOWN,
        "Whether learning.target says what the wear rate of the table is: its measure and its "
        "place on the plate. Unknown: figures and predictions do not name them.",
    )


class Calibration(Section):
    """A search for the set-ups that explain a table of wear rates, instead of a study.

    The other keys give what is known of the set-up.
    """

    table: str | None = setting(
        None,
        "CSV or Parquet file with the sampled quantities and a wear rate; null: no search.",
        allowed="the path of a file or null",
    )
    columns: Annotated[Any, PlainValidator(_check_columns), _COLUMNS_SCHEMA] = setting(
        {},
        "Columns of the table with other names, as for dataset.columns.",
        allowed="{name: column} or {name: [column, unit]}",
    )
    target: Literal[TARGETS] = setting(  # type: ignore[valid-type]  # names of a table
        quantities.TARGET.name, "Column of the table to explain."
    )
    search: Annotated[Any, PlainValidator(_check_search), _SEARCH_SCHEMA] = setting(
        {},
        "What is unknown: for each key of simulation (or keys, separated by commas, that share a "
        "value) a list of values, or bounds with a scale (linear or log).",
        allowed="{key: [value, value]} or {key: {from: low, to: high, scale: log}}",
    )
    element_sizes_mm: list[Annotated[float, Field(gt=0.0, le=100_000.0)]] = setting(
        [10.0, 20.0, 30.0, 50.0],
        "Edges of the elements of the statistics; all are tried, from one simulation.",
        allowed="a list of whole multiples of the facets",
        min_length=1,
    )
    constant: bool = setting(
        False,
        "true: set-ups are judged after a constant factor is fitted; false: without one.",
        allowed="true or false",
    )
    least_radius_mm: float = setting(
        0.0, "Rows with smaller particles are left out.", unit="mm", ge=0.0, le=100.0
    )
    leave_out: list[Annotated[int, Field(ge=0)]] = setting(
        [],
        "Rows that are left out, by case_id or, without that column, by their number from 0: those "
        "known to be wrong.",
        allowed="a list of whole numbers from 0 on",
    )
    held_out_every: int = setting(
        4,
        "Every so many rows, in the order of their wear rate, one is held out; 0: none.",
        ge=0,
        le=1000,
    )
    trials: int = setting(64, "Number of set-ups drawn.", ge=1, le=100_000)
    keep: float = setting(
        0.25, "Share of the set-ups that goes on to the next rung.", gt=0.0, le=1.0
    )
    rows: list[Annotated[int, Field(ge=4, le=1_000_000)]] = setting(
        [16, 40, 1_000_000],
        "Rows of the table in each rung; more than there are: all.",
        allowed="a list of whole numbers from 4 on",
        min_length=1,
    )
    replicates: list[Annotated[int, Field(ge=1, le=1000)]] = setting(
        [2, 2, 4],
        "Simulations of each row in each rung, with different seeds.",
        allowed="a list of whole numbers, as many as rows",
        min_length=1,
    )
