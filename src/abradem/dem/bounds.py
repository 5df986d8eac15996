"""Lower bounds of the time until particles can touch something: see `islands`.

All flights are parabolas with the same acceleration. The relative path of two flying particles
is therefore a straight line, and the time at which a particle meets the plate is the root of a
quadratic equation.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import NEVER, SAFETY
from abradem.dem.cache import kernel
from abradem.dem.vectors import dot

ALMOST_ONE = 1.0 - 1e-6
"""Added to a number of steps before its fraction is dropped: one less than 1 by more than the
rounding error of the number."""


@kernel(inline=True)
def first_time_within(x, v, a, half, start):
    """First time t >= start with abs(x + v t + a t^2/2) <= half, or infinity."""
    here = x + start * (v + 0.5 * a * start)
    speed = v + a * start
    if here < 0.0:
        here, speed, a = -here, -speed, -a
    gap = here - half
    if gap <= 0.0:
        return start
    discriminant = speed * speed - 2.0 * a * gap
    if discriminant < 0.0:
        return np.inf
    down = math.sqrt(discriminant) - speed
    if down <= 0.0:
        return np.inf
    return start + 2.0 * gap / down


@kernel
def time_to_plate(problem, x, y, z, vx, vy, vz):
    """Lower bound of the time until a flying particle can touch the plate, s.

    This is the first time at which the centre is in a box that extends one radius beyond the
    plate on all sides. The first times along the three axes are iterated until they agree.
    """
    plate = problem.plate
    grown = problem.radius * (1.0 + SAFETY)
    along, height = plate.cos * x + plate.sin * y, -plate.sin * x + plate.cos * y
    v_along, v_height = plate.cos * vx + plate.sin * vy, -plate.sin * vx + plate.cos * vy
    a_along, a_height = -problem.gravity * plate.sin, -problem.gravity * plate.cos
    time = 0.0
    for _ in range(8):
        before = time
        time = first_time_within(height, v_height, a_height, grown, time)
        if time == np.inf:
            return time
        time = first_time_within(along, v_along, a_along, plate.half_length + grown, time)
        if time == np.inf:
            return time
        time = first_time_within(z, vz, 0.0, plate.half_width + grown, time)
        if time == np.inf or time == before:
            return time
    return time


@kernel(inline=True)
def first_time_beyond(down, up, v, gravity):
    """First time at which a thrown particle is ``down`` below or ``up`` above its place, s.

    The distances are positive and ``v`` is its upward speed.
    """
    if v > 0.0:
        discriminant = v * v - 2.0 * gravity * up
        if discriminant >= 0.0:
            return 2.0 * up / (v + math.sqrt(discriminant))
    fall = math.sqrt(v * v + 2.0 * gravity * down)
    if v <= 0.0:
        return 2.0 * down / (fall - v)
    return (fall + v) / gravity


@kernel(inline=True)
def due_step(problem, now, time):
    """First lattice step at which an event at least ``time`` s ahead can have happened."""
    steps = time / problem.dt
    if steps > 1e15:
        return NEVER
    return now + np.int64(steps + ALMOST_ONE)


@kernel(inline=True)
def time_to_meet(reach2, p, u, distance2):
    """Time until two flying particles are within reach, s, or infinity.

    Both have the same acceleration, so the relative motion is a straight line: p + u t.
    """
    nearing = -dot(p, u)
    gap2 = max(distance2 - reach2, 0.0)
    discriminant = nearing * nearing - dot(u, u) * gap2
    # One branch, which is nearly always taken: most particles pass each other.
    if not (nearing > 0.0) & (discriminant >= 0.0):
        return np.inf
    return gap2 / (nearing + math.sqrt(discriminant))


@kernel(inline=True)
def time_to_reach(reach, p, u, distance2, growth, horizon):
    """Lower bound of the time until p + u t is within a sphere that grows, s, or infinity.

    The radius of the sphere around the origin is ``reach + growth t``, so the time is the first
    root of a quadratic equation. It may be infinite if it is beyond the horizon.
    """
    gap2 = max(distance2 - reach * reach, 0.0)
    nearing = reach * growth - dot(p, u)
    faster = growth * growth - dot(u, u)
    # Most particles are too far away, which takes no root: the difference of the squares of
    # distance and radius is gap2 - 2 nearing t - faster t^2.
    if gap2 > horizon * (2.0 * max(nearing, 0.0) + horizon * max(faster, 0.0)):
        return np.inf
    discriminant = nearing * nearing + faster * gap2
    if discriminant < 0.0:
        return np.inf
    speed = nearing + math.sqrt(discriminant)
    if speed <= 0.0:
        return np.inf
    return gap2 / speed


@kernel(inline=True)
def centre_distance2(a, b):
    apart = (a.x - b.x, a.y - b.y, a.z - b.z)
    return dot(apart, apart)
