"""Keys of `figures`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from abradem.config.fields import Section, setting


class Typical(Section):
    """The representative case in figures: the middle of all ranges, except for these values.

    With a geometry a value outside its range gives way to the middle of the range.
    """

    plate_angle: float = setting(35.0, "Plate angle.", unit="deg", ge=-90.0, le=90.0)
    factory_angle: float = setting(-30.0, "Factory angle.", unit="deg", ge=-90.0, le=90.0)
    particle_radius_mm: float = setting(15.0, "Particle radius.", unit="mm", ge=0.1, le=100.0)
    particle_velocity_y: float = setting(
        -3.0, "Particle velocity (vertical).", unit="m/s", ge=-30.0, le=0.0
    )
    duration_s: float = setting(
        2.0, "Simulated time at which the set-up is drawn.", unit="s", gt=0.0, le=1000.0
    )
    interval_s: float = setting(
        0.02, "Simulated time between snapshots.", unit="s", gt=0.0, le=1000.0
    )


class Angles(Section):
    """Wear depth over time for several plate and factory angles.

    All other quantities are those of `figures.typical`.
    """

    plate: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = setting(
        [0.0, 15.0, 30.0, 45.0, 60.0, 70.0],
        "Plate angles, deg.",
        unit="deg",
        allowed="a list of angles from -90 to 90",
        min_length=1,
        max_length=20,
    )
    factory: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = setting(
        [-90.0, -60.0, -30.0, 0.0],
        "Factory angles, deg.",
        unit="deg",
        allowed="a list of angles from -90 to 90",
        min_length=1,
        max_length=20,
    )
    duration_s: float = setting(5.0, "Simulated time of each case.", unit="s", gt=0.0, le=10_000.0)


class Movie(Section):
    """The movie of `snakemake movie`, with several plates side by side, or a geometry.

    All other quantities are those of `figures.typical`.
    """

    plate_angles: list[Annotated[float, Field(ge=-90.0, le=90.0)]] = setting(
        [60.0, 40.0, 30.0],
        "Plate angles, deg, from left to right.",
        unit="deg",
        allowed="a list of 1 to 4 angles from -90 to 90",
        min_length=1,
        max_length=4,
    )
    duration_s: float = setting(4.0, "Simulated time.", unit="s", gt=0.0, le=1000.0)
    slow_motion: float = setting(2.0, "Seconds of movie per simulated second.", gt=0.0, le=1000.0)
    frames_per_second: int = setting(25, "Frames per second of movie.", ge=1, le=120)
    panel_pixels: int = setting(640, "Width of the panel of each plate.", ge=100, le=4000)


class Figures(Section):
    """The figures of the report."""

    formats: Annotated[list[Literal["pdf", "png"]], Field(min_length=1)] = setting(
        ["pdf", "png"], "File formats; the report shows png.", allowed="a list of pdf and png"
    )
    series_cases: Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=1)] = setting(
        [0, 1, 2, 3, 4, 5],
        "Cases for which the wear depth is plotted over time.",
        allowed="a list of case numbers from 0",
    )
    typical: Typical = Field(
        default_factory=Typical, description="The representative case in figures."
    )
    angles: Angles = Field(
        default_factory=Angles, description="Curves for several plate and factory angles."
    )
    movie: Movie = Field(default_factory=Movie, description="The movie of snakemake movie.")
