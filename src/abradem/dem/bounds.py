"""Lower bounds of the time until particles can touch something: see `islands`.

All flights are parabolas with the same acceleration. The relative path of two flying particles
is therefore a straight line, and the time at which a particle meets the plate is the root of a
quadratic equation.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import FAR, NEVER
from abradem.dem.cache import kernel
from abradem.dem.vectors import dot

SAFETY = 1e-7
"""Relative enlargement of radii in predictions, far above the rounding error."""


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
def due_step(problem, now, time):
    """Lattice step before which an event ``time`` s ahead cannot happen, despite rounding."""
    steps = time / problem.dt
    if steps > 1e15:
        return NEVER
    return now + np.int64(steps)


@kernel(inline=True)
def _relative_flight(problem, flights, j, now, x, y, z, vx, vy, vz):
    """Position and velocity of a flying particle relative to flying particle j at ``now``."""
    time = problem.dt * (now - flights[6, j])
    fall = problem.gravity * time
    return (
        x - (flights[0, j] + flights[3, j] * time),
        y - (flights[1, j] + (flights[4, j] - 0.5 * fall) * time),
        z - (flights[2, j] + flights[5, j] * time),
        vx - flights[3, j],
        vy - (flights[4, j] - fall),
        vz - flights[5, j],
    )


@kernel(inline=True)
def miss_distances(problem, flights, out, live, now, x, y, z, vx, vy, vz):
    """Square of the smallest distance of a flying particle to each other flying particle, m2.

    Both have the same acceleration, so the relative motion is a straight line. The loop has no
    branches, so that the compiler can vectorise it.
    """
    for j in range(live):
        px, py, pz, ux, uy, uz = _relative_flight(problem, flights, j, now, x, y, z, vx, vy, vz)
        nearing = max(-(px * ux + py * uy + pz * uz), 0.0)
        speed2 = ux * ux + uy * uy + uz * uz + 1e-300
        away = FAR if nearing == 0.0 else 0.0
        out[j] = away + (px * px + py * py + pz * pz) - nearing * nearing / speed2


@kernel(inline=True)
def time_to_meet(problem, flights, j, now, x, y, z, vx, vy, vz):
    """Time until a flying particle can touch flying particle j, s, or infinity."""
    px, py, pz, ux, uy, uz = _relative_flight(problem, flights, j, now, x, y, z, vx, vy, vz)
    reach = 2.0 * problem.radius * (1.0 + SAFETY)
    gap2 = max(px * px + py * py + pz * pz - reach * reach, 0.0)
    nearing = -(px * ux + py * uy + pz * uz)
    discriminant = max(nearing * nearing - (ux * ux + uy * uy + uz * uz) * gap2, 0.0)
    if nearing <= 0.0:
        return np.inf
    return gap2 / (nearing + math.sqrt(discriminant))


@kernel(inline=True)
def distances(problem, flights, out, live, now, x, y, z):
    """Square of the distance of a point to every flying particle at step ``now``, m2."""
    for j in range(live):
        time = problem.dt * (now - flights[6, j])
        dx = x - (flights[0, j] + flights[3, j] * time)
        dy = y - (flights[1, j] + (flights[4, j] - 0.5 * problem.gravity * time) * time)
        dz = z - (flights[2, j] + flights[5, j] * time)
        out[j] = dx * dx + dy * dy + dz * dz


@kernel(inline=True)
def centre_distance2(a, b):
    apart = (a.x - b.x, a.y - b.y, a.z - b.z)
    return dot(apart, apart)


@kernel(inline=True)
def steps_to_close(problem, limit, distance2):
    """Number of steps in which two particles at the speed limit cannot close their gap."""
    gap = math.sqrt(distance2) - 2.0 * problem.radius * (1.0 + SAFETY)
    return np.int64(math.floor(gap / (2.0 * limit * problem.dt)))
