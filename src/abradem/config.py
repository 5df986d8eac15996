"""The configuration: what may stand in it, what each key means, and what is wrong with one.

One declaration, `Config`, is the source of the check, of the schema
(``workflow/schemas/config.schema.json``) and of the documentation (``docs/config.md``);
``python -m abradem.config --write`` regenerates both. Every problem of a configuration is
reported as one line ``file: key: value: what is wrong (allowed ...)``.

The module is light (pydantic and PyYAML), as the Snakefile imports it on every start.
"""

from __future__ import annotations

import difflib
import itertools
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import yaml
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    WithJsonSchema,
    create_model,
)
from pydantic.fields import FieldInfo

from abradem import parameters
from abradem.parameters import READINGS, SAMPLED, STATISTICS, Quantity

COMMAND_LINE = "command line"
"""Named instead of a file where a value came through ``--config``."""

SCHEMA_FILE = "workflow/schemas/config.schema.json"
DOCUMENTATION_FILE = "docs/config.md"

STUDY_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"
"""A study's name is a folder under results/, so it holds no separators, dots or blanks."""

_DEEPEST = 8
"""Levels of nesting beyond which a file cannot be a configuration (or refers to itself)."""

_LARGEST_FILE = 1_000_000
"""Bytes of a file beyond which it cannot be a configuration."""

_MOST_VALUES = 20_000
"""Values beyond which a file cannot be a configuration; a few anchors can stand for billions."""

_SHOWN = 60
"""Characters of a wrong value that are repeated in its line."""

_MISSING = object()

Key = tuple[str | int, ...]


class ConfigError(ValueError):
    """One or several problems of a configuration; its text is one line for each."""

    def __init__(self, problems: Sequence[str]):
        self.problems = list(problems)
        super().__init__("\n".join(self.problems))


# Declaration -----------------------------------------------------------------------------


class _Section(BaseModel):
    # Strict: a number in quotes is a mistake, and true is not 1.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def _key(default: Any, description: str, *, unit: str = "", allowed: str = "", **bounds) -> Any:
    """Return a field with its help text, its unit and, where bounds cannot say it, its limits."""
    extra = {name: text for name, text in (("unit", unit), ("allowed", allowed)) if text}
    return Field(default, description=description, json_schema_extra=extra or None, **bounds)


def _range_field(row: Quantity) -> tuple[Any, Any]:
    """Return annotation and field of one quantity's range, in the configuration's unit."""
    low, high = (_from_si(row, bound) for bound in row.limits)

    def check(value: Any) -> tuple[float, float]:
        bounds = value if isinstance(value, (list, tuple)) else [value, value]
        if len(bounds) != 2:
            raise ValueError("must be one number or two, [lower bound, upper bound]")
        for bound in bounds:
            _require_number(bound)
            if not low <= bound <= high:
                raise ValueError(f"{_number(bound)} is out of range{_unit_slip(row, bounds)}")
        if bounds[0] > bounds[1]:
            raise ValueError("lower bound must not exceed the upper bound")
        return float(bounds[0]), float(bounds[1])

    number = {"type": "number", "minimum": low, "maximum": high}
    pair = {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    annotation = Annotated[Any, PlainValidator(check), WithJsonSchema({"anyOf": [number, pair]})]
    unit = "" if row.config_unit == "1" else row.config_unit
    default = tuple(_from_si(row, bound) for bound in row.paper_range)
    help_text = f"{row.symbol}, {row.long_name}."
    return annotation, _key(default, help_text, unit=unit, allowed=_interval(low, high, unit))


def _interval(low: float, high: float, unit: str = "", above: bool = False) -> str:
    first = f"above {_number(low)} up to" if above else f"{_number(low)} ..."
    return f"{first} {_number(high)}{f' {unit}' if unit else ''}"


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else _yaml_float(f"{value:g}")


def _yaml_float(text: str) -> str:
    """Return a number's text such that YAML 1.1 reads a number: 1e-10 is text, 1.0e-10 not."""
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text
    sign = "" if exponent[0] in "+-" else "+"
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{sign}{exponent}"


def _from_si(row: Quantity, value: float) -> float:
    """Return ``value`` in the configuration's unit, without the noise of 40e-3 / 1e-3."""
    return float(f"{value / row.config_factor:.12g}")


def _to_si(row: Quantity, value: float) -> float:
    """Return ``value`` of the configuration in the table's unit."""
    if row.config_factor < 1.0:
        # 7 / 1000 is the double nearest to 0.007; 7 * 1e-3 need not be.
        return value / round(1.0 / row.config_factor)
    return value * row.config_factor


def _unit_slip(row: Quantity, bounds: Sequence[float]) -> str:
    """Return a hint if ``bounds`` make sense in the table's unit instead of the key's."""
    low, high = row.limits
    if not row.config_suffix or not all(
        isinstance(bound, (int, float)) and low <= bound <= high for bound in bounds
    ):
        return ""
    meant = ", ".join(_number(_from_si(row, bound)) for bound in bounds)
    return f"; the key is in {row.config_unit}, for values in {row.unit} write [{meant}]"


def _require_number(value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(_not_a_number(value, "number"))
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("must be a finite number")


def _not_a_number(value: Any, wanted: str) -> str:
    """Say why ``value`` is no number; text that looks like one gets a hint."""
    if isinstance(value, str):
        try:
            number = float(value)
        except ValueError:
            pass
        else:
            if math.isfinite(number) and "e" in value.lower():
                written = _yaml_float(value.strip().lower())
                return f"must be a {wanted}; YAML reads this as text, write {written}"
            return f"must be a {wanted}, not text; write it without quotes"
    return f"must be a {wanted}"


class Ranges(
    create_model(
        "Ranges", __base__=_Section, **{row.config_key: _range_field(row) for row in SAMPLED}
    )
):
    """Ranges of the 14 sampled quantities.

    Each is [lower bound, upper bound], or one number to keep the quantity fixed. A key left
    out takes the paper's range.
    """


class Sampling(_Section):
    """Which parameter sets are simulated."""

    method: Literal["lhs", "sobol", "uniform"] = _key(
        "lhs",
        "How the sets of a block are drawn: Latin hypercube (every quantity evenly covered), "
        "scrambled Sobol sequence (evenly filled space, best with 2^n cases in all) or "
        "independent uniform numbers.",
    )
    blocks: int = _key(
        2,
        "Number of blocks. More blocks add cases and leave all earlier ones as they were.",
        ge=1,
        le=10_000,
    )
    cases_per_block: int = _key(
        100,
        "Cases in one block. Changing it draws every block anew; to grow a study add blocks.",
        ge=1,
        le=100_000,
    )
    ranges: Ranges = Field(
        default_factory=Ranges, description="Ranges of the 14 sampled quantities."
    )


class Plate(_Section):
    """The plate that wears: flat, tilted by the plate angle about its centre."""

    length_mm: float = _key(300.0, "Extent along the slope.", unit="mm", gt=0.0, le=100_000.0)
    width_mm: float = _key(300.0, "Extent across the slope.", unit="mm", gt=0.0, le=100_000.0)
    facet_size_mm: float = _key(
        10.0,
        "Largest edge of a wear facet; the plate is divided evenly. The worst facet and the "
        "99th percentile depend on it.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )


class Factory(_Section):
    """Where the particles start and how many."""

    patch_length_mm: float = _key(
        100.0,
        "Extent of the patch of particle centres along its own slope.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    patch_width_mm: float = _key(
        100.0,
        "Extent of the patch of particle centres across its slope.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    fall_height_mm: float = _key(
        250.0,
        "Height of the patch's centre above the plate's centre.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    feed: Literal["mass", "number"] = _key(
        "mass", "Which rate is held: mass per time or particles per time."
    )
    mass_rate_kg_s: float | None = _key(
        4.0, "Mass rate with feed: mass, otherwise null.", unit="kg/s", gt=0.0, le=1e6
    )
    number_rate_per_s: float | None = _key(
        None, "Particle rate with feed: number, otherwise null.", unit="1/s", gt=0.0, le=1e9
    )


class Contact(_Section):
    """Options of the contact law that the published law leaves open."""

    normal: Literal["exact_e", "nominal_clipped", "nominal_attractive"] = _key(
        "exact_e",
        "exact_e: never attractive, an isolated impact rebounds at exactly e. nominal_clipped: "
        "the textbook damping, never attractive. nominal_attractive: the textbook damping, "
        "attraction at the end of a contact allowed.",
    )
    tangential: Literal["incremental", "displacement"] = _key(
        "incremental",
        "incremental: the spring's force grows step by step. displacement: stiffness times "
        "accumulated displacement, as one commercial code documents.",
    )
    tangential_damping: Literal["capped", "none", "uncapped"] = _key(
        "capped",
        "capped: Coulomb's law limits spring plus damping. uncapped: only the spring. none: "
        "no tangential damping.",
    )


class PairInteraction(_Section):
    """Contact between particles, where it differs from particle on plate."""

    restitution: float = _key(..., "Coefficient of restitution.", ge=0.05, le=1.0)
    static_friction: float = _key(..., "Coefficient of static friction.", ge=0.0, le=2.0)
    rolling_friction: float = _key(..., "Coefficient of rolling friction.", ge=0.0, le=1.0)


class Stop(_Section):
    """When a simulation ends."""

    window_s: float = _key(
        5.0,
        "Steady time over which facets are compared, and the least steady time simulated.",
        unit="s",
        gt=0.0,
        le=10_000.0,
    )
    max_time_s: float = _key(
        60.0, "Longest simulated time of a case.", unit="s", gt=0.0, le=100_000.0
    )
    target_stderr: float = _key(
        0.02,
        "Relative standard error of the plate-mean wear rate at which a case may end.",
        gt=0.0,
        le=1.0,
    )
    sample_interval_s: float = _key(
        0.02, "Time between samples of the worn volume.", unit="s", gt=0.0, le=100.0
    )


class Export(_Section):
    """Snapshots of positions, velocities, contact forces and wear; large, off by default."""

    cases: list[Annotated[int, Field(ge=0)]] = _key(
        [],
        "Cases to export; an empty list exports nothing.",
        allowed="a list of case numbers from 0",
    )
    interval_s: float = _key(0.01, "Simulated time between snapshots.", unit="s", gt=0.0, le=1000.0)


def _check_cases_per_job(value: Any) -> str | int:
    if value == "auto":
        return value
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError("must be auto or a whole number")
    if not 1 <= value <= 100_000:
        raise ValueError("is out of range")
    return value


class Simulation(_Section):
    """Everything about a simulation that is not sampled."""

    cases_per_job: Annotated[
        str | int,
        PlainValidator(_check_cases_per_job),
        WithJsonSchema(
            {"anyOf": [{"const": "auto"}, {"type": "integer", "minimum": 1, "maximum": 100_000}]}
        ),
    ] = _key(
        "auto",
        "Cases that one job simulates. Starting a job costs seconds, so several share one; "
        "1 gives each case its own job.",
        allowed="auto or 1 ... 100000",
    )
    stepping: Literal["islands", "synchronous"] = _key(
        "islands",
        "How time advances: islands skips the time in which nothing touches, synchronous steps "
        "every particle in every step. Both give the same results, bit for bit.",
    )
    time_step_rayleigh_fraction: float = _key(
        0.15,
        "Time step as a share of the particle's Rayleigh time. At 0.15 an impact near 5 m/s takes "
        "about 21 steps, and total is biased by at most 0.8 % averaged over the angle of impact "
        "(sliding 1.0 %, friction 0.1 %); at the paper's 0.2 by 1.3 % (2.6 %, 0.2 %).",
        ge=0.001,
        le=0.4,
    )
    plate: Plate = Field(default_factory=Plate, description="The plate that wears.")
    factory: Factory = Field(
        default_factory=Factory, description="Where the particles start and how many."
    )
    removal_depth_mm: float = _key(
        100.0,
        "Particles are removed this far below the plate's lowest point.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    gravity: float = _key(
        parameters.GRAVITY, "Gravitational acceleration, downwards.", unit="m/s2", ge=0.0, le=1000.0
    )
    contact: Contact = Field(default_factory=Contact, description="Options of the contact law.")
    pair_interaction: PairInteraction | None = _key(
        None, "Contact between particles; null takes the sampled particle-plate values."
    )
    stop: Stop = Field(default_factory=Stop, description="When a simulation ends.")
    max_failed_share: float = _key(
        0.2,
        "Largest share of the cases that may fail or be rejected; with more, no data set is made. "
        "failures.parquet says why each failed.",
        ge=0.0,
        le=1.0,
    )
    export: Export = Field(default_factory=Export, description="Snapshots of chosen cases.")


class WearRate(_Section):
    """From the worn volume over time to a rate and its quality."""

    min_batches: int = _key(
        20, "Least number of equal batches behind a rate and its standard error.", ge=20, le=10_000
    )
    footprint_share: float = _key(
        0.95, "The footprint is the fewest facets that hold this share of the wear.", gt=0.0, le=1.0
    )
    good_r2: float = _key(
        0.95, "R2 of the straight line from which a series is counted as good.", ge=0.0, le=1.0
    )


class Features(_Section):
    """The derived quantities."""

    damping_coefficient: Literal["table", "printed"] = _key(
        "table",
        "X20. table: 2 sqrt(5/6) xi sqrt(m k), k = 4/3 E* R, which the paper's data hold "
        "(negative). printed: -2 sqrt(m k_n) ln e / sqrt(ln^2 e + pi^2), as the paper prints it.",
    )


_TARGETS = tuple(f"wear_{reading}_{statistic}" for reading in READINGS for statistic in STATISTICS)


class Penalised(_Section):
    """Lasso and ridge. As published the penalties are given, honest they are cross-validated."""

    lasso_alpha: float = _key(0.1, "Penalty of the lasso as published.", gt=0.0, le=1e6)
    ridge_alpha: float = _key(1.0, "Penalty of the ridge as published.", gt=0.0, le=1e6)
    path_points: int = _key(40, "Penalties tried along each path.", ge=5, le=1000)


class Selection(_Section):
    """The features that the networks get."""

    features: int = _key(12, "How many are chosen.", ge=2, le=20)


class Trees(_Section):
    """Decision tree and random forest."""

    max_depth: int = _key(49, "Deepest tree of the curve of depths.", ge=1, le=100)
    forest_trees: int = _key(100, "Trees of the forest.", ge=1, le=10_000)


class GaAnn(_Section):
    """Networks whose architecture a genetic search finds."""

    population: int = _key(10, "Networks in a generation.", ge=2, le=1000)
    generations: int = _key(25, "Generations of a search.", ge=1, le=10_000)
    min_layers: int = _key(2, "Fewest hidden layers.", ge=1, le=20)
    max_layers: int = _key(6, "Most hidden layers.", ge=1, le=20)
    min_neurons: int = _key(10, "Fewest neurons of a layer.", ge=1, le=10_000)
    max_neurons: int = _key(500, "Most neurons of a layer.", ge=1, le=10_000)
    selection: Literal["tournament", "roulette"] = _key(
        "tournament",
        "How parents are chosen: the best of a few drawn, or by chance in proportion to fitness.",
    )
    tournament_size: int = _key(3, "Drawn for a tournament.", ge=1, le=1000)
    crossover: float = _key(0.9, "Chance that two parents exchange layers.", ge=0.0, le=1.0)
    mutation: float = _key(
        0.2, "Chance that one layer of a child changes, and its start weights.", ge=0.0, le=1.0
    )
    mutation_size: float = _key(
        0.2, "Largest relative change of the neurons of that layer.", gt=0.0, le=1.0
    )
    elites: int = _key(1, "The best that pass unchanged.", ge=0, le=999)
    weights: Literal["seed", "inherited"] = _key(
        "seed",
        "Start weights of a child: from a seed, or those its first parent was left with, as far "
        "as the layers overlap.",
    )
    epochs: int = _key(20, "Passes over the rows in the search.", ge=1, le=100_000)
    batch: int = _key(32, "Rows in a mini-batch of the search.", ge=1, le=1_000_000)
    final_epochs: int = _key(60, "Passes over the rows for the found net.", ge=1, le=100_000)
    final_batch: int = _key(50, "Rows in a mini-batch for the found net.", ge=1, le=1_000_000)
    learning_rate: float = _key(0.001, "Step of the optimiser (Adam).", gt=0.0, le=1.0)
    validation_share: float = _key(
        0.25, "Share of the training rows that give the fitness (honest).", ge=0.05, le=0.9
    )
    retrainings: int = _key(
        10, "Trainings of the found net from different start weights.", ge=1, le=1000
    )
    searches: int = _key(
        1,
        "Honest searches, each inside the training rows of another split. 1 is one fixed split; "
        "more nest the whole search and take that many times as long.",
        ge=1,
        le=1000,
    )
    device: Literal["cpu", "cuda"] = _key(
        "cpu", "Where networks are trained: one per core, or in batches on a graphics card."
    )


class Physical(_Section):
    """Models of the wear number on dimensionless groups, their intervals and their reach."""

    boosting_trees: int = _key(400, "Trees of the boosting.", ge=1, le=100_000)
    boosting_depth: int = _key(4, "Splits along a branch of its trees.", ge=1, le=50)
    networks: int = _key(4, "Networks of the ensemble.", ge=1, le=1000)
    network_steps: int = _key(
        1000, "Mini-batches that each of them is trained on.", ge=1, le=10_000_000
    )
    interval_folds: int = _key(
        10, "Folds that the intervals are calibrated and tested on.", ge=2, le=1000
    )
    target_repeats: int = _key(
        5, "Random splits behind the scores of every target, and permutations.", ge=1, le=10_000
    )
    curve_repeats: int = _key(10, "Random splits behind the learning curve.", ge=1, le=10_000)
    sobol_points: int = _key(
        2048,
        "Base points of the Sobol indices.",
        ge=8,
        le=2**20,
        allowed="a power of two from 8 to 1048576",
    )


class Noise(_Section):
    """Simulations of the same cases with other seeds: how much of the wear is chance."""

    cases: int = _key(10, "Cases that are repeated, of those with large stones.", ge=1, le=10_000)
    replicates: int = _key(8, "Repetitions of each.", ge=1, le=10_000)


class SurrogateModel(_Section):
    """The small network behind `abradem predict`."""

    points: int = _key(
        20_000, "Points at which it learns from the Gaussian process.", ge=100, le=10_000_000
    )
    hidden: list[Annotated[int, Field(ge=1, le=10_000)]] = _key(
        [64, 64],
        "Neurons of its hidden layers.",
        allowed="a list of numbers from 1 to 10000",
        min_length=1,
        max_length=10,
    )
    epochs: int = _key(40, "Passes over the points.", ge=1, le=100_000)
    repeats: int = _key(5, "Random splits behind the score of its own.", ge=1, le=10_000)
    timed_cases: int = _key(
        5, "Cases simulated again to time the engine against it.", ge=1, le=10_000
    )


class Learning(_Section):
    """Models of the data set, each as published and honest (docs/learning.md)."""

    target: Literal[_TARGETS] = _key("wear_total_mean", "Column of the data set to be explained.")
    test_share: float = _key(
        0.2, "Share of the cases held out to test each fit (honest).", ge=0.05, le=0.9
    )
    repeats: int = _key(
        20, "Random splits into training and test that each model is scored on.", ge=1, le=10_000
    )
    folds: int = _key(5, "Folds of the cross-validations inside the training rows.", ge=2, le=1000)
    confidence: float = _key(0.95, "Level of all intervals.", ge=0.5, le=0.9999)
    bootstrap: int = _key(
        2000, "Draws of the test rows behind the interval of a single split.", ge=100, le=1_000_000
    )
    penalised: Penalised = Field(default_factory=Penalised, description="Lasso and ridge.")
    selection: Selection = Field(
        default_factory=Selection, description="The features that the networks get."
    )
    trees: Trees = Field(default_factory=Trees, description="Decision tree and random forest.")
    ga_ann: GaAnn = Field(
        default_factory=GaAnn,
        description="Networks whose architecture a genetic search finds.",
    )
    physical: Physical = Field(
        default_factory=Physical, description="Models on dimensionless groups (docs/models.md)."
    )
    noise: Noise = Field(
        default_factory=Noise, description="How much of a simulated wear rate is chance."
    )
    surrogate: SurrogateModel = Field(
        default_factory=SurrogateModel, description="The model behind `abradem predict`."
    )


def _check_columns(value: Any) -> dict[str, str | list[str]]:
    if not isinstance(value, Mapping):
        raise ValueError("must be a section of our names and the table's")
    for name, column in value.items():
        parts = column if isinstance(column, (list, tuple)) else [column]
        if not all(isinstance(part, str) and part for part in parts) or len(parts) not in (1, 2):
            raise ValueError(f"{name}: must be a column's name, or [name, unit]")
    return {str(name): column for name, column in value.items()}


class Dataset(_Section):
    """A table of yours in the place of the simulations."""

    external: str | None = _key(
        None,
        "CSV or Parquet file; learning, figures and report then run on it and nothing is "
        "simulated. null simulates.",
        min_length=1,
        allowed="the path of a file or null",
    )
    columns: Annotated[
        Any,
        PlainValidator(_check_columns),
        WithJsonSchema(
            {
                "type": "object",
                "additionalProperties": {
                    "anyOf": [
                        {"type": "string"},
                        {"type": "array", "items": {"type": "string"}, "maxItems": 2},
                    ]
                },
            }
        ),
    ] = _key(
        {},
        "Our names of quantities to the table's columns, where they differ; [column, unit] where "
        "the unit does too. Names and units of the paper's published table are known.",
        allowed="{name: column} or {name: [column, unit]}",
    )


class Typical(_Section):
    """The case that stands for the study in pictures: the middle of all ranges but for these."""

    plate_angle: float = _key(35.0, "Plate angle.", unit="deg", ge=-90.0, le=90.0)
    factory_angle: float = _key(-30.0, "Factory angle.", unit="deg", ge=-90.0, le=90.0)
    particle_radius_mm: float = _key(10.0, "Particle radius.", unit="mm", ge=0.1, le=100.0)
    particle_velocity_y: float = _key(
        -3.0, "Particle velocity (vertical).", unit="m/s", ge=-30.0, le=0.0
    )
    duration_s: float = _key(
        2.0, "Simulated time until the set-up is drawn.", unit="s", gt=0.0, le=1000.0
    )
    interval_s: float = _key(
        0.02, "Simulated time between its snapshots.", unit="s", gt=0.0, le=1000.0
    )


class Angles(_Section):
    """Wear depth against time for angles of plate and factory; the rest as `figures.typical`."""

    plate: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = _key(
        [0.0, 15.0, 30.0, 45.0, 60.0, 70.0],
        "Plate angles, deg.",
        allowed="a list of angles from -90 to 90",
        min_length=1,
        max_length=20,
    )
    factory: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = _key(
        [-90.0, -60.0, -30.0, 0.0],
        "Factory angles, deg.",
        allowed="a list of angles from -90 to 90",
        min_length=1,
        max_length=20,
    )
    duration_s: float = _key(10.0, "Simulated time of each.", unit="s", gt=0.0, le=10_000.0)


class Movie(_Section):
    """The film of `snakemake movie`: plates side by side; the rest as `figures.typical`."""

    plate_angles: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = _key(
        [60.0, 40.0, 30.0],
        "Plate angles, deg, from left to right.",
        allowed="a list of 1 to 4 angles from -90 to 90",
        min_length=1,
        max_length=4,
    )
    duration_s: float = _key(4.0, "Simulated time.", unit="s", gt=0.0, le=1000.0)
    slow_motion: float = _key(2.0, "Seconds of film per simulated second.", gt=0.0, le=1000.0)
    frames_per_second: int = _key(25, "Pictures per second of film.", ge=1, le=120)
    panel_pixels: int = _key(640, "Width of each plate's picture.", ge=100, le=4000)


class Figures(_Section):
    """The figures of the report."""

    formats: Annotated[list[Literal["pdf", "png"]], Field(min_length=1)] = _key(
        ["pdf", "png"], "File formats; the report shows png.", allowed="a list of pdf and png"
    )
    series_cases: Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1)] = _key(
        [0, 1, 2, 3, 4, 5],
        "Cases whose wear depth is drawn against time.",
        allowed="a list of case numbers from 0",
    )
    typical: Typical = Field(
        default_factory=Typical, description="The case that stands for the study in pictures."
    )
    angles: Angles = Field(
        default_factory=Angles, description="Curves for angles of plate and factory."
    )
    movie: Movie = Field(default_factory=Movie, description="The film of snakemake movie.")


class Publish(_Section):
    """What `snakemake publish` says of the data set beyond what the study knows."""

    title: str | None = _key(
        None, "Title; null: made from the study's name.", allowed="null or text"
    )
    creators: Annotated[list[str], Field(min_length=1)] = _key(
        ["abradem developers"], "Who made the data set.", allowed="a list of names"
    )
    version: str = _key(
        "1.0.0",
        "Version of the data set.",
        allowed="1.0.0, 1.0.1, 2.0.0 ...",
        pattern=r"^\d+\.\d+\.\d+$",
    )
    date: str | None = _key(
        None,
        "Day of publication; null: the day on which the data set was made.",
        allowed='null or a day in quotes, "2026-01-31"',
        pattern=r"^\d{4}-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])$",
    )
    url: str | None = _key(
        None,
        "Where it can be had, such as https://doi.org/...",
        allowed="null or an address that begins with https://",
        pattern=r"^https://\S+$",
    )
    series: bool = _key(
        True,
        "Also the series, maps and runs of every case, which are larger than the data set.",
        allowed="true or false",
    )


class Config(_Section):
    """A study. `load_config` also checks what involves several keys."""

    study: str = _key(
        ...,
        "Name of the study; results stand in results/<study>/.",
        allowed="letters, digits, _ and -, beginning with a letter or digit, at most 64",
        pattern=STUDY_NAME,
    )
    seed: int = _key(
        1, "Seed of everything random; the same seed gives the same results.", ge=0, le=2**63 - 1
    )
    sampling: Sampling = Field(
        default_factory=Sampling, description="Which parameter sets are simulated."
    )
    simulation: Simulation = Field(
        default_factory=Simulation, description="Everything else about a simulation."
    )
    wear_rate: WearRate = Field(
        default_factory=WearRate, description="From the worn volume to a rate and its quality."
    )
    dataset: Dataset = Field(
        default_factory=Dataset, description="A table of yours in the place of the simulations."
    )
    features: Features = Field(default_factory=Features, description="The derived quantities.")
    learning: Learning = Field(default_factory=Learning, description="Models of the data set.")
    figures: Figures = Field(default_factory=Figures, description="The figures of the report.")
    publish: Publish = Field(
        default_factory=Publish, description="The folder that snakemake publish makes."
    )

    @property
    def cases(self) -> int:
        """Number of cases of the study."""
        return self.sampling.blocks * self.sampling.cases_per_block


# Reading ---------------------------------------------------------------------------------


def read_config(*paths: str | os.PathLike) -> Config:
    """Read a configuration from files; each later file is merged deeply over the earlier.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    merged: dict = {}
    problems = []
    for path in paths:
        try:
            values, _ = _parse_file(Path(path))
        except ConfigError as error:
            problems += error.problems
        else:
            _merge(merged, values)
    if problems:
        raise ConfigError(problems)
    return load_config(merged, [Path(path) for path in paths])


def refuse_all_but_data(path: str | os.PathLike) -> None:
    """Refuse a file that is no YAML of plain data, or that asks to be run as a template.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    values, problems = _parse_file(Path(path))
    if "__use_yte__" in values:
        problems = [f"{_shown_path(Path(path))}: __use_yte__: templates are refused"]
    if problems:
        raise ConfigError(problems)


def load_config(
    merged: Mapping, files: Sequence[str | os.PathLike] = (), elsewhere: str = COMMAND_LINE
) -> Config:
    """Check a configuration that was already merged, as Snakemake hands it over.

    Parameters
    ----------
    merged : mapping
        All keys, with those of the command line on top.
    files : sequence of path
        The files it came from. They are read again to find duplicate keys and to say in which
        file a wrong value stands.
    elsewhere : str
        Where a value came from that stands in none of them.

    Raises
    ------
    ConfigError
        With one line for each problem.
    """
    sources: list[tuple[str, dict]] = []
    problems: list[str] = []
    for path in dict.fromkeys(Path(file).resolve() for file in files):
        try:
            values, found = _parse_file(path)
        except ConfigError as error:
            problems += error.problems
        else:
            problems += found
            sources.append((_shown_path(path), values))
    if problems:
        raise ConfigError(problems)

    values = _read_command_line_text(_plain(merged), sources)

    resolved: dict = {}

    def line(key: Key, problem: str, allowed: str = "") -> str:
        value = _lookup(values, key)
        given = value is not _MISSING
        if not given:
            value = _lookup(resolved, key)
        shown = "(missing)" if value is _MISSING else _show(value) + ("" if given else " (default)")
        tail = f" (allowed {allowed})" if allowed else ""
        origin = _origin(key, value, sources, given)
        if origin == COMMAND_LINE:
            origin = elsewhere
        return f"{origin}: {_dotted(key)}: {shown}: {problem}{tail}"

    try:
        config = Config.model_validate(values)
    except ValidationError as error:
        raise ConfigError([line(*_explain(details)) for details in error.errors()]) from None
    # A default can be in conflict with a key that was given.
    resolved.update(config.model_dump(mode="json"))
    problems = [line(key, problem) for key, problem in _conflicts(config)]
    if problems:
        raise ConfigError(problems)
    return config


def _parse_file(path: Path) -> tuple[dict, list[str]]:
    """Return the file's values and one line for each duplicate key; raise if unreadable."""
    shown = _shown_path(path)
    try:
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
    problems: list[str] = []
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        room = itertools.count(_MOST_VALUES, -1)
        values = None if node is None else _construct(node, (), shown, problems, room)
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
        raise ConfigError([f"{shown}: the file is empty; it must hold keys, such as study"])
    if not isinstance(values, dict):
        raise ConfigError(
            [f"{shown}: holds {_show(values)}, not keys; it must begin with a key, such as study"]
        )
    return values, problems


def _tag_problem(error: yaml.MarkedYAMLError) -> str:
    """Say it plainly where a tag asks for something else than plain data."""
    text = error.problem or ""
    if not text.startswith("could not determine a constructor for the tag"):
        return ""
    tag = text.split("'")[1].replace("tag:yaml.org,2002:", "!!")
    return f"the tag {tag} is refused; only plain numbers, text, lists and keys are read"


def _construct(
    node: yaml.Node, key: Key, shown: str, problems: list[str], room: Iterator[int]
) -> Any:
    """Turn a YAML node into plain data, and note keys that stand twice.

    ``room`` counts down the values that the file may still hold, those of anchors each time.
    """
    line = node.start_mark.line + 1
    if len(key) > _DEEPEST:
        raise ConfigError([f"{shown}: line {line}: nested more than {_DEEPEST} levels deep"])
    if next(room) <= 0:
        raise ConfigError([f"{shown}: line {line}: holds more than {_MOST_VALUES} values"])
    if isinstance(node, yaml.SequenceNode) and node.tag == "tag:yaml.org,2002:seq":
        return [
            _construct(item, (*key, index), shown, problems, room)
            for index, item in enumerate(node.value)
        ]
    if not isinstance(node, yaml.MappingNode) or node.tag != "tag:yaml.org,2002:map":
        return _construct_scalar(node)
    values: dict = {}
    first_line: dict[str, int] = {}
    for name_node, value_node in node.value:
        line = name_node.start_mark.line + 1
        if not isinstance(name_node, yaml.ScalarNode) or name_node.tag != "tag:yaml.org,2002:str":
            raise ConfigError([f"{shown}: line {line}: a key must be a plain word"])
        name = name_node.value
        value = _construct(value_node, (*key, name), shown, problems, room)
        if name in values:
            problems.append(
                f"{shown}: {_dotted((*key, name))}: {_show(value)}: given twice, on lines "
                f"{first_line[name]} and {line}; a key may stand only once"
            )
        values[name] = value
        first_line.setdefault(name, line)
    return values


def _construct_scalar(node: yaml.Node) -> Any:
    loader = yaml.SafeLoader("")
    try:
        return loader.construct_object(node, deep=True)
    except (ValueError, OverflowError) as error:  # such as the date 2024-13-45
        raise yaml.constructor.ConstructorError(None, None, str(error), node.start_mark) from None
    finally:
        loader.dispose()


def _merge(base: dict, overlay: Mapping) -> None:
    """Merge ``overlay`` deeply over ``base`` in place, as Snakemake does."""
    for name, value in overlay.items():
        if isinstance(value, Mapping):
            inner = base.get(name)
            base[name] = dict(inner) if isinstance(inner, Mapping) else {}
            _merge(base[name], value)
        else:
            base[name] = value


def _plain(value: Any) -> Any:
    """Return nested dicts and lists of ``value``, whatever mappings it came in."""
    if isinstance(value, Mapping):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    return value


def _read_command_line_text(values: dict, sources: Sequence[tuple[str, dict]]) -> dict:
    """Read the text that Snakemake makes of nested values given by ``--config``.

    ``--config sampling='{blocks: 3}'`` arrives as the text "3". Only values that stand in no
    file are read; a number in quotes in a file stays text.
    """

    def read(value: Any, key: Key) -> Any:
        if isinstance(value, dict):
            return {name: read(inner, (*key, name)) for name, inner in value.items()}
        if _origin(key, value, sources) != COMMAND_LINE or not sources:
            return value
        if isinstance(value, list):
            return [read(inner, (*key, index)) for index, inner in enumerate(value)]
        if isinstance(value, str):
            try:
                scalar = yaml.safe_load(value)
            except yaml.YAMLError:
                return value
            return value if isinstance(scalar, (dict, list)) else scalar
        return value

    return read(values, ())


def _origin(key: Key, value: Any, sources: Sequence[tuple[str, dict]], given: bool = True) -> str:
    """Return the file in which ``key`` has this value, or "command line".

    ``given`` is False for a default that stands neither in a file nor on the command line.
    """
    for shown, values in reversed(sources):
        found = _lookup(values, key)
        if isinstance(value, dict):
            # A section is merged from several files; the last that has it is named.
            if isinstance(found, dict):
                return shown
        elif found is not _MISSING and repr(found) == repr(value):
            return shown
    if sources and (value is _MISSING or not given):
        # What is missing belongs where its section was last given, else in the first file.
        for shown, values in reversed(sources):
            if len(key) > 1 and isinstance(_lookup(values, key[:-1]), dict):
                return shown
        return sources[0][0]
    return COMMAND_LINE


def _lookup(values: Any, key: Key) -> Any:
    for part in key:
        if isinstance(values, dict) and part in values:
            values = values[part]
        elif isinstance(values, list) and isinstance(part, int) and part < len(values):
            values = values[part]
        else:
            return _MISSING
    return values


def _dotted(key: Key) -> str:
    text = ""
    for part in key:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text.encode("unicode_escape").decode("ascii") or "(all keys)"


def _show(value: Any) -> str:
    """Return ``value`` in one short line, as it would stand in YAML's flow style."""
    if isinstance(value, float) and not math.isfinite(value):
        text = {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    elif isinstance(value, float):
        text = _yaml_float(repr(value))
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{name}: {_show(inner)}" for name, inner in value.items()) + "}"
    elif isinstance(value, list):
        text = "[" + ", ".join(_show(inner) for inner in value) + "]"
    else:
        text = json.dumps(value, default=str)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 4] + " ..."


def _shown_path(path: Path) -> str:
    """Return the path as the user would write it: relative where it is below the folder."""
    try:
        return str(path.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(path)


# Explaining ------------------------------------------------------------------------------


def _explain(details: Mapping) -> tuple[Key, str, str]:
    """Return key, problem and what is allowed for one error of pydantic."""
    key: Key = details["loc"]
    value = details["input"]
    kind = details["type"]
    if kind == "extra_forbidden":
        return key, *_unknown_key(key)
    field = _field(key)
    allowed = _allowed(field) if field else ""
    if kind == "missing":
        return key, "is required", allowed
    if kind == "value_error":
        return key, str(details["ctx"]["error"]), allowed
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        names = ", ".join(_section(key).model_fields) if _section(key) else ""
        if value is None:
            return key, "is an empty section; give keys or remove the line", names
        return key, "must be a section of keys", names
    problems = {
        "float_type": _not_a_number(value, "number"),
        "int_type": _not_a_number(value, "whole number"),
        "int_from_float": "must be a whole number",
        "finite_number": "must be a finite number",
        "string_type": "must be text; put it in quotes",
        "string_pattern_mismatch": "is no name for a folder",
        "literal_error": "is unknown",
        "list_type": "must be a list",
        "too_short": "must not be empty",
    }
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        return key, "is out of range", allowed
    return key, problems.get(kind, details["msg"]), allowed


def _unknown_key(key: Key) -> tuple[str, str]:
    """Return the problem, with the nearest known key, and the keys allowed there."""
    *parents, name = key
    name = str(name)
    section = _section(tuple(parents))
    names = list(section.model_fields)
    close = [known for known in names if known.startswith(name + "_") or _stem(known) == name]
    close += difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        unit = _extra(section.model_fields[close[0]], "unit")
        return f"unknown key, did you mean {close[0]}{f' (in {unit})' if unit else ''}?", ""
    elsewhere = [path for path, _ in _leaves() if path[-1] == name]
    if elsewhere:
        return f"unknown key here, did you mean {_dotted(elsewhere[0])}?", ""
    return "unknown key", ", ".join(names)


def _stem(name: str) -> str:
    """Return a key without the unit at its end."""
    for suffix in ("_gpa", "_mm", "_kg_s", "_per_s", "_s"):
        if name.endswith(suffix):
            return name.removesuffix(suffix)
    return name


def _section_class(annotation: Any) -> type[_Section] | None:
    """Return the section's class if the annotation is one, or one or null."""
    for candidate in (annotation, *get_args(annotation)):
        if isinstance(candidate, type) and issubclass(candidate, _Section):
            return candidate
    return None


def _section(key: Key) -> type[_Section] | None:
    section: type[_Section] | None = Config
    for part in key:
        field = section.model_fields.get(part) if section else None
        section = _section_class(field.annotation) if field else None
    return section


def _field(key: Key) -> FieldInfo | None:
    """Return the field that holds ``key``; an item of a list belongs to the list's field."""
    names = [part for part in key if isinstance(part, str)]
    section = _section(tuple(names[:-1]))
    return section.model_fields.get(names[-1]) if section and names else None


def _leaves(section: type[_Section] = Config, above: Key = ()) -> Iterator[tuple[Key, FieldInfo]]:
    """Yield every key that holds a value, with its field, in order."""
    for name, field in section.model_fields.items():
        inner = _section_class(field.annotation)
        if inner is not None:
            yield from _leaves(inner, (*above, name))
        else:
            yield (*above, name), field


def _extra(field: FieldInfo, name: str) -> str:
    return (field.json_schema_extra or {}).get(name, "")


def _allowed(field: FieldInfo) -> str:
    """Say in a few words what the field takes."""
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
    elif _section_class(annotation):
        text = "a section of keys"
    else:
        bounds: dict[str, float] = {}
        for constraint in _constraints(field):
            for side in ("gt", "ge", "lt", "le"):
                if hasattr(constraint, side):
                    bounds[side] = getattr(constraint, side)
        unit = _extra(field, "unit")
        low, high = bounds.get("ge", bounds.get("gt")), bounds.get("le", bounds.get("lt"))
        text = _interval(low, high, unit, above="gt" in bounds)
    return text + (" or null" if optional else "")


def _constraints(field: FieldInfo) -> list:
    """Return the bounds of a number, or of the number in "number or null"."""
    found = list(field.metadata)
    for part in get_args(field.annotation):
        found += getattr(part, "__metadata__", ())
    return found


# Conflicts between keys ------------------------------------------------------------------


def _conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield key and problem for values that are fine alone but not together."""
    # Some file systems do not tell capital letters from small ones.
    if config.study.lower() in TAKEN_NAMES:
        yield ("study",), f"is taken by {TAKEN_NAMES[config.study.lower()]} (allowed: another name)"
    external = config.dataset.external
    if external is not None and _is_below(external, f"results/{config.study}"):
        yield (
            ("dataset", "external"),
            "is a result of this very study (allowed: a file elsewhere, or another study)",
        )
    simulation = config.simulation
    yield from _feed_conflicts(simulation.factory)
    yield from _size_conflicts(config)

    plate = simulation.plate
    shorter = min(plate.length_mm, plate.width_mm)
    if plate.facet_size_mm > shorter:
        yield (
            ("simulation", "plate", "facet_size_mm"),
            f"a facet must not be larger than the plate (allowed up to {shorter:g} mm)",
        )
    if config.sampling.ranges.particle_radius_mm[1] > shorter / 2.0:
        yield (
            ("sampling", "ranges", "particle_radius_mm"),
            "a particle must not be wider than the plate "
            f"(allowed radius up to {shorter / 2.0:g} mm on a plate of "
            f"{plate.length_mm:g} x {plate.width_mm:g} mm)",
        )

    if config.figures.typical.particle_radius_mm > shorter / 2.0:
        yield (
            ("figures", "typical", "particle_radius_mm"),
            f"a particle must not be wider than the plate (allowed up to {shorter / 2.0:g} mm)",
        )

    yield from _learning_conflicts(config)

    stop = simulation.stop
    if stop.max_time_s <= stop.window_s:
        yield (
            ("simulation", "stop", "max_time_s"),
            f"must be longer than the window (allowed above {stop.window_s:g} s)",
        )
    most = stop.window_s / config.wear_rate.min_batches
    if stop.sample_interval_s > most:
        yield (
            ("simulation", "stop", "sample_interval_s"),
            f"gives too few samples for {config.wear_rate.min_batches} batches of the window "
            f"(allowed up to {most:g} s)",
        )
    if simulation.export.cases and simulation.export.interval_s > stop.max_time_s:
        yield (
            ("simulation", "export", "interval_s"),
            f"is longer than the simulation (allowed up to {stop.max_time_s:g} s)",
        )

    for key, cases in (
        (("simulation", "export", "cases"), simulation.export.cases),
        (("figures", "series_cases"), config.figures.series_cases),
    ):
        beyond = [case for case in cases if case >= config.cases]
        if beyond:
            yield key, f"there is no case {beyond[0]} (allowed 0 ... {config.cases - 1})"
    for key, items in (
        (("simulation", "export", "cases"), simulation.export.cases),
        (("figures", "series_cases"), config.figures.series_cases),
        (("figures", "formats"), config.figures.formats),
        (("figures", "angles", "plate"), config.figures.angles.plate),
        (("figures", "angles", "factory"), config.figures.angles.factory),
        (("figures", "movie", "plate_angles"), config.figures.movie.plate_angles),
    ):
        if len(set(items)) < len(items):
            yield key, "names an item twice (allowed once each)"
    if "png" not in config.figures.formats:
        yield ("figures", "formats"), "must include png, which the report shows (allowed pdf, png)"


TAKEN_NAMES = {
    "verification": "the results of make verify",
    "benchmarks": "the results of make bench",
}
"""Folders under results/ that are no study's."""

MOST_FACETS = 1_000_000
"""More facets than this would fill tables, not resolve wear."""

MOST_CASES = 1_000_000
MOST_JOBS = 20_000
"""Simulation jobs beyond which the workflow needs minutes, then hours, to begin."""

MOST_SAMPLES = 100_000
"""Samples of the worn volume that the engine takes of a case."""

MOST_MAP_BYTES = 4e9
"""Memory of a case's maps of worn volume by facet, ten of which are kept for each window."""


def _is_below(path: str, folder: str) -> bool:
    try:
        return Path(path).resolve().is_relative_to(Path(folder).resolve())
    except (OSError, ValueError):
        return False


def _size_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """What would fill disk or memory, or never begin."""
    from abradem.shards import shards_of_block

    sampling, simulation = config.sampling, config.simulation
    plate, stop = simulation.plate, simulation.stop
    if config.cases > MOST_CASES:
        yield (
            ("sampling", "blocks"),
            f"makes {config.cases} cases with {sampling.cases_per_block} in a block "
            f"(allowed up to {MOST_CASES} cases in all)",
        )
    else:
        shards = shards_of_block(sampling.cases_per_block, simulation.cases_per_job)
        jobs = sampling.blocks * len(shards)
        if jobs > MOST_JOBS:
            yield (
                ("simulation", "cases_per_job"),
                f"makes {jobs} simulation jobs (allowed up to {MOST_JOBS}; take more cases per "
                "job, or fewer and larger blocks)",
            )
    facets = math.prod(
        math.ceil(side / plate.facet_size_mm) for side in (plate.length_mm, plate.width_mm)
    )
    maps = 10.0 * stop.max_time_s / stop.window_s
    if facets > MOST_FACETS:
        yield (
            ("simulation", "plate", "facet_size_mm"),
            f"divides the plate into {facets} facets (allowed up to {MOST_FACETS})",
        )
    elif maps * facets * len(READINGS) * 8.0 > MOST_MAP_BYTES:
        yield (
            ("simulation", "plate", "facet_size_mm"),
            f"with {facets} facets, {maps:.0f} maps of a case would fill the memory; take larger "
            "facets, a longer window or a shorter max_time_s "
            f"(allowed {MOST_MAP_BYTES / 1e9:g} GB)",
        )
    least = stop.max_time_s / MOST_SAMPLES
    if stop.sample_interval_s < least:
        yield (
            ("simulation", "stop", "sample_interval_s"),
            f"gives more than {MOST_SAMPLES} samples in max_time_s (allowed from {least:g} s)",
        )


def _learning_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    network = config.learning.ga_ann
    for low, high in (("min_layers", "max_layers"), ("min_neurons", "max_neurons")):
        most = getattr(network, high)
        if getattr(network, low) > most:
            yield ("learning", "ga_ann", low), f"must not exceed {high} (allowed up to {most})"
    for name, most in (
        ("elites", network.population - 1),
        ("tournament_size", network.population),
    ):
        if getattr(network, name) > most:
            yield (
                ("learning", "ga_ann", name),
                f"is too many for a population of {network.population} (allowed up to {most})",
            )
    points = config.learning.physical.sobol_points
    if points & (points - 1):
        yield ("learning", "physical", "sobol_points"), "is no power of two"
    if config.dataset.columns and config.dataset.external is None:
        yield ("dataset", "columns"), "needs the table it is about, dataset.external"


def _feed_conflicts(factory: Factory) -> Iterator[tuple[Key, str]]:
    key_of = {"mass": "mass_rate_kg_s", "number": "number_rate_per_s"}
    for feed, name in key_of.items():
        rate = getattr(factory, name)
        if feed == factory.feed and rate is None:
            yield (
                ("simulation", "factory", name),
                f"feed: {feed} needs this rate (allowed a number above 0)",
            )
        if feed != factory.feed and rate is not None:
            yield (
                ("simulation", "factory", name),
                f"feed: {factory.feed} takes its rate from {key_of[factory.feed]} "
                "(allowed null here)",
            )


# Handing on ------------------------------------------------------------------------------


def to_yaml(config: Config) -> str:
    """Return the resolved configuration, every key with its value, as YAML."""
    return yaml.safe_dump(
        config.model_dump(mode="json"), sort_keys=False, default_flow_style=None, width=100
    )


def sampled_ranges(config: Config) -> dict[str, list[float]]:
    """Return {name: [lower, upper]} of the 14 sampled quantities in the table's units (SI)."""
    ranges = config.sampling.ranges
    return {
        row.name: [_to_si(row, bound) for bound in getattr(ranges, row.config_key)]
        for row in SAMPLED
    }


def typical_case(config: Config) -> dict[str, float]:
    """Return the arguments of `abradem.Case` of the case that stands for the study, SI units."""
    middle = {name: (low + high) / 2.0 for name, (low, high) in sampled_ranges(config).items()}
    chosen = config.figures.typical
    given = {
        row.name: _to_si(row, getattr(chosen, row.config_key))
        for row in SAMPLED
        if hasattr(chosen, row.config_key)
    }
    return {**middle, **given, "seed": config.seed}


def setup_dict(config: Config) -> dict:
    """Return the arguments of `abradem.Setup` as plain JSON values, SI units.

    `abradem.shards.setup_from_dict` makes the set-up of them.
    """
    simulation = config.simulation
    plate, factory, stop = simulation.plate, simulation.factory, simulation.stop
    pair = simulation.pair_interaction
    return {
        "plate_length": plate.length_mm / 1000.0,
        "plate_width": plate.width_mm / 1000.0,
        "facet_size": plate.facet_size_mm / 1000.0,
        "patch_length": factory.patch_length_mm / 1000.0,
        "patch_width": factory.patch_width_mm / 1000.0,
        "fall_height": factory.fall_height_mm / 1000.0,
        "mass_rate": factory.mass_rate_kg_s,
        "number_rate": factory.number_rate_per_s,
        "removal_depth": simulation.removal_depth_mm / 1000.0,
        "gravity": simulation.gravity,
        "contact": simulation.contact.model_dump(),
        "pair_interaction": None if pair is None else pair.model_dump(),
        "time_step_fraction": simulation.time_step_rayleigh_fraction,
        "stepping": simulation.stepping,
        "window": stop.window_s,
        "max_time": stop.max_time_s,
        "target_stderr": stop.target_stderr,
        "sample_interval": stop.sample_interval_s,
    }


# Estimate --------------------------------------------------------------------------------

SECONDS_PER_JOB = 2.5
"""Start of a job: interpreter, imports, loading of compiled code."""

_LOOKED_AT = 1000
"""Cases whose time is guessed; those after them are taken to be alike."""


def estimate(config: Config, cores: int | None = None) -> str:
    """Say in one line what a run will do: cases, jobs and roughly how long they take.

    The time is that of `cost.case_seconds`. ``cores`` defaults to those of this machine.
    """
    from abradem.cost import case_seconds
    from abradem.sampling import block_cases
    from abradem.shards import shards_of_block

    if config.dataset.external is not None:
        return f"{config.study}: learning from {config.dataset.external}, nothing is simulated"
    cores = cores or os.cpu_count() or 1
    sampling = config.sampling
    shards = shards_of_block(sampling.cases_per_block, config.simulation.cases_per_job)
    jobs = sampling.blocks * len(shards)
    size = min(sampling.cases_per_block, _LOOKED_AT)
    blocks = min(sampling.blocks, -(-_LOOKED_AT // size))
    ranges, setup = sampled_ranges(config), setup_dict(config)
    looked_at = [
        block_cases(config.seed, block, size, sampling.method, ranges) for block in range(blocks)
    ]
    each = sum(case_seconds(cases, setup).sum() for cases in looked_at) / (blocks * size)
    seconds = (config.cases * each + jobs * SECONDS_PER_JOB) / min(cores, jobs)
    return (
        f"{config.study}: {_count(config.cases, 'case')} in {_count(sampling.blocks, 'block')}, "
        f"{_count(jobs, 'simulation job')}, simulated in about {_duration(seconds)} on "
        f"{_count(cores, 'core')}"
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{max(5, 5 * round(seconds / 5))} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


# Schema and documentation ----------------------------------------------------------------


def schema() -> dict:
    """Return the JSON schema (draft 2020-12) of the configuration."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Config.model_json_schema(),
    }


def documentation() -> str:
    """Return the reference of all keys as Markdown."""
    lines = [
        "# Configuration",
        "",
        "Generated from `src/abradem/config.py` by `python -m abradem.config --write`.",
        "",
        "`config.yaml` is the paper's study. Another study is a small overlay on it, such as",
        "`studies/smoke.yaml`: it holds only the keys that differ. A key that stands nowhere takes",
        "the default below. Values are in SI units unless the key names another unit.",
        "",
        *_document_section(Config, ()),
    ]
    return "\n".join(lines)


def _document_section(section: type[_Section], above: Key) -> list[str]:
    lines = []
    if above:
        doc = " ".join((section.__doc__ or "").split())
        lines += [f"## {_dotted(above)}", "", doc, ""]
    values = [
        (name, field)
        for name, field in section.model_fields.items()
        if _section_class(field.annotation) is None or field.default is None
    ]
    if values:
        lines += ["| key | default | allowed | meaning |", "| --- | --- | --- | --- |"]
        for name, field in values:
            default = "required" if field.is_required() else f"`{_default(field)}`"
            lines.append(f"| `{name}` | {default} | {_allowed(field)} | {field.description} |")
        lines.append("")
    for name, field in section.model_fields.items():
        inner = _section_class(field.annotation)
        if inner is not None:
            lines += _document_section(inner, (*above, name))
    return lines


def _default(field: FieldInfo) -> str:
    if isinstance(field.default, tuple):
        return f"[{_number(field.default[0])}, {_number(field.default[1])}]"
    if isinstance(field.default, float):
        return _number(field.default)
    return field.default if isinstance(field.default, str) else _show(field.default)


def _generated(root: Path) -> dict[Path, str]:
    """Return the files made from the declaration, with their text."""
    return {
        root / SCHEMA_FILE: json.dumps(schema(), indent=2) + "\n",
        root / DOCUMENTATION_FILE: documentation(),
    }


def _main(arguments: Sequence[str]) -> int:
    if list(arguments) != ["--write"]:
        print(f"usage: python -m abradem.config --write  ({SCHEMA_FILE}, {DOCUMENTATION_FILE})")
        return 2
    for path, text in _generated(Path.cwd()).items():
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(path.name + ".part")
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    return 0


if __name__ == "__main__":
    import sys

    sys.exit(_main(sys.argv[1:]))
