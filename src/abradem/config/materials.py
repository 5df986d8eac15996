"""Material presets for `abradem predict`: particle materials on a steel plate.

The values are typical. Rocks and coals of the same name differ by more than the error of the
model, so measure them where accuracy matters. Restitution and friction depend on the shape,
moisture and surface finish of both bodies; where no measurement is cited, they are the middle of
the paper's ranges.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import NamedTuple

from abradem.elastic import shear_modulus


class Preset(NamedTuple):
    """Quantities in the units of `abradem.quantities`, and their source."""

    values: dict[str, float]
    source: str


def _particle(shear_modulus: float, poisson_ratio: float, density: float) -> dict[str, float]:
    return {
        "particle_shear_modulus": shear_modulus,
        "particle_poisson_ratio": poisson_ratio,
        "particle_density": density,
    }


# The middle of the paper's ranges: an assumption, not a measurement.
_ASSUMED = {"restitution": 0.5, "static_friction": 0.475, "rolling_friction": 0.055}

PLATE_MATERIALS: dict[str, Preset] = {
    "steel": Preset(
        {
            "equipment_shear_modulus": shear_modulus(210e9, 0.3),
            "equipment_poisson_ratio": 0.3,
            "equipment_density": 7850.0,
        },
        "Hlosta et al. 2020, Processes 8:222 (E 210 GPa, nu 0.3, 7850 kg/m3)",
    ),
}

PARTICLE_MATERIALS: dict[str, Preset] = {
    "coal": Preset(
        {**_particle(2.01e9, 0.32, 1540.0), **_ASSUMED},
        "G and nu from G 2.01, K 4.91 GPa of a seam: Scientific Reports 2024, "
        "doi 10.1038/s41598-024-79523-8, table 1; density: Complexity 2019, 4021368, table 3; "
        "restitution and friction assumed",
    ),
    "iron_ore": Preset(
        {**_particle(shear_modulus(100e9, 0.25), 0.25, 4000.0), **_ASSUMED},
        "typical of hematite ore, Schoen 2015, Physical Properties of Rocks, 2nd ed., Elsevier "
        "(rounded); restitution and friction assumed",
    ),
    "limestone": Preset(
        {**_particle(shear_modulus(50e9, 0.25), 0.25, 2700.0), **_ASSUMED},
        "typical, Schoen 2015 (rounded); nu within the range of Gercek 2007, Int. J. Rock Mech. "
        "Min. Sci. 44:1; restitution and friction assumed",
    ),
    "granite": Preset(
        {**_particle(shear_modulus(50e9, 0.25), 0.25, 2650.0), **_ASSUMED},
        "typical, Schoen 2015 (rounded); nu within the range of Gercek 2007, Int. J. Rock Mech. "
        "Min. Sci. 44:1; restitution and friction assumed",
    ),
}


def material_name(text: str) -> str | None:
    """Return the name of a preset, whatever case and separators, or None if there is none."""
    plain = _plain(text)
    return plain if plain in PARTICLE_MATERIALS or plain in PLATE_MATERIALS else None


def similar_material(text: str, known: Iterable[str]) -> str:
    """Return the preset among ``known`` that a text resembles, or ""."""
    return next(iter(difflib.get_close_matches(_plain(text), list(known), n=1, cutoff=0.6)), "")


def _plain(text: str) -> str:
    return text.strip().lower().replace("-", "_").replace(" ", "_")


def preset(particle: str, plate: str = "steel") -> dict[str, float]:
    """Quantities of a particle material on a plate material.

    Returns
    -------
    dict of str to float
        In the units of `abradem.quantities`.

    Raises
    ------
    KeyError
        If a material is unknown.
    """
    return {**PLATE_MATERIALS[plate].values, **PARTICLE_MATERIALS[particle].values}
