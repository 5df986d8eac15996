"""The physics put into the features: dimensionless groups, and the scale of the wear.

A jet of stones brings the power m' v^2 / 2 to a plate of area A; Archard's constant W turns work
into worn volume. With the fall from the patch's height H the speed of impact is
v^2 = v_y^2 + 2 g H, so the wear depth rate has the natural scale

    s = W m' v^2 / (2 A)                                                    (mm/s)

and models learn the logarithm of the *wear number* y / s alone. W is an exact factor of the
simulation and never has to be learned. What remains can depend on dimensionless groups only
(Buckingham 1914, Phys. Rev. 4:345), `GROUPS`:

    ln Fr       Fr = v^2 / (g H)                 speed against fall
    ln R/H                                       size of the stones
    ln L        L = m' / (rho_p v B)             loading: share of the jet's cross-section B that
                                                 is filled with stone; how often stones meet
    ln Ca       Ca = rho_p v^2 / E*              Cauchy number: how deep an impact indents
    ln G*/E*                                     tangential against normal stiffness
    ln mu_s, ln mu_r, ln (1 + e)                 friction, rolling friction, restitution
    phi                                          plate angle, rad
    cos theta                                    width of the tilted patch's jet

The functions use arithmetic and numpy's functions alone, so that `abradem.onnx_export` can trace
them: no formula is written twice. The module imports numpy alone, as the surrogate needs it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from abradem.features import effective_shear_modulus, effective_youngs_modulus, youngs_modulus

LEAST_FRICTION = 1e-3
"""Smaller coefficients of friction count as this one: their logarithm would run away."""

MM_PER_M = 1e3


class Group(NamedTuple):
    """Name of a column, symbol in TeX, what it is in words."""

    name: str
    tex: str
    words: str


GROUPS: tuple[Group, ...] = (
    Group("log_froude", r"\ln Fr", "Froude number of the impact"),
    Group("log_size", r"\ln R/H", "radius over fall height"),
    Group("log_loading", r"\ln L", "loading of the jet"),
    Group("log_cauchy", r"\ln Ca", "Cauchy number of the impact"),
    Group("log_stiffness_ratio", r"\ln G^*/E^*", "tangential over normal stiffness"),
    Group("log_static_friction", r"\ln \mu_s", "static friction"),
    Group("log_rolling_friction", r"\ln \mu_r", "rolling friction"),
    Group("log_rebound", r"\ln (1+e)", "restitution"),
    Group("plate_angle", r"\varphi", "plate angle"),
    Group("jet_width", r"\cos\theta", "width of the jet"),
)
GROUP_NAMES = tuple(group.name for group in GROUPS)


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
    """Mass of stones per time, kg/s."""
    if jet.mass_rate is not None:
        return jet.mass_rate
    radius = values["particle_radius"]
    volume = 4.0 / 3.0 * np.pi * radius * radius * radius
    return jet.number_rate * volume * values["particle_density"]


def wear_scale(values: Mapping, jet: Jet):
    """s = W m' v^2 / (2 A), mm/s.

    Parameters
    ----------
    values : mapping of str to array
        The sampled quantities in the units of `abradem.parameters`.
    jet : Jet
    """
    power = 0.5 * mass_rate(values, jet) * squared_impact_speed(values, jet)
    return (MM_PER_M / jet.plate_area) * values["archard_constant"] * power


def group_columns(values: Mapping, jet: Jet) -> list:
    """The groups of `GROUPS`, in order, one array each.

    Parameters
    ----------
    values : mapping of str to array
        The sampled quantities in the units of `abradem.parameters`, angles in degrees.
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
