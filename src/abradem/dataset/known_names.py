"""The names under which quantities are known in tables and on the command line.

A name is compared without its case, with one underscore between its words. The module imports no
pandas, as `abradem predict` for single cases does without it.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from abradem.quantities import GEOMETRY_UNITS, TARGET, quantity

PUBLISHED_NAMES = {
    "particle_youngs_modulus": "Young's Modulus (Material)",
    "particle_shear_modulus": "Shear Modulus (Material)",
    "particle_poisson_ratio": "Poisson's Ratio (Material)",
    "particle_density": "Density (Material)",
    "equipment_youngs_modulus": "Young's Modulus (Equipment)",
    "equipment_shear_modulus": "Shear Modulus (Equipment)",
    "equipment_poisson_ratio": "Poisson's Ratio (Equipment)",
    "equipment_density": "Density (Equipment)",
    "restitution": "Coefficient of Restitution (Interaction)",
    "rolling_friction": "Coefficient of Rolling Friction (Interaction)",
    "static_friction": "Coefficient of Static Friction (Interaction)",
    "archard_constant": "Archard Wear Constant",
    "plate_angle": "Plate Angle",
    "factory_angle": "Factory Angle",
    "particle_radius": "Particle Size",
    "particle_velocity_y": "Factory Z Velocity",
    "effective_youngs_modulus": "Equivalent Young's Modulus (E*)",
    "effective_shear_modulus": "Equivalent Shear Modulus (G*)",
    "damping_ratio": "Logarithmic Damping Ratio (ξ)",
    "damping_coefficient": "Damping Coefficient (η)",
    TARGET.name: "Wear Rate",
}
"""Columns of the published table of the paper. Its particle size is the radius, m."""

MAY_MEAN = {
    "particle_radius": ("radius", "r", "size", "diameter", "dia", "d", "d50", "d_50", "grain_size"),
    "particle_density": ("density", "rho", "rho_p"),
    "particle_velocity_y": ("velocity", "speed", "v", "vy", "v_y", "impact_speed"),
    "plate_angle": ("angle", "inclination", "slope", "phi"),
    "factory_angle": ("theta",),
    "restitution": ("cor", "e"),
    "static_friction": ("friction", "mu", "mu_s"),
    "rolling_friction": ("mu_r",),
    "archard_constant": ("w", "k", "wear_constant", "wear_coefficient", "specific_wear_rate"),
    "particle_shear_modulus": ("g", "g_p", "e_modulus", "e_p", "youngs_modulus"),
    "equipment_shear_modulus": ("g_e", "e_e"),
    "particle_poisson_ratio": ("nu", "nu_p", "poisson"),
}
"""What may be meant by names that are not known; they are asked back, never taken."""

GEOMETRY_KEYS = {"m": "{}_mm", "deg": "{}_deg", "m/s": "{}_m_s", "rev/min": "{}_rev_per_min"}
"""Names of the quantities of a geometry with their unit, as in the configuration."""

_ALIKE = 0.8
"""Similarity of two names (Ratcliff and Obershelp) from which one may be meant by the other."""

_GENERAL = {"particle", "equipment", "plate", "factory", "material", "interaction", "coefficient",
            "of", "wear"}  # fmt: skip
"""Words that alone do not tell which quantity a column is meant for."""

_INVISIBLE = dict.fromkeys([0x200B, 0x200C, 0x200D, 0x200E, 0x200F, 0x2060, 0xFEFF])


def visible(name: str) -> str:
    """Return a name without blanks around it and without characters that are not seen."""
    return name.translate(_INVISIBLE).strip()


def normal(name: str) -> str:
    """Return a name without case, with one underscore between its words."""
    return re.sub(r"[\s_.-]+", "_", visible(name).lower()).strip("_")


def names_of(name: str) -> dict[str, str | None]:
    """Return the normal names under which a quantity is known, each with its unit or None."""
    names: dict[str, str | None] = {normal(name): None}
    if name in PUBLISHED_NAMES:
        published = PUBLISHED_NAMES[name]
        names[normal(published)] = None
        names[normal(published.removesuffix(" (Interaction)"))] = None
        row = quantity(name)
        if row.config_suffix:
            names[normal(row.config_key)] = row.config_unit
    if name in GEOMETRY_UNITS:
        key = GEOMETRY_KEYS[GEOMETRY_UNITS[name]].format(name.removesuffix("_revolutions"))
        names[key] = quantity(name).config_unit
    return names


def known_quantity(text: str, among: Iterable[str]) -> tuple[str, str | None] | None:
    """Return the quantity that a name stands for and the unit in the name, or None.

    The symbols X1 ... X20 are known as they are written, in capitals.
    """
    key = normal(text)
    for name in among:
        known = names_of(name)
        if key in known:
            return name, known[key]
        if name in PUBLISHED_NAMES and text.strip() == quantity(name).symbol:
            return name, None
    return None


def may_mean(text: str, name: str) -> bool:
    """Whether a name that is not known may be meant for a quantity."""
    key = normal(text)
    if not key:
        return False
    if key in MAY_MEAN.get(name, ()):
        return True
    known = list(names_of(name))
    own = set(key.split("_")) - _GENERAL
    # A diameter is asked back as well, whatever stands with it.
    if name == "particle_radius" and own & {"diameter", "dia", "d50"}:
        return True
    for one in known:
        words = set(one.split("_")) - _GENERAL
        if own and words and (own <= words or words <= own):
            return True
    return bool(difflib.get_close_matches(key, known, 1, _ALIKE))


def hint_for(text: str, among: Iterable[str]) -> str:
    """Return what may be meant by a name, as "did you mean ...?", or ""."""
    among = list(among)
    key = normal(text)
    if set(key.split("_")) & {"diameter", "dia", "d50"} and "particle_radius" in among:
        return "give half of it as particle_radius"
    meant = [name for name in among if key in MAY_MEAN.get(name, ())]
    meant = meant or difflib.get_close_matches(key, among, 1, 0.6)
    meant = meant or [name for name in among if may_mean(text, name)]
    return f"did you mean {meant[0]}?" if meant else ""
