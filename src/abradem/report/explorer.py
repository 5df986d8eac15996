"""The explorer: one page that predicts wear while sliders are moved, without any network.

The page holds the surrogate, the map surrogate and the cases of the data set, and computes in the
browser what `abradem predict` computes, to rounding. Its parts are in ``explorer_page``: the model
(model.js), what is seen and moved (page.html, page.js, style.css). The formulas of the groups are
written by `abradem.surrogate.javascript`. Charts are drawn by plotly.js, which the package plotly
brings.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from abradem.dataset.variation import SAME, held_fixed, scales_of
from abradem.quantities import quantity
from abradem.report.page_data import stored, whole_page
from abradem.report.page_files import EXPLORER_FILES
from abradem.surrogate.domain import HARMLESS, NEIGHBOURS, SLACK, Domain
from abradem.surrogate.geometry_groups import numbers_of, places_of, sampled_names
from abradem.surrogate.groups import Jet, input_names
from abradem.surrogate.javascript import group_functions
from abradem.surrogate.maps import MapSurrogate
from abradem.surrogate.model import Surrogate
from abradem.surrogate.networks import RateModel
from abradem.units import accepted, conversion
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget, place_of

MOST_CASES = 2000
"""Largest number of simulated cases in the page, the first of the study."""

DECADES = 20.0
"""Largest ratio of the ends of a range that is divided evenly."""

SECTIONS = {
    "Geometry": ("plate_angle", "factory_angle"),
    "Particles": (
        "particle_radius", "particle_velocity_y", "particle_density", "particle_shear_modulus",
        "particle_poisson_ratio",
    ),
    "Contact": ("static_friction", "rolling_friction", "restitution"),
    "Plate": (
        "archard_constant", "equipment_shear_modulus", "equipment_poisson_ratio",
        "equipment_density",
    ),
}  # fmt: skip
"""The sampled quantities in the order of the page; those of a geometry follow the angles."""

BESIDE = (
    "plate_angle", "factory_angle", "particle_radius", "particle_velocity_y", "archard_constant",
)  # fmt: skip
"""Quantities that are shown beside the nearest cases of a plate."""

MOST_BESIDE = 5
"""Largest number of quantities that are shown beside the nearest cases of a geometry."""


def explorer_page(
    model: tuple[Mapping, Mapping[str, np.ndarray]],
    maps: MapSurrogate | None,
    dataset: pd.DataFrame,
    study: str,
    presets: Mapping[str, Mapping[str, float]],
) -> str:
    """The page as HTML.

    Parameters
    ----------
    model : tuple of mapping
        Description and arrays of the surrogate, as in its two files.
    maps : MapSurrogate or None
        None for a study without maps.
    dataset : pandas.DataFrame
        The cases with case_id, the sampled quantities and the target.
    study : str
    presets : mapping of str to mapping
        Values of the quantities of each preset of materials.
    """
    description, arrays = model
    data = explorer_data(description, arrays, maps, dataset, study, presets)
    functions = group_functions(Surrogate(description, arrays).jet)
    scripts = [[functions, "model.js"], ["page.js"]]
    return whole_page(f"Wear explorer: {study}", EXPLORER_FILES, data, scripts)


def explorer_data(
    description: Mapping,
    arrays: Mapping[str, np.ndarray],
    maps: MapSurrogate | None,
    dataset: pd.DataFrame,
    study: str,
    presets: Mapping[str, Mapping[str, float]],
) -> dict[str, Any]:
    """What the page knows, as plain values; the parameters are those of `explorer_page`."""
    target = description["target"]
    surrogate = Surrogate(description, arrays)
    rows = dataset.sort_values("case_id").head(MOST_CASES)
    sections = sections_of(surrogate.jet)
    quantities = _quantities(description, sections, surrogate.jet.geometry)
    order = [one["name"] for one in quantities]
    varied = [one["name"] for one in quantities if not one["fixed"]]
    return {
        "study": study,
        "model": f"results/{study}/models/surrogate",
        "sections": [{"name": name, "quantities": list(of)} for name, of in sections.items()],
        "quantities": quantities,
        "beside": list(BESIDE if surrogate.jet.geometry is None else varied[:MOST_BESIDE]),
        "presets": {name: dict(values) for name, values in presets.items()},
        "training_rows": description.get("training_rows"),
        "group_mean": stored(arrays["group_mean"]),
        "group_scale": stored(arrays["group_scale"]),
        "rates": [_rate(model) for model in surrogate.models.values()],
        "harmless": HARMLESS,
        "domain": None if surrogate.domain is None else _domain(surrogate.domain),
        "jet_known": description.get("jet_known", True),
        "maps": None if maps is None else _maps(maps),
        "cases": {
            "ids": [int(key) for key in rows["case_id"]],
            "values": stored(rows[order].to_numpy(dtype=float)),
            "rates": stored(rows[target["name"]].to_numpy(dtype=float)),
        },
    }


def sections_of(jet: Jet) -> dict[str, tuple[str, ...]]:
    """The quantities of a surrogate in the order of the page, by section."""
    found = dict(SECTIONS)
    found["Geometry"] += sampled_names(jet.geometry)
    missing = set(input_names(jet)) - {name for names in found.values() for name in names}
    if missing:
        raise ValueError(f"the page has no place for {', '.join(sorted(missing))}")
    return found


def _quantities(
    description: Mapping, sections: Mapping[str, tuple[str, ...]], geometry: Mapping | None
) -> list[dict[str, Any]]:
    """The sampled quantities in the order of the page, with ranges, units and limits."""
    ranges = {one["name"]: one["training_range"] for one in description["features"]}
    found = []
    for name in (name for names in sections.values() for name in names):
        row, (low, high) = quantity(name), ranges[name]
        scale = scales_of([name])
        fixed = bool(held_fixed(np.array([[low], [high]]), scale)[0])
        # As `abradem predict` warns.
        slack = SAME * max(abs(low), abs(high), float(scale[0])) if fixed else SLACK * (high - low)
        units = {unit: conversion(unit, row.unit) for unit in accepted(row.unit)}
        found.append(
            {
                "name": name,
                "label": _label(name, geometry),
                "unit": row.unit,
                "shown_unit": row.config_unit,
                "factor": row.config_factor,
                "units": units,
                "limits": list(row.limits),
                "low": low,
                "high": high,
                "least": low - slack,
                "most": high + slack,
                "fixed": fixed,
                # Those have a logarithmic slider.
                "decades": not fixed and row.unit != "deg" and 0.0 < DECADES * low < high,
            }
        )
    return found


def _label(name: str, geometry: Mapping | None) -> str:
    """Name of a quantity, with the named plates of a chain that it belongs to."""
    numbers = numbers_of(geometry)
    parts = [
        part
        for part, place in places_of(geometry).items()
        if name.startswith(f"{place}_") or numbers.get(f"{place}_angle") == name
    ]
    return f"{LABELS[name].long_name} ({', '.join(parts)})" if parts else LABELS[name].long_name


def _rate(model: RateModel) -> dict[str, Any]:
    """Networks and held-out errors of one wear rate."""
    place = place_of(model.target)
    layers = {
        network: [{"weights": stored(weights), "biases": stored(biases)} for weights, biases in of]
        for network, of in model.layers.items()
    }
    return {
        "name": model.target["name"],
        "place": place[:1].upper() + place[1:],
        "scores": stored(model.scores),
        "at_least": model.at_least,
        **layers,
    }


def _domain(domain: Domain) -> dict[str, Any]:
    return {
        "rows": stored(domain.rows),
        "slopes": stored(domain.slopes),
        "limit": domain.limit,
        "neighbours": NEIGHBOURS,
    }


def _maps(maps: MapSurrogate) -> dict[str, Any]:
    description = maps.description
    plate, counts = description["plate"], maps.arrays["mean_map"].shape
    return {
        "counts": list(counts),
        "plate": [plate["length"], plate["width"]],
        "floor": maps.floor,
        "measure": description["target"]["measure"],
        "words": WearTarget(f"wear_{description['target']['measure']}_mean").explained,
        "scores": _map_scores(description),
        "arrays": {name: stored(array) for name, array in maps.arrays.items()},
    }


def _map_scores(description: Mapping) -> dict[str, float]:
    """Medians over the splits of the scores on held-out cases, as far as they are known."""
    scores = description.get("scores", {}).get(description.get("model"), {}).get("test", {})
    medians = {name: one["median"] for name, one in scores.items()}
    return {name: value for name, value in medians.items() if value is not None}
