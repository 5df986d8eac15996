"""Formulas for elastic spheres in contact: moduli, masses, Hertz contact, Rayleigh time.

Arguments are numbers or arrays in SI units. Index 1 is the particle, index 2 its partner.

Hertz 1882, J. reine angew. Math. 92:156 (E*, overlap, duration); Mindlin and Deresiewicz 1953,
J. Appl. Mech. 20:327 (G*); Johnson 1985, Contact Mechanics, 11.4 (duration of an impact);
Thornton 2015, Granular Dynamics, Contact Mechanics and Particle System Simulations (Rayleigh time).
"""

from __future__ import annotations

import math

import numpy as np

HERTZ_DURATION = 0.8 * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)
"""Duration of an elastic impact, in units of largest overlap over speed: 4/5 B(2/5, 1/2)."""


def youngs_modulus(shear_modulus, poisson_ratio):
    """Young's modulus E = 2 G (1 + nu), Pa."""
    return 2.0 * shear_modulus * (1.0 + poisson_ratio)


def shear_modulus(youngs_modulus, poisson_ratio):
    """Shear modulus G = E / (2 (1 + nu)), Pa."""
    return youngs_modulus / (2.0 * (1.0 + poisson_ratio))


def effective_youngs_modulus(youngs_1, poisson_1, youngs_2, poisson_2):
    """E* from 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, Pa (Hertz 1882); an infinite E is rigid."""
    return 1.0 / ((1.0 - poisson_1**2) / youngs_1 + (1.0 - poisson_2**2) / youngs_2)


def effective_shear_modulus(shear_1, poisson_1, shear_2, poisson_2):
    """G* from 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, Pa (Mindlin & Deresiewicz 1953)."""
    return 1.0 / ((2.0 - poisson_1) / shear_1 + (2.0 - poisson_2) / shear_2)


def damping_ratio(restitution):
    """xi = ln e / sqrt(ln^2 e + pi^2), dimensionless, in (-1, 0] (Tsuji et al. 1992)."""
    log_e = np.log(restitution)
    return log_e / np.sqrt(log_e**2 + np.pi**2)


def sphere_volume(radius):
    """Volume of a sphere, 4/3 pi R^3, m3."""
    return 4.0 / 3.0 * math.pi * radius**3


def sphere_mass(radius, density):
    """Mass of a sphere, 4/3 pi R^3 rho, kg."""
    return sphere_volume(radius) * density


def hertz_stiffness(youngs_star, radius):
    """k = 4/3 E* sqrt(R*) of the normal force F = k d^(3/2), N/m^(3/2) (Hertz 1882)."""
    return 4.0 / 3.0 * youngs_star * np.sqrt(radius)


def hertz_overlap(stiffness, mass, speed):
    """Largest overlap of an elastic impact, (5 m* v^2 / (4 k))^(2/5), m (Hertz 1882).

    Parameters
    ----------
    stiffness : float or ndarray
        From `hertz_stiffness`.
    mass : float or ndarray
        Effective mass m*, kg.
    speed : float or ndarray
        Speed of approach, m/s.
    """
    return (5.0 * mass * speed**2 / (4.0 * stiffness)) ** 0.4


def hertz_duration(stiffness, mass, speed):
    """Duration of an elastic impact, 2.94327 d_max / v, s (Johnson 1985).

    The parameters are those of `hertz_overlap`.
    """
    return HERTZ_DURATION * hertz_overlap(stiffness, mass, speed) / speed


def rayleigh_time(radius, density, shear_modulus, poisson_ratio):
    """Rayleigh time pi R sqrt(rho/G) / (0.1631 nu + 0.8766), s (Thornton 2015).

    The time in which a surface wave travels around half the sphere.
    """
    travel = math.pi * radius * np.sqrt(density / shear_modulus)
    return travel / (0.1631 * poisson_ratio + 0.8766)
