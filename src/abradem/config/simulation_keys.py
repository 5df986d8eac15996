"""Keys of `simulation`: plate, factory, contact law, stop rule."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, WithJsonSchema

from abradem import quantities
from abradem.config.fields import Section, not_a_number, setting
from abradem.config.geometry_keys import GeometryKeys


class PlateKeys(Section):
    """The plate: a flat rectangle, tilted about its centre by the plate angle."""

    length_mm: float = setting(300.0, "Extent along the slope.", unit="mm", gt=0.0, le=100_000.0)
    width_mm: float = setting(300.0, "Extent across the slope.", unit="mm", gt=0.0, le=100_000.0)
    facet_size_mm: float = setting(
        10.0,
        "Largest edge of a wear facet; the plate is divided into equal facets. Unless "
        "wear_rate.element_size_mm is given, the maximum and the 99th percentile depend on it.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )


class Factory(Section):
    """Release of the particles: position and rate."""

    patch_length_mm: float = setting(
        300.0,
        "Extent of the patch of particle centres along its slope.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    patch_width_mm: float = setting(
        300.0,
        "Extent of the patch of particle centres across its slope.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    fall_height_mm: float = setting(
        475.0,
        "Height of the centre of the patch above the centre of the plate at a factory angle of 0.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    angle_acts: Literal["tilt", "level", "arc"] = setting(
        "arc",
        "How the factory angle acts. tilt: the patch is tilted about its centre, so the jet "
        "narrows. level: the patch stays level, and the angle does nothing. arc: the level patch "
        "is lower by arc_radius times 1 - cos(factory angle).",
    )
    arc_radius_mm: float = setting(
        310.0, "Radius of the arc, for angle_acts: arc alone.", unit="mm", ge=0.0, le=100_000.0
    )
    feed: Literal["mass", "number"] = setting(
        "mass", "Which rate is prescribed: mass per time or particles per time."
    )
    mass_rate_kg_s: float | None = setting(
        43.0, "Mass rate for feed: mass, otherwise null.", unit="kg/s", gt=0.0, le=1e6
    )
    number_rate_per_s: float | None = setting(
        None, "Particle rate for feed: number, otherwise null.", unit="1/s", gt=0.0, le=1e9
    )
    attempts: int = setting(
        1, "Random places on the patch that are tried for a particle.", ge=1, le=10_000
    )
    unplaced: Literal["wait", "skip"] = setting(
        "skip",
        "What becomes of a particle that overlaps others at all places tried. wait: it is tried "
        "again a little later, before those that follow. skip: it is left out, and its share of "
        "the feed is lost.",
    )


class Contact(Section):
    """Options of the contact law that the paper does not specify."""

    normal: Literal["exact_e", "nominal_clipped", "nominal_attractive"] = setting(
        "exact_e",
        "exact_e: never attractive, and an isolated impact rebounds at exactly e. "
        "nominal_clipped: the textbook damping, clipped so that it is never attractive. "
        "nominal_attractive: the textbook damping, which is attractive at the end of a contact.",
    )
    tangential: Literal["incremental", "displacement"] = setting(
        "incremental",
        "incremental: the spring force is accumulated step by step. displacement: it is the "
        "stiffness times the accumulated displacement, as documented for one commercial code.",
    )
    tangential_damping: Literal["capped", "none", "uncapped"] = setting(
        "capped",
        "capped: Coulomb's law limits the sum of spring and damping force. uncapped: it limits "
        "only the spring force. none: no tangential damping.",
    )


class PairInteraction(Section):
    """Contact between particles; null: the sampled values of particle and plate apply."""

    restitution: float = setting(0.5, "Coefficient of restitution.", ge=0.05, le=1.0)
    static_friction: float = setting(0.5, "Coefficient of static friction.", ge=0.0, le=2.0)
    rolling_friction: float = setting(0.01, "Coefficient of rolling friction.", ge=0.0, le=1.0)


class Stop(Section):
    """Stop rule: when a simulation ends."""

    window_s: float = setting(
        2.0,
        "Steady time over which the wear of the facets is recorded; also the shortest steady time "
        "that is simulated.",
        unit="s",
        gt=0.0,
        le=10_000.0,
    )
    max_time_s: float = setting(
        8.0, "Longest simulated time of a case.", unit="s", gt=0.0, le=100_000.0
    )
    target_stderr: float = setting(
        0.2,
        "A case ends when its mean `total` rate is known to this relative standard error.",
        gt=0.0,
        le=1.0,
    )
    sample_interval_s: float = setting(
        0.02, "Time between samples of the worn volume.", unit="s", gt=0.0, le=100.0
    )


class Export(Section):
    """Snapshots of positions, velocities, contact forces and wear; large files, off by default."""

    cases: list[Annotated[int, Field(ge=0)]] = setting(
        [],
        "Cases to export; nothing is exported if the list is empty.",
        allowed="a list of case numbers from 0",
    )
    interval_s: float = setting(
        0.01, "Simulated time between snapshots.", unit="s", gt=0.0, le=1000.0
    )


def _check_cases_per_job(value: Any) -> str | int:
    if value == "auto":
        return value
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(not_a_number(value, "auto or a whole number", 1, 100_000))
    if not 1 <= value <= 100_000:
        raise ValueError("is out of range")
    return value


class Simulation(Section):
    """All settings of a simulation that are not sampled."""

    cases_per_job: Annotated[
        str | int,
        PlainValidator(_check_cases_per_job),
        WithJsonSchema(
            {"anyOf": [{"const": "auto"}, {"type": "integer", "minimum": 1, "maximum": 100_000}]}
        ),
    ] = setting(
        "auto",
        "Number of cases that one job simulates. Starting a job takes seconds, so several cases "
        "share a job; with 1 each case has its own job.",
        allowed="auto or 1 ... 100000",
    )
    stepping: Literal["islands", "synchronous"] = setting(
        "islands",
        "Time stepping: islands skips the time in which nothing touches, synchronous steps every "
        "particle in every step. Both give bitwise equal results.",
    )
    threads: int = setting(
        1,
        "Threads of one simulation, for a machine with more cores than jobs: they share the "
        "particles of crowds. Results do not depend on it, and a change repeats nothing. Leave 1 "
        "where the jobs of a study fill the cores; a geometry other than the plate always uses 1.",
        ge=1,
        le=64,
    )
    time_step_rayleigh_fraction: float = setting(
        0.2,
        "Time step as a fraction of the Rayleigh time of the particle. With 0.15 an impact near "
        "5 m/s takes about 21 steps; the bias of total is at most 0.8 % averaged over the impact "
        "angle and at most 3 % at a single angle, with the paper's 0.2 1.3 % and 5 %. A case "
        "whose first impact the step biases by more than 5 % is refused.",
        ge=0.001,
        le=0.4,
    )
    plate: PlateKeys = Field(default_factory=PlateKeys, description="The plate.")
    geometry: GeometryKeys = Field(
        default_factory=GeometryKeys, description="What the particles wear."
    )
    factory: Factory = Field(
        default_factory=Factory, description="Release of the particles: position and rate."
    )
    removal_depth_mm: float = setting(
        100.0,
        "Depth below the lowest point of the plate at which particles are removed.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    gravity: float = setting(
        quantities.GRAVITY, "Gravitational acceleration, downwards.", unit="m/s2", ge=0.0, le=1000.0
    )
    contact: Contact = Field(default_factory=Contact, description="Options of the contact law.")
    pair_interaction: PairInteraction | None = Field(
        default_factory=PairInteraction,
        description="Contact between particles; null: that of particle and plate applies.",
    )
    stop: Stop = Field(default_factory=Stop, description="When a simulation ends.")
    max_failed_share: float = setting(
        0.2,
        "Largest share of cases that may fail or be rejected; above it no data set is written. "
        "failures.parquet lists the reason for each case.",
        ge=0.0,
        le=1.0,
    )
    export: Export = Field(default_factory=Export, description="Snapshots of selected cases.")
