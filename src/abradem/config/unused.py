"""Keys without meaning beside others, such as the length of the plate beside a mesh.

A value other than the default is refused there: who writes it expects it to do something.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from pydantic import BaseModel

from abradem.config.declaration import Config
from abradem.config.keys import Key, show

KINDS = ("plates", "arc", "mesh", "screw")
"""Kinds of geometries other than the plate. The keys of a kind are below its name."""

_OF_A_GEOMETRY = (
    "factory_centre_mm", "jet_direction", "removal_box_mm",
)  # fmt: skip
"""Keys of `simulation.geometry` of every kind but the plate."""

_OF_PARTS = ("wear_rate.reference_mm_s", "wear_rate.reference_source")
"""Keys for the named parts of a geometry, which the plate has none of."""

_OF_THE_PLATE = (
    "simulation.plate.length_mm",
    "simulation.plate.width_mm",
    "simulation.factory.angle_acts",
    "simulation.factory.arc_radius_mm",
    "wear_rate.element_size_mm",
    "figures.typical.factory_angle",
    "figures.angles",
    "figures.movie.plate_angles",
)
"""Keys that mean nothing beside another geometry."""

REPLACED_BY_A_MESH = (
    *(f"simulation.geometry.{name}" for name in KINDS),
    "simulation.geometry.moving",
    *_OF_THE_PLATE,
    "figures.typical.plate_angle",
    "sampling.ranges.plate_angle",
    "sampling.ranges.factory_angle",
    "learning.part",
)
"""Keys of the plate, or of the geometry of a study, that a mesh in its place replaces."""


def unused(config: Config) -> Iterator[tuple[Key, str]]:
    """Yield key and problem for each key that is not its default and means nothing."""
    for beside, names in _without_meaning(config):
        for name in names:
            for key, default in _changed(config, _defaults(), tuple(name.split("."))):
                yield key, f"means nothing beside {beside} (allowed {show(default)}, the default)"
    for name in unused_quantities(config):
        low, high = getattr(config.sampling.ranges, name)
        if low < high and (low, high) != getattr(_defaults().sampling.ranges, name):
            yield (
                ("sampling", "ranges", name),
                f"means nothing beside simulation.geometry.kind: {config.simulation.geometry.kind}"
                + (" without angle: plate_angle" if name == "plate_angle" else "")
                + " (allowed one number, which changes nothing)",
            )


def unused_quantities(config: Config) -> tuple[str, ...]:
    """Return the sampled quantities that nothing depends on, with the geometry of a study."""
    geometry = config.simulation.geometry
    if config.dataset.external is not None or geometry.kind == "plate":
        return ()
    return ("factory_angle",) if _takes_plate_angle(config) else ("plate_angle", "factory_angle")


def _takes_plate_angle(config: Config) -> bool:
    geometry = config.simulation.geometry
    return geometry.kind == "plates" and any(
        plate["angle"] == "plate_angle" for plate in geometry.plates
    )


def _without_meaning(config: Config) -> Iterator[tuple[str, list[str]]]:
    """Yield what stands beside, in words, and the keys that mean nothing there."""
    geometry = config.simulation.geometry
    above = "simulation.geometry"
    kind = f"{above}.kind: {geometry.kind}"
    others = [f"{above}.{name}" for name in KINDS if name != geometry.kind]
    if geometry.kind != "mesh":
        others.append(f"{above}.moving")
    if geometry.kind == "plate":
        yield kind, [*others, *(f"{above}.{name}" for name in _OF_A_GEOMETRY), *_OF_PARTS]
        return
    angle = [] if _takes_plate_angle(config) else ["figures.typical.plate_angle"]
    yield kind, [*others, *_OF_THE_PLATE, *angle]
    if geometry.factory_centre_mm is not None:
        yield f"{above}.factory_centre_mm", ["simulation.factory.fall_height_mm"]
    if config.wear_rate.reference_mm_s is None:
        yield "wear_rate.reference_mm_s: null", ["wear_rate.reference_source"]
    if geometry.removal_box_mm is not None:
        yield f"{above}.removal_box_mm", ["simulation.removal_depth_mm"]


def _changed(values: Any, defaults: Any, key: Key, above: Key = ()) -> Iterator[tuple[Key, Any]]:
    """Yield key and default of each value at or below a key that is not its default."""
    for name in key:
        values, defaults = getattr(values, str(name)), getattr(defaults, str(name))
    if isinstance(values, BaseModel):
        for name in type(values).model_fields:
            yield from _changed(values, defaults, (name,), (*above, *key))
    elif values != defaults:
        yield (*above, *key), list(defaults) if isinstance(defaults, tuple) else defaults


@cache
def _defaults() -> Config:
    return Config(study="default")
