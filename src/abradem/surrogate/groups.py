"""The physics put into the features: dimensionless groups, and the scale of the wear.

A jet of particles brings the power m' v^2 / 2 to a plate of area A; Archard's constant W turns work
into worn volume. With the fall from the patch's height H the speed of impact is
v^2 = v_y^2 + 2 g H, so the wear depth rate has the natural scale

    s = W m' v^2 / (2 A)                                                    (mm/s)

and models learn the logarithm of the *wear number* y / s alone. W is an exact factor of the
simulation and never has to be learned. What remains can depend on dimensionless groups only
(Buckingham 1914, Phys. Rev. 4:345), `GROUP_NAMES`:

    ln Fr       Fr = v^2 / (g H)                 speed against fall
    ln R/H                                       size of the particles
    ln L        L = m' / (rho_p v B)             loading: share of the jet's cross-section B that
                                                 is filled with particle; how often particles meet
    ln Ca       Ca = rho_p v^2 / E*              Cauchy number: how deep an impact indents
    ln G*/E*                                     tangential against normal stiffness
    ln mu_s, ln mu_r, ln (1 + e)                 friction, rolling friction, restitution
    phi                                          plate angle, rad
    cos theta                                    width of the tilted patch's jet

The functions use arithmetic and numpy's functions alone, so that `abradem.surrogate.onnx` can trace
them: no formula is written twice. The module imports numpy alone, as the surrogate needs it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from abradem.elastic import (
    effective_shear_modulus,
    effective_youngs_modulus,
    sphere_mass,
    youngs_modulus,
)
from abradem.units import MM_PER_M

LEAST_FRICTION = 1e-3
"""Smaller coefficients of friction count as this one: their logarithm would run away."""


GROUP_NAMES = (
    "log_froude",
    "log_size",
    "log_loading",
    "log_cauchy",
    "log_stiffness_ratio",
    "log_static_friction",
    "log_rolling_friction",
    "log_rebound",
    "plate_angle",
    "jet_width",
)
"""Names of the groups, in the order of `group_columns`."""


class Jet(NamedTuple):
    """What is common to all cases of a study: SI units, one of the two rates is None."""

    fall_height: float
    gravity: float
    mass_rate: float | None
    number_rate: float | None
    plate_area: float
    patch_area: float


def jet_of(setup: Mapping) -> Jet:
    """The jet of the plain values of a `Setup` (`abradem.config.setup_dict`)."""
    return Jet(
        *(setup[name] for name in ("fall_height", "gravity", "mass_rate", "number_rate")),
        plate_area=setup["plate_length"] * setup["plate_width"],
        patch_area=setup["patch_length"] * setup["patch_width"],
    )


def squared_impact_speed(values: Mapping, jet: Jet):
    """v^2 = v_y^2 + 2 g H, m2/s2."""
    velocity = values["particle_velocity_y"]
    return velocity * velocity + 2.0 * jet.gravity * jet.fall_height


def mass_rate(values: Mapping, jet: Jet):
    """Mass of particles per time, kg/s."""
    if jet.mass_rate is not None:
        return jet.mass_rate
    return jet.number_rate * sphere_mass(values["particle_radius"], values["particle_density"])


def wear_scale(values: Mapping, jet: Jet):
    """s = W m' v^2 / (2 A), mm/s.

    Parameters
    ----------
    values : mapping of str to array
        The sampled quantities in the units of `abradem.quantities`.
    jet : Jet
    """
    power = 0.5 * mass_rate(values, jet) * squared_impact_speed(values, jet)
    return (MM_PER_M / jet.plate_area) * values["archard_constant"] * power


def group_columns(values: Mapping, jet: Jet) -> list:
    """The groups of `GROUP_NAMES`, in order, one array each.

    Parameters
    ----------
    values : mapping of str to array
        The sampled quantities in the units of `abradem.quantities`, angles in degrees.
    jet : Jet
    """
    nu_p, nu_e = values["particle_poisson_ratio"], values["equipment_poisson_ratio"]
    shear_p, shear_e = values["particle_shear_modulus"], values["equipment_shear_modulus"]
    young_star = effective_youngs_modulus(
        youngs_modulus(shear_p, nu_p), nu_p, youngs_modulus(shear_e, nu_e), nu_e
    )
    shear_star = effective_shear_modulus(shear_p, nu_p, shear_e, nu_e)
    squared = squared_impact_speed(values, jet)
    density = values["particle_density"]
    # Without gravity nothing falls, and the speed is compared with 1 m/s.
    fall = jet.gravity * jet.fall_height or 1.0
    in_jet = mass_rate(values, jet) / (jet.patch_area * density * np.sqrt(squared))
    degree = np.pi / 180.0
    return [
        np.log(squared / fall),
        np.log(values["particle_radius"] / jet.fall_height),
        np.log(in_jet),
        np.log(density * squared / young_star),
        np.log(shear_star / young_star),
        np.log(np.maximum(values["static_friction"], LEAST_FRICTION)),
        np.log(np.maximum(values["rolling_friction"], LEAST_FRICTION)),
        np.log(1.0 + values["restitution"]),
        degree * values["plate_angle"],
        np.cos(degree * values["factory_angle"]),
    ]


def group_matrix(values: Mapping, jet: Jet) -> np.ndarray:
    """The groups of n cases, shape (n, 10)."""
    return np.stack(np.broadcast_arrays(*group_columns(values, jet)), axis=-1)
