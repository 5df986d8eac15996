"""What may stand in a configuration: each key, its default, its unit and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, WithJsonSchema, create_model

from abradem import quantities
from abradem.config.batches import batches_of_block
from abradem.quantities import SAMPLED, STATISTICS, WEAR_MEASURES, Quantity
from abradem.words.labels import LABELS

STUDY_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"
"""A study's name is a folder under results/, so it holds no separators, dots or blanks."""


class Section(BaseModel):
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
    return annotation, _key(default, help_text, unit=unit, allowed=interval_text(low, high, unit))


def interval_text(low: float, high: float, unit: str = "", above: bool = False) -> str:
    first = f"above {number_text(low)} up to" if above else f"{number_text(low)} ..."
    return f"{first} {number_text(high)}{f' {unit}' if unit else ''}"


def number_text(value: float) -> str:
    return str(value) if isinstance(value, int) else yaml_float(f"{value:g}")


def yaml_float(text: str) -> str:
    """Return a number's text such that YAML 1.1 reads a number: 1e-10 is text, 1.0e-10 not."""
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text
    sign = "" if exponent[0] in "+-" else "+"
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{sign}{exponent}"


def _from_si(row: Quantity, value: float) -> float:
    """Return ``value`` in the configuration's unit, without the noise of 40e-3 / 1e-3."""
    return float(f"{value / row.config_factor:.12g}")


def to_si(row: Quantity, value: float) -> float:
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
    meant = ", ".join(number_text(_from_si(row, bound)) for bound in bounds)
    return f"; the key is in {row.config_unit}, for values in {row.unit} write [{meant}]"


def _require_number(value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(not_a_number(value, "number"))
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("must be a finite number")


def not_a_number(value: Any, wanted: str) -> str:
    """Say why ``value`` is no number; text that looks like one gets a hint."""
    if isinstance(value, str):
        try:
            number = float(value)
        except ValueError:
            pass
        else:
            if math.isfinite(number) and "e" in value.lower():
                written = yaml_float(value.strip().lower())
                return f"must be a {wanted}; YAML reads this as text, write {written}"
            return f"must be a {wanted}, not text; write it without quotes"
    return f"must be a {wanted}"


class Ranges(
    create_model(
        "Ranges", __base__=Section, **{row.config_key: _range_field(row) for row in SAMPLED}
    )
):
    """Ranges of the 14 sampled quantities.

    Each is [lower bound, upper bound], or one number to keep the quantity fixed. A key left
    out takes the paper's range.
    """


class Sampling(Section):
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
        "Cases in one block. Changing it draws every block again; to grow a study add blocks.",
        ge=1,
        le=100_000,
    )
    ranges: Ranges = Field(
        default_factory=Ranges, description="Ranges of the 14 sampled quantities."
    )


class PlateKeys(Section):
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


class Factory(Section):
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


class Contact(Section):
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


class PairInteraction(Section):
    """Contact between particles, where it differs from particle on plate."""

    restitution: float = _key(..., "Coefficient of restitution.", ge=0.05, le=1.0)
    static_friction: float = _key(..., "Coefficient of static friction.", ge=0.0, le=2.0)
    rolling_friction: float = _key(..., "Coefficient of rolling friction.", ge=0.0, le=1.0)


class Stop(Section):
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


class Export(Section):
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


class Simulation(Section):
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
    plate: PlateKeys = Field(default_factory=PlateKeys, description="The plate that wears.")
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
        quantities.GRAVITY, "Gravitational acceleration, downwards.", unit="m/s2", ge=0.0, le=1000.0
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


class WearRate(Section):
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


class Features(Section):
    """The derived quantities."""

    damping_coefficient: Literal["table", "printed"] = _key(
        "table",
        "X20. table: 2 sqrt(5/6) xi sqrt(m k), k = 4/3 E* R, which the paper's data hold "
        "(negative). printed: -2 sqrt(m k_n) ln e / sqrt(ln^2 e + pi^2), as the paper prints it.",
    )


_TARGETS = tuple(
    f"wear_{measure}_{statistic}" for measure in WEAR_MEASURES for statistic in STATISTICS
)


class Penalised(Section):
    """Lasso and ridge. As published the penalties are given, leakage-free they are cross-validated."""

    lasso_alpha: float = _key(0.1, "Penalty of the lasso as published.", gt=0.0, le=1e6)
    ridge_alpha: float = _key(1.0, "Penalty of the ridge as published.", gt=0.0, le=1e6)
    path_points: int = _key(40, "Penalties tried along each path.", ge=5, le=1000)


class Selection(Section):
    """The features that the networks get."""

    features: int = _key(12, "How many are chosen.", ge=2, le=20)


class Trees(Section):
    """Decision tree and random forest."""

    max_depth: int = _key(49, "Deepest tree of the curve of depths.", ge=1, le=100)
    forest_trees: int = _key(100, "Trees of the forest.", ge=1, le=10_000)


class GaAnn(Section):
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
        0.25, "Share of the training rows that give the fitness (leakage-free).", ge=0.05, le=0.9
    )
    retrainings: int = _key(
        10, "Trainings of the found net from different start weights.", ge=1, le=1000
    )
    searches: int = _key(
        1,
        "Leakage-free searches, each inside the training rows of another split. 1 is one fixed split; "
        "more nest the whole search and take that many times as long.",
        ge=1,
        le=1000,
    )
    device: Literal["cpu", "cuda"] = _key(
        "cpu", "Where networks are trained: one per core, or in batches on a graphics card."
    )


class Physical(Section):
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


class Noise(Section):
    """Simulations of the same cases with other seeds: how much of the wear is chance."""

    cases: int = _key(
        10, "Cases that are repeated, of those with large particles.", ge=1, le=10_000
    )
    replicates: int = _key(8, "Repetitions of each.", ge=1, le=10_000)


class SurrogateModel(Section):
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


class Learning(Section):
    """Models of the data set, each as published and leakage-free (docs/learning.md)."""

    target: Literal[_TARGETS] = _key("wear_total_mean", "Column of the data set to be explained.")
    test_share: float = _key(
        0.2, "Share of the cases held out to test each fit (leakage-free).", ge=0.05, le=0.9
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


class Dataset(Section):
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


class Typical(Section):
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


class Angles(Section):
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


class Movie(Section):
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


class Figures(Section):
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


class Publish(Section):
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


class Config(Section):
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

    @property
    def batches(self) -> list[tuple[int, int]]:
        """First and last-plus-one case of the batches of a block, see `abradem.config.batches`."""
        return batches_of_block(self.sampling.cases_per_block, self.simulation.cases_per_job)

    @property
    def jobs(self) -> int:
        """Number of simulation jobs: the batches of all blocks."""
        return self.sampling.blocks * len(self.batches)
