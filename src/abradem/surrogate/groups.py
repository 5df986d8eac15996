"""Dimensionless groups and the scale of the wear: the features of the physics-informed models.

A jet of particles with the mass rate m' delivers the power m' v^2 / 2 to a plate of area A, and
Archard's constant W converts work into worn volume. Particles that fall from the height H hit the
plate with v^2 = v_y^2 + 2 g H. The wear depth rate therefore has the natural scale ::

    s = W m' v^2 / (2 A)                                                    (mm/s)

and the models learn only the logarithm of the *wear number* y / s. W is an exact factor of the
simulated wear and need not be learned. The wear number depends on dimensionless groups only
(Buckingham 1914, Phys. Rev. 4:345), `GROUP_NAMES`::

    ln Fr       Fr = v^2 / (g H)                 Froude number: speed against fall height
    ln R/H                                       size of the particles
    ln L        L = m' / (rho_p v B)             loading: volume fraction of particles in the jet
                                                 of cross-section B; how often particles collide.
                L = rho_p / rho_w                with a feed by number: mass against that of as
                                                 many drops of water
    ln Ca       Ca = rho_p v^2 / E*              Cauchy number: depth of the indentation
    ln G*/E*                                     tangential against normal stiffness
    ln mu_s, ln mu_r, ln (1 + e)                 friction, rolling friction, restitution
    phi                                          plate angle, rad
    cos theta                                    width of the jet of a tilted factory patch; 1 if
                                                 the patch stays level

H is the fall height at a factory angle of 0, the same length for all cases. Where the factory moves
on an arc, the fall height of a case depends on theta and enters by the speed of impact alone:
vertical falls from two heights that end with one speed are one jet. Measured by the fall height of
the case, all of Fr, R/H and theta would vary with theta, although it hardly matters.

With a feed by number m' = n' m, with the mass m of a particle, the loading n' m / (rho_p v B) would
be a function of R/H and Fr, and no fit could tell the three apart. The loading by mass instead of
volume is independent of them.

On a geometry A is the area of the factory's patch, which is the same for all cases, and each
sampled quantity of the geometry has a group of its own (`abradem.surrogate.geometry_groups`).

The functions use only arithmetic and numpy functions, so that `abradem.surrogate.onnx` can trace
them and no formula is written twice. The module needs no other package than numpy, so that the
surrogate needs none.
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
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.geometry_groups import (
    geometry_columns,
    geometry_group_names,
    sampled_names,
)
from abradem.units import MM_PER_M

_DEGREE = np.pi / 180.0

WATER_DENSITY = 1000.0
"""Density to which that of particles is related, kg/m3."""

LEAST_FRICTION = 1e-3
"""Smallest coefficient of friction; smaller ones are raised to it before the logarithm."""


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
"""Names of the groups of the plate, in the order of `group_columns`."""


class Jet(NamedTuple):
    """Quantities that are the same for all cases of a study.

    Attributes
    ----------
    fall_height : float
        At a factory angle of 0, m.
    gravity : float
        m/s2.
    mass_rate, number_rate : float or None
        Feed in kg/s or in particles per second; the other one is None.
    plate_area, patch_area : float
        m2; on a geometry both are that of the patch.
    angle_acts : {"tilt", "level", "arc"}
        How the factory angle acts, see `abradem.Setup.patch_place`.
    arc_radius : float
        m.
    geometry : mapping or None
        Surface that is no plate, as plain values (`abradem.config.geometry.geometry_dict`).
    """

    fall_height: float
    gravity: float
    mass_rate: float | None
    number_rate: float | None
    plate_area: float
    patch_area: float
    angle_acts: str = "tilt"
    arc_radius: float = 0.0
    geometry: Mapping | None = None

    def stored(self) -> dict:
        """As stored in a file; a plate needs no geometry."""
        found = self._asdict()
        if self.geometry is None:
            del found["geometry"]
        return found


def input_names(jet: Jet) -> tuple[str, ...]:
    """Names of the quantities that a prediction needs: the sampled ones, also of a geometry."""
    return (*SAMPLED_NAMES, *sampled_names(jet.geometry))


def group_names(jet: Jet) -> tuple[str, ...]:
    """Names of the groups of `group_columns`, in their order; those of the plate come first."""
    return (*GROUP_NAMES, *geometry_group_names(jet.geometry))


def jet_of(setup: Mapping) -> Jet:
    """Jet of a set-up, given as plain values of a `Setup` (`abradem.config.setup_dict`)."""
    patch_area = setup["patch_length"] * setup["patch_width"]
    jet = Jet(
        fall_height=setup["fall_height"],
        gravity=setup["gravity"],
        mass_rate=setup["mass_rate"],
        number_rate=setup["number_rate"],
        plate_area=setup["plate_length"] * setup["plate_width"],
        patch_area=patch_area,
        angle_acts=setup["angle_acts"],
        arc_radius=setup["arc_radius"],
    )
    if not setup.get("geometry"):
        return jet
    # The patch above a geometry is level, and the plate is not there.
    return jet._replace(
        plate_area=patch_area, angle_acts="level", arc_radius=0.0, geometry=setup["geometry"]
    )


def fall_height(values: Mapping, jet: Jet):
    """Height of the centre of the patch above the centre of the plate, m."""
    if jet.angle_acts != "arc":
        return jet.fall_height
    return jet.fall_height - jet.arc_radius * (1.0 - np.cos(_DEGREE * values["factory_angle"]))


def jet_width(values: Mapping, jet: Jet):
    """Width of the jet as a share of the length of the patch."""
    angle = values["factory_angle"]
    return np.cos(_DEGREE * angle) if jet.angle_acts == "tilt" else 1.0 + 0.0 * angle


def squared_impact_speed(values: Mapping, jet: Jet):
    """Square of the impact speed, v^2 = v_y^2 + 2 g H, m2/s2."""
    velocity = values["particle_velocity_y"]
    return velocity * velocity + 2.0 * jet.gravity * fall_height(values, jet)


def mass_rate(values: Mapping, jet: Jet):
    """Mass rate of the feed, kg/s."""
    if jet.mass_rate is not None:
        return jet.mass_rate
    return jet.number_rate * sphere_mass(values["particle_radius"], values["particle_density"])


def wear_scale(values: Mapping, jet: Jet):
    """Scale of the wear depth rate, s = W m' v^2 / (2 A), mm/s.

    Parameters
    ----------
    values : mapping of str to array, shape (n,)
        The sampled quantities in the units of `abradem.quantities`.
    jet : Jet

    Returns
    -------
    array, shape (n,)
    """
    power = 0.5 * mass_rate(values, jet) * squared_impact_speed(values, jet)
    return (MM_PER_M / jet.plate_area) * values["archard_constant"] * power


def group_columns(values: Mapping, jet: Jet) -> list:
    """The groups of `group_names`, in this order, one array each.

    Parameters
    ----------
    values : mapping of str to array, shape (n,)
        The quantities of `input_names` in the units of `abradem.quantities`, angles in degrees.
    jet : Jet

    Returns
    -------
    list of array, shape (n,)
        Dimensionless; angles in rad.
    """
    nu_p, nu_e = values["particle_poisson_ratio"], values["equipment_poisson_ratio"]
    shear_p, shear_e = values["particle_shear_modulus"], values["equipment_shear_modulus"]
    young_star = effective_youngs_modulus(
        youngs_modulus(shear_p, nu_p), nu_p, youngs_modulus(shear_e, nu_e), nu_e
    )
    shear_star = effective_shear_modulus(shear_p, nu_p, shear_e, nu_e)
    squared = squared_impact_speed(values, jet)
    density = values["particle_density"]
    height = jet.fall_height
    # Without gravity the speed is compared with 1 m/s instead.
    fall = jet.gravity * height if jet.gravity else 1.0
    if jet.mass_rate is not None:
        loading = jet.mass_rate / (jet.patch_area * density * np.sqrt(squared))
    else:
        loading = density / WATER_DENSITY
    return [
        np.log(squared / fall),
        np.log(values["particle_radius"] / height),
        np.log(loading),
        np.log(density * squared / young_star),
        np.log(shear_star / young_star),
        np.log(np.maximum(values["static_friction"], LEAST_FRICTION)),
        np.log(np.maximum(values["rolling_friction"], LEAST_FRICTION)),
        np.log(1.0 + values["restitution"]),
        _DEGREE * values["plate_angle"],
        jet_width(values, jet),
        *geometry_columns(values, jet.geometry, height, squared),
    ]


def group_matrix(values: Mapping, jet: Jet) -> np.ndarray:
    """The groups of n cases as a matrix (n, 10 and those of a geometry); see `group_columns`."""
    return np.stack(np.broadcast_arrays(*group_columns(values, jet)), axis=-1)
