"""Conversion of a configuration to the plain values, in SI units, that the stages use."""

from __future__ import annotations

import yaml

from abradem.config.declaration import Config
from abradem.config.fields import to_si
from abradem.config.geometry import geometry_dict, geometry_ranges
from abradem.config.table_keys import STATED
from abradem.config.unused import unused_quantities
from abradem.quantities import SAMPLED


def to_yaml(config: Config) -> str:
    """Return the resolved configuration, every key with its value, as YAML."""
    return yaml.safe_dump(
        config.model_dump(mode="json"), sort_keys=False, default_flow_style=None, width=100
    )


def sampled_ranges(config: Config) -> dict[str, list[float]]:
    """Return {name: [lower, upper]} of the 14 sampled quantities in the units of tables (SI).

    A quantity that nothing depends on, as the plate angle beside a mesh, is held fixed: at the
    number of the study, or at 0 instead of a range.
    """
    ranges, fixed = config.sampling.ranges, unused_quantities(config)
    found = {
        row.name: [to_si(row, bound) for bound in getattr(ranges, row.config_key)]
        for row in SAMPLED
    }
    for name in fixed:
        if found[name][0] < found[name][1]:
            found[name] = [0.0, 0.0]
    return found


def typical_case(config: Config) -> dict[str, float]:
    """Return the quantities of the representative case and its seed, SI units.

    They are those of the geometry too, where these are sampled. On a geometry, a quantity whose
    value in ``figures.typical`` lies outside its range is in the middle of the range: the values
    are chosen for the plate of the paper.
    """
    ranges = sampled_ranges(config)
    chosen = config.figures.typical
    given = {
        row.name: to_si(row, getattr(chosen, row.config_key))
        for row in SAMPLED
        if hasattr(chosen, row.config_key)
    }
    if config.simulation.geometry.kind != "plate":
        given = {
            name: value
            for name, value in given.items()
            if ranges[name][0] <= value <= ranges[name][1]
        }
        ranges |= geometry_ranges(config)
    middle = {name: (low + high) / 2.0 for name, (low, high) in ranges.items()}
    return {**middle, **given, "seed": config.seed}


def rate_options(config: Config) -> dict:
    """Return the options of `abradem.wear.rates.wear_rates`, SI units."""
    size = config.wear_rate.element_size_mm
    if config.simulation.geometry.kind != "plate":
        # The statistics of a surface are over its cells.
        size = None
    return {
        "min_batches": config.wear_rate.min_batches,
        "footprint_share": config.wear_rate.footprint_share,
        "element_size": None if size is None else size / 1000.0,
    }


def target_dict(config: Config) -> dict:
    """Return the target of the study as arguments of `abradem.words.wear.WearTarget`, SI units.

    The size of the elements of an external table is not known, and what its rate is only where
    the study states it; the cells of a surface have no elements.
    """
    size = config.wear_rate.element_size_mm
    if size is None:
        size = config.simulation.plate.facet_size_mm
    simulated = config.dataset.external is None
    cells = simulated and config.simulation.geometry.kind != "plate"
    return {
        "name": config.learning.target,
        "element_size": size / 1000.0 if simulated and not cells else None,
        "known": simulated or config.dataset.rate == STATED,
        "cells": cells,
        "part": config.learning.part,
    }


def jet_is_known(config: Config) -> bool:
    """Whether ``simulation.plate`` and ``simulation.factory`` are those of the data set."""
    return config.dataset.external is None or config.dataset.jet == STATED


def contacts_of(config: Config) -> dict | None:
    """Return how particles meet each other, for the surrogate to tell.

    None if it is not known, as for a table from elsewhere; otherwise ``pair_interaction`` as in
    `setup_dict`.
    """
    if config.dataset.external is not None:
        return None
    return {"pair_interaction": setup_dict(config)["pair_interaction"]}


def setup_dict(config: Config) -> dict:
    """Return the arguments of `abradem.Setup` as plain JSON values, SI units.

    `abradem.Setup.from_dict` converts them to a `Setup`.
    """
    simulation = config.simulation
    plate, factory, stop = simulation.plate, simulation.factory, simulation.stop
    pair = simulation.pair_interaction
    geometry = geometry_dict(config)
    return {
        "plate_length": plate.length_mm / 1000.0,
        "plate_width": plate.width_mm / 1000.0,
        "facet_size": plate.facet_size_mm / 1000.0,
        "patch_length": factory.patch_length_mm / 1000.0,
        "patch_width": factory.patch_width_mm / 1000.0,
        "fall_height": factory.fall_height_mm / 1000.0,
        # The factory of a geometry does not swing.
        "angle_acts": factory.angle_acts if geometry is None else "level",
        "arc_radius": factory.arc_radius_mm / 1000.0 if geometry is None else 0.0,
        "mass_rate": factory.mass_rate_kg_s,
        "number_rate": factory.number_rate_per_s,
        "attempts": factory.attempts,
        "unplaced": factory.unplaced,
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
        # Only if there is one, so that set-ups with a plate stay what they were.
        **({} if geometry is None else {"geometry": geometry}),
    }
