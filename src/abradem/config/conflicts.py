"""Checks that involve several keys."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from abradem.config.declaration import Config
from abradem.config.keys import Key
from abradem.config.simulation_keys import Factory, PlateKeys, Stop
from abradem.config.table_keys import STATED
from abradem.config.unused import unused
from abradem.quantities import WEAR_MEASURES


def conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield key and problem for values that are valid alone but not together."""
    # Some file systems do not distinguish upper and lower case.
    if config.study.lower() in TAKEN_NAMES:
        yield ("study",), f"is taken by {TAKEN_NAMES[config.study.lower()]} (allowed: another name)"
    external = config.dataset.external
    if external is not None and _is_below(external, f"results/{config.study}"):
        yield (
            ("dataset", "external"),
            "is a result of this study itself (allowed: a file elsewhere, or another study)",
        )
    simulation = config.simulation
    yield from _feed_conflicts(simulation.factory)
    yield from _size_conflicts(config)

    yield from _part_conflicts(config)
    if simulation.geometry.kind == "plate":
        yield from _plate_conflicts(config)
    else:
        yield from _geometry_conflicts(config)
    yield from unused(config)

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
            yield key, "contains an item twice (allowed once each)"
    if "png" not in config.figures.formats:
        yield ("figures", "formats"), "must include png, which the report shows (allowed pdf, png)"


def _plate_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield the conflicts of the plate with its facets, elements of them, and particles."""
    plate = config.simulation.plate
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
    yield from _element_conflicts(config)
    factory = config.simulation.factory
    if factory.angle_acts == "arc" and factory.arc_radius_mm >= factory.fall_height_mm:
        yield (
            ("simulation", "factory", "arc_radius_mm"),
            f"must be less than the fall height (allowed below {factory.fall_height_mm:g} mm)",
        )


def _part_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield where the part that the models explain is not there."""
    part, geometry = config.learning.part, config.simulation.geometry
    if part is None:
        return
    above = ("learning", "part")
    if geometry.kind == "plate" or config.dataset.external is not None:
        yield above, "is for a simulated geometry (allowed null for a plate or a table)"
    elif geometry.kind == "plates":
        names = [
            plate.get("name") or f"plate_{place}" for place, plate in enumerate(geometry.plates, 1)
        ]
        if part not in names:
            yield above, f"there is no such plate (allowed {', '.join(names)})"
    if config.learning.fresh_blocks:
        yield ("learning", "fresh_blocks"), "knows no parts (allowed 0 with learning.part)"


def _geometry_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield what is missing for a geometry, and the stages that know the plate alone."""
    geometry = config.simulation.geometry
    above = ("simulation", "geometry")
    if geometry.kind == "plates" and not geometry.plates:
        yield (*above, "plates"), "kind: plates needs at least one plate"
    if geometry.kind == "mesh" and geometry.mesh.file is None:
        yield (*above, "mesh", "file"), "kind: mesh needs a file (allowed .stl, .obj or .ply)"
    if geometry.kind == "arc" and geometry.arc.begin == geometry.arc.end:
        yield (*above, "arc", "end"), "must differ from begin"
    screw = geometry.screw
    if geometry.kind == "screw" and _most(screw.shaft_radius_mm) >= _least(screw.radius_mm):
        yield (
            (*above, "screw", "shaft_radius_mm"),
            f"must be less than that of the flight (allowed below {_least(screw.radius_mm):g} mm)",
        )
    if not any(geometry.jet_direction):
        yield (*above, "jet_direction"), "must point somewhere (allowed such as [0, -1, 0])"
    if config.calibration.table is not None:
        yield (*above, "kind"), "a calibration knows the plate alone (allowed plate)"
    if config.dataset.external is not None:
        yield (*above, "kind"), "a table from elsewhere knows the plate alone (allowed plate)"


def _least(value: float | tuple[float, float]) -> float:
    return value[0] if isinstance(value, tuple) else value


def _most(value: float | tuple[float, float]) -> float:
    return value[1] if isinstance(value, tuple) else value


TAKEN_NAMES = {
    "verification": "the results of make verify",
    "benchmarks": "the results of make bench",
}
"""Folders under results/ that do not belong to a study."""

MOST_FACETS = 1_000_000
"""Largest number of facets; more would enlarge tables without resolving the wear better."""

MOST_CASES = 1_000_000
MOST_JOBS = 20_000
"""Largest number of simulation jobs; with more the workflow takes minutes to hours to start."""

MOST_SAMPLES = 100_000
"""Largest number of samples of the worn volume that the engine records for a case."""

MOST_MAP_BYTES = 4e9
"""Largest memory for the maps of wear by facet of a case; ten maps are kept for each window."""


def _is_below(path: str, folder: str) -> bool:
    try:
        return Path(path).resolve().is_relative_to(Path(folder).resolve())
    except (OSError, ValueError):
        return False


def _size_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield settings that would fill disk or memory, or with too many jobs to start."""
    sampling, simulation = config.sampling, config.simulation
    plate, stop = simulation.plate, simulation.stop
    if config.cases > MOST_CASES:
        yield (
            ("sampling", "blocks"),
            f"makes {config.cases} cases with {sampling.cases_per_block} in a block "
            f"(allowed up to {MOST_CASES} cases in all)",
        )
    elif config.jobs > MOST_JOBS:
        yield (
            ("simulation", "cases_per_job"),
            f"makes {config.jobs} simulation jobs (allowed up to {MOST_JOBS}; take more cases per "
            "job, or fewer and larger blocks)",
        )
    if simulation.geometry.kind == "plate":
        yield from _facet_conflicts(plate, stop)
    least = stop.max_time_s / MOST_SAMPLES
    if stop.sample_interval_s < least:
        yield (
            ("simulation", "stop", "sample_interval_s"),
            f"gives more than {MOST_SAMPLES} samples in max_time_s (allowed from {least:g} s)",
        )


def _facet_conflicts(plate: PlateKeys, stop: Stop) -> Iterator[tuple[Key, str]]:
    """Yield facets of the plate that would fill tables or memory."""
    facets = math.prod(
        math.ceil(side / plate.facet_size_mm) for side in (plate.length_mm, plate.width_mm)
    )
    maps = 10.0 * stop.max_time_s / stop.window_s
    if facets > MOST_FACETS:
        yield (
            ("simulation", "plate", "facet_size_mm"),
            f"divides the plate into {facets} facets (allowed up to {MOST_FACETS})",
        )
    elif maps * facets * len(WEAR_MEASURES) * 8.0 > MOST_MAP_BYTES:
        yield (
            ("simulation", "plate", "facet_size_mm"),
            f"with {facets} facets, {maps:.0f} maps of a case would fill the memory; take larger "
            "facets, a longer window or a shorter max_time_s "
            f"(allowed {MOST_MAP_BYTES / 1e9:g} GB)",
        )


def _element_conflicts(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield the conflicts of element sizes with the plate or its facets."""
    size, search = config.wear_rate.element_size_mm, config.calibration
    if size is not None and (problem := _element_problem(size, config.simulation.plate)):
        yield ("wear_rate", "element_size_mm"), problem
    if search.table is None:
        return
    for place, size in enumerate(search.element_sizes_mm):
        if problem := _element_problem(size, config.simulation.plate):
            yield ("calibration", "element_sizes_mm", place), problem
    if len(search.rows) != len(search.replicates):
        yield (
            ("calibration", "replicates"),
            f"rows and replicates must have the same number of rungs (rows has {len(search.rows)})",
        )


def _element_problem(size: float, plate: PlateKeys) -> str:
    """Return why elements of a size do not fit, or ""."""
    tiny = 1e-9
    for side in (plate.length_mm, plate.width_mm):
        facets = math.ceil(side / plate.facet_size_mm - tiny)
        elements = max(1, round(side / size))
        if abs(side / elements - size) > tiny * side or facets % elements:
            allowed = [f"{side / count:g}" for count in range(facets, 0, -1) if facets % count == 0]
            return (
                f"does not divide {side:g} mm of the plate into whole facets of "
                f"{side / facets:g} mm (allowed {', '.join(allowed[:12])})"
            )
    return ""


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
        yield ("learning", "physical", "sobol_points"), "is not a power of two"
    if config.dataset.columns and config.dataset.external is None:
        yield ("dataset", "columns"), "requires a table in dataset.external"
    if config.dataset.external is None:
        for key in ("jet", "rate"):
            if getattr(config.dataset, key) == STATED:
                yield ("dataset", key), "requires a table in dataset.external"


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
