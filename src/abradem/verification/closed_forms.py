"""Exact solutions for spheres in contact: formulas with their assumptions.

Angles are measured from the normal of the plane. m mass, R radius, v_n and v_t normal and
tangential velocity before the impact, e restitution, mu static and mu_r rolling friction; SI
units. The solutions for slip and rolling follow from the balances of linear and angular momentum.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from abradem.elastic import hertz_duration, hertz_overlap, hertz_stiffness


class Hertz(NamedTuple):
    """Elastic normal impact: largest force (N) and overlap (m), duration (s)."""

    force: float
    overlap: float
    duration: float


def hertz(youngs_star: float, radius: float, mass: float, speed: float) -> Hertz:
    """Return the elastic normal impact for effective modulus (Pa), radius (m) and mass (kg).

    d_max = (5 m v^2 / (4 k))^{2/5} with k = 4/3 E* sqrt(R*), F_max = k d_max^{3/2},
    t_c = 2.94327 d_max / v (Hertz 1882). ``speed`` is the approach speed v, m/s.
    """
    stiffness = hertz_stiffness(youngs_star, radius)
    overlap = hertz_overlap(stiffness, mass, speed)
    return Hertz(stiffness * overlap**1.5, overlap, hertz_duration(stiffness, mass, speed))


class Slip(NamedTuple):
    """Outcome of an impact that slips from beginning to end.

    Velocity of the centre along the plane (m/s), spin, positive for forward rolling (rad/s), wear
    measure ``total`` (J) and friction work (J).
    """

    tangential_velocity: float
    spin: float
    total: float
    friction_work: float


def slip_angle_deg(mu: float, e: float, mu_r: float = 0.0) -> float:
    """Return the angle above which an impact slips: tan = (3.5 mu - 2.5 mu_r)(1 + e), deg."""
    return math.degrees(math.atan((3.5 * mu - 2.5 * mu_r) * (1.0 + e)))


def gross_slip(
    mass: float, radius: float, v_n: float, v_t: float, mu: float, e: float, mu_r: float = 0.0
) -> Slip:
    """Return the outcome of an impact with F_t = mu F_n throughout and no initial spin.

    Impulses: m dv_t = -mu m (1+e) v_n and I dw = R (mu - mu_r) m (1+e) v_n with I = 2/5 m R^2.
    ``total`` = int F_n v_c dt, where the velocity v_c of the contact point is linear in the
    impulse. Exact for e = 1.
    """
    impulse = mass * (1.0 + e) * v_n
    after = v_t - mu * impulse / mass
    spin = 2.5 * max(mu - mu_r, 0.0) * impulse / (mass * radius)
    mean_slip = v_t - (1.75 * mu - 1.25 * mu_r) * impulse / mass
    return Slip(after, spin, impulse * mean_slip, mu * impulse * mean_slip)


def friction_work(mass: float, before: float, after: float) -> float:
    """Return the friction work on a free sphere, (m/7)(v_c^2 - v_c'^2), J.

    v_c is the velocity of the contact point along the plane (``before`` and ``after``, m/s);
    mu_r = 0. A force F_t changes it by 7/2 F_t dt / m, so the work int F_t v_c dt does not depend
    on the tangential law.
    """
    return mass / 7.0 * (before**2 - after**2)


class Roll(NamedTuple):
    """Transition from sliding to rolling on a level plane: velocity (m/s), time (s), total (J)."""

    velocity: float
    time: float
    total: float


def slide_to_roll(mass: float, speed: float, mu: float, gravity: float) -> Roll:
    """Return the transition to rolling for a sphere with speed u0 and no spin on a level plane.

    It rolls with 5/7 u0 after the time 2 u0 / (7 mu g); the wear measure ``total`` until then is
    m u0^2 / (7 mu).
    """
    return Roll(5.0 / 7.0 * speed, 2.0 * speed / (7.0 * mu * gravity), mass * speed**2 / (7.0 * mu))


def incline_acceleration(angle_deg: float, mu: float, mu_r: float, gravity: float) -> float:
    """Return the acceleration of a sphere down an incline, m/s2: sliding, rolling or at rest."""
    sine, cosine = math.sin(math.radians(angle_deg)), math.cos(math.radians(angle_deg))
    if sine <= mu_r * cosine:
        return 0.0
    if sine > (3.5 * mu - 2.5 * mu_r) * cosine:
        return gravity * (sine - mu * cosine)
    return 5.0 / 7.0 * gravity * (sine - mu_r * cosine)


def belt_start(speed: float, mu: float, gravity: float) -> tuple[float, float]:
    """Return velocity (m/s) and time (s) at which a sphere on a level belt ceases to slip.

    A sphere at rest is put on a belt of speed V. It is accelerated by mu g and spun by 5/2 mu g/R
    until its lowest point has the speed of the belt: at 2/7 V, after 2 V / (7 mu g).
    """
    return 2.0 / 7.0 * speed, 2.0 * speed / (7.0 * mu * gravity)


def belt_acceleration(mu_r: float, gravity: float) -> float:
    """Return the acceleration of a sphere that rolls on a level belt, m/s2: 5/7 mu_r g.

    Its lowest point has the speed of the belt, and the rolling resistance mu_r m g R slows its
    spin; so the belt carries it up to its own speed.
    """
    return 5.0 / 7.0 * mu_r * gravity


def arc_speed(radius: float, sphere: float, begin_deg: float, gravity: float, rolls: bool) -> float:
    """Return the speed at the lowest line of a hollow cylinder of a sphere released at rest, m/s.

    The centre falls by (R_c - R)(1 - cos a) from the angle a; of the energy, a rolling sphere has
    5/7 in the motion of its centre.
    """
    fall = (radius - sphere) * (1.0 - math.cos(math.radians(begin_deg)))
    return math.sqrt((10.0 / 7.0 if rolls else 2.0) * gravity * fall)


def drum_angle_deg(mu_r: float) -> float:
    """Return the angle at which a sphere rests in a drum that turns slowly, deg: tan = mu_r.

    Friction F and weight balance along the wall, F R and the rolling resistance mu_r N R about the
    centre.
    """
    return math.degrees(math.atan(mu_r))


def drum_power(spin: float, mass: float, gravity: float, lever: float) -> float:
    """Return the power that keeps a bed in a drum in steady motion, W: omega M g x.

    Gravity acts with the lever ``lever`` (m), the horizontal distance of the centre of mass of the
    bed from the axis. The torque of the wall balances it, and the wall turns with ``spin`` (rad/s).
    In steady motion all of this power is dissipated, whatever the law of contact.
    """
    return spin * mass * gravity * lever


def corner_force(mass: float, slope_deg: float, gravity: float) -> float:
    """Return the normal force of each of two walls of equal slope, N, without friction."""
    return mass * gravity / (2.0 * math.cos(math.radians(slope_deg)))
