"""Derived features: Young's moduli, effective moduli, damping ratio and coefficient.

Formulas of the Hertz-Mindlin contact of particle (1) and plate (2) as used in the paper (Hertz
1882; Mindlin & Deresiewicz 1953; Tsuji et al. 1992; see `abradem.elastic`)::

    E    = 2 G (1 + nu)
    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
    1/G* = (2 - nu1)/G1 + (2 - nu2)/G2
    xi   = ln e / sqrt(ln^2 e + pi^2)                      (negative, 0 at e = 1)

The damping coefficient eta (kg/s) has two forms. With the mass of the particle
m = 4/3 pi R^3 rho_p (the mass of the plate is infinite):

``table``
    eta = 2 sqrt(5/6) xi sqrt(m k), k = 4/3 E* R: negative. These are the values in the published
    table of the paper (to 2e-7, its rounding), so this form is the default: models trained on that
    table and on simulated data sets have the same feature.
``printed``
    eta = -2 sqrt(m k) ln e / sqrt(ln^2 e + pi^2), the same k: positive. This is the formula as
    printed in the paper; its value is that of ``table`` times -sqrt(6/5).

In both forms k, in N/m, is a constant of the case: it has R in place of the sqrt(R d) of a Hertz
stiffness. Neither form is used in the simulation, where the damping depends on the current
stiffness.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from abradem.elastic import (
    damping_ratio,
    effective_shear_modulus,
    effective_youngs_modulus,
    sphere_mass,
    youngs_modulus,
)
from abradem.quantities import FEATURE_NAMES, SAMPLED_NAMES

if TYPE_CHECKING:
    import pandas as pd

DAMPING_COEFFICIENTS = ("table", "printed")


def contact_damping(ratio, mass, youngs_star, radius, form="table"):
    """Return the damping coefficient eta, kg/s, in the form ``table`` or ``printed``.

    The formulas are in the docstring of the module.

    Parameters
    ----------
    ratio : float or array
        Damping ratio xi.
    mass : float or array
        Mass of the particle, kg.
    youngs_star : float or array
        E*, Pa.
    radius : float or array
        Radius of the particle, m.
    form : {"table", "printed"}
    """
    if form not in DAMPING_COEFFICIENTS:
        raise ValueError(
            f"damping_coefficient = {form!r} is unknown; allowed: {', '.join(DAMPING_COEFFICIENTS)}"
        )
    root = np.sqrt(mass * (4.0 / 3.0 * youngs_star * radius))
    if form == "table":
        return 2.0 * np.sqrt(5.0 / 6.0) * ratio * root
    return 0.0 - 2.0 * ratio * root


def derive(cases: pd.DataFrame, damping_coefficient: str = "table") -> pd.DataFrame:
    """Return the 20 features X1..X20 of cases, in this order.

    Parameters
    ----------
    cases : pandas.DataFrame
        Contains the 14 sampled columns, SI units (angles in degrees).
    damping_coefficient : {"table", "printed"}
        Form of X20, see the docstring of the module.

    Returns
    -------
    pandas.DataFrame
        Columns `abradem.quantities.FEATURE_NAMES`, with the index of ``cases``.

    Raises
    ------
    ValueError
        If ``cases`` lacks a sampled column.
    """
    missing = [name for name in SAMPLED_NAMES if name not in cases]
    if missing:
        raise ValueError(f"cases: lacks column {', '.join(missing)}")
    features = cases[list(SAMPLED_NAMES)].astype(float)
    nu_p, nu_e = features["particle_poisson_ratio"], features["equipment_poisson_ratio"]
    shear_p, shear_e = features["particle_shear_modulus"], features["equipment_shear_modulus"]
    young_p, young_e = youngs_modulus(shear_p, nu_p), youngs_modulus(shear_e, nu_e)
    young_star = effective_youngs_modulus(young_p, nu_p, young_e, nu_e)
    ratio = damping_ratio(features["restitution"])
    mass = sphere_mass(features["particle_radius"], features["particle_density"])
    eta = contact_damping(ratio, mass, young_star, features["particle_radius"], damping_coefficient)
    features = features.assign(
        particle_youngs_modulus=young_p,
        equipment_youngs_modulus=young_e,
        effective_youngs_modulus=young_star,
        effective_shear_modulus=effective_shear_modulus(shear_p, nu_p, shear_e, nu_e),
        damping_ratio=ratio,
        damping_coefficient=eta,
    )
    return features[list(FEATURE_NAMES)]
