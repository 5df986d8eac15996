"""Checks whether a parameter set is physically consistent with the set-up."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from abradem.elastic import (
    effective_youngs_modulus,
    hertz_duration,
    hertz_overlap,
    hertz_stiffness,
    rayleigh_time,
    sphere_mass,
    youngs_modulus,
)
from abradem.geometry.build import prepared
from abradem.geometry.shape import GeometryError
from abradem.quantities import SAMPLED, check_value

if TYPE_CHECKING:
    from abradem.dem.model import Setup


LARGEST_OVERLAP = 0.2
"""Largest overlap at impact, as a share of the radius, for which the Hertz theory is used."""


FEWEST_STEPS = 8
"""Smallest number of time steps in an impact."""


def check_case(values: Mapping[str, float], setup: Setup | None = None) -> str:
    """Return the reason why a parameter set cannot be simulated, or an empty string.

    Parameters
    ----------
    values : mapping of str to float
        The sampled quantities, in the units of `abradem.quantities`.
    setup : Setup, optional
        If given, the parameter set is also checked against plate, factory and time step. The
        particle must not be wider than the plate and must not touch it at its release. An impact
        from the full fall height must overlap by less than 20 % of the radius and must last
        enough time steps.
    """
    for row in SAMPLED:
        problem = check_value(row.name, values[row.name])
        if problem:
            return problem
    if setup is None:
        return ""
    if setup.geometry is not None and setup.surface is None:
        try:
            setup = prepared(setup, values)
        except GeometryError as error:
            return str(error)
    return _check_geometry(values, setup) or _check_impact(values, setup)


def _check_geometry(values: Mapping[str, float], setup: Setup) -> str:
    if setup.surface is not None:
        # The engine releases no particle into the surface.
        return ""
    radius = values["particle_radius"]
    narrow = min(setup.plate_length, setup.plate_width)
    if 2.0 * radius > narrow:
        return f"particle of radius {radius:g} m is wider than the plate ({narrow:g} m)"
    plate = _segment(0.0, setup.plate_length, values["plate_angle"])
    height, tilt = setup.patch_place(values["factory_angle"])
    patch = _segment(height, setup.patch_length, tilt)
    clearance = _segment_distance(*plate, *patch)
    if clearance <= radius:
        return (
            f"the factory patch comes within {clearance:.3g} m of the plate, "
            f"closer than the radius {radius:.3g} m"
        )
    return ""


def _check_impact(values: Mapping[str, float], setup: Setup) -> str:
    """Check overlap and duration of a normal elastic impact (Hertz 1882) at the end of the fall."""
    radius = values["particle_radius"]
    if setup.surface is None or setup.feed is None:
        height, _ = setup.patch_place(values["factory_angle"])
    else:
        height = setup.feed.centre[1] - float(setup.surface.vertices[:, 1].min())
    speed = math.sqrt(values["particle_velocity_y"] ** 2 + 2.0 * setup.gravity * height)
    if speed == 0.0:
        return "the particle neither starts with a velocity nor falls"
    mass = sphere_mass(radius, values["particle_density"])
    nu_p, nu_e = values["particle_poisson_ratio"], values["equipment_poisson_ratio"]
    young_p = youngs_modulus(values["particle_shear_modulus"], nu_p)
    young_e = youngs_modulus(values["equipment_shear_modulus"], nu_e)
    stiffness = hertz_stiffness(effective_youngs_modulus(young_p, nu_p, young_e, nu_e), radius)
    overlap = hertz_overlap(stiffness, mass, speed)
    if overlap > LARGEST_OVERLAP * radius:
        return (
            f"an impact at {speed:.3g} m/s would overlap by {overlap / radius:.0%} of the radius "
            f"(allowed {LARGEST_OVERLAP:.0%}): too soft for this speed"
        )
    step = setup.time_step or setup.time_step_fraction * rayleigh_time(
        radius,
        values["particle_density"],
        values["particle_shear_modulus"],
        values["particle_poisson_ratio"],
    )
    steps = hertz_duration(stiffness, mass, speed) / step
    if steps < FEWEST_STEPS:
        return (
            f"an impact at {speed:.3g} m/s lasts {steps:.1f} time steps "
            f"(allowed at least {FEWEST_STEPS}): the time step is too long"
        )
    return ""


def _segment(height: float, length: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends, shape (2,), of a line about (0, height) tilted by ``angle``, deg."""
    half = 0.5 * length * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    centre = np.array([0.0, height])
    return centre - half, centre + half


def _segment_distance(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Return the distance between the segments ab and cd in the plane."""

    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    if side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0:
        return 0.0

    def to_segment(p, q, r):
        along = np.clip(np.dot(r - p, q - p) / np.dot(q - p, q - p), 0.0, 1.0)
        return float(np.hypot(*(r - p - along * (q - p))))

    return min(to_segment(a, b, c), to_segment(a, b, d), to_segment(c, d, a), to_segment(c, d, b))
