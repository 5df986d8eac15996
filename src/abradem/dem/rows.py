"""Rows: the partners that an awake particle can touch in the next few hundred steps.

An awake particle has a *course*, a velocity from which it is assumed to stray by less than a given
speed, which is checked in every step. A pair in which one is awake and one flies, or both are
awake, is in the row of one of them until it can touch at the earliest: courses and flights bound
how fast its gap can close. It is in the row that was made last, and older rows may be late for it.
See `islands`.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import NEVER, SLOTS
from abradem.dem.bounds import SAFETY, centre_distance2, due_step, time_to_reach
from abradem.dem.cache import kernel
from abradem.dem.cells import change_cell, distance_to_leave, list_neighbours
from abradem.dem.state import FLYING, GONE, fall_speed, flying_place
from abradem.dem.vectors import dot, plus, scaled

LONGEST_ROW = 512
"""Largest number of steps for which a row is made."""

SMALLEST = 1e-30
"""Added to a length that is divided by, m/s."""

REST = 0.01
"""Distance, in radii, by which a particle in steady motion may stray while its row is valid."""

WANDER = 0.05
"""Speed by which a particle in a new row may stray in any case, in terms of its speed."""

BLOW = 0.375
"""Change of velocity that is half over, of a contact that begins: in terms of the relative speed of
two particles; twice that is it of the speed towards a wall."""

AHEAD = 20.0
"""Number of half steps for which the present acceleration of a particle may last."""

SPREAD = 1.25
"""Speed by which a velocity that changes may stray from its mean, in terms of half its change."""


@kernel(inline=True)
def steps_apart(problem, agenda, a, plan, b, j, distance2, now, horizon):
    """First step at which awake particle a can touch particle j = b, if within the horizon.

    ``plan`` is that of a. ``distance2`` is the square of their distance at step ``now``, m2;
    ``horizon`` is in s. Beyond it, the step may be `NEVER`.
    """
    reach = 2.0 * problem.radius * (1.0 + SAFETY)
    if b.motion == FLYING:
        x, y, z = flying_place(problem, b, now)
        vx, vy, vz = b.vx, fall_speed(problem, b, now), b.vz
        # Within the horizon, gravity bends the path by less than g t T / 2.
        stray = 0.5 * problem.gravity * horizon
    else:
        x, y, z = b.x, b.y, b.z
        other = agenda.plans[j]
        vx, vy, vz = other.course_x, other.course_y, other.course_z
        stray = other.stray
    apart = (x - a.x, y - a.y, z - a.z)
    speed = (vx - plan.course_x, vy - plan.course_y, vz - plan.course_z)
    time = time_to_reach(reach, apart, speed, distance2, plan.stray + stray, horizon)
    return due_step(problem, now, time) if time < np.inf else NEVER


@kernel(inline=True)
def distance2_to(problem, a, b, now):
    """Square of the distance of an awake particle to another at step ``now``, m2.

    It has the same bits as that of the positions in the state.
    """
    if b.motion == FLYING:
        x, y, z = flying_place(problem, b, now)
        apart = (a.x - x, a.y - y, a.z - z)
        return dot(apart, apart)
    return centre_distance2(a, b)


@kernel(inline=True)
def _set_course(problem, a, plan, moved):
    """Set the course of awake particle a; return the largest speed that is then assumed, m/s.

    ``moved`` tells whether it has begun a step. Any course is valid, since it is checked in every
    step whether the particle strays from it. A good one is the mean of the velocities to come.
    """
    change = (a.vx - a.half_vx, a.vy - a.half_vy, a.vz - a.half_vz)
    latest = (a.vx, a.vy, a.vz)
    if moved:
        latest = (a.half_vx, a.half_vy, a.half_vz)
        change = scaled(change, -1.0)
    # Change of velocity in half a step, and its direction: that of the forces.
    length = math.sqrt(dot(change, change)) + SMALLEST
    ahead = AHEAD * length
    if plan.impact > 0.0:
        ahead = max(ahead, BLOW * plan.impact)
    elif plan.row_until < 0:
        ahead = max(ahead, -2.0 * BLOW * dot(latest, change) / length)
    course = plus(latest, ahead / length, change)
    speed = math.sqrt(dot(latest, latest))
    rest = REST * problem.radius / (LONGEST_ROW * problem.dt)
    plan.course_x, plan.course_y, plan.course_z = course
    plan.stray = SPREAD * ahead + WANDER * speed + rest
    plan.stray2 = (plan.stray * problem.dt) ** 2
    plan.impact = 0.0
    return math.sqrt(dot(course, course)) + plan.stray


@kernel
def make_rows(problem, state, agenda, which, count, now, touching):
    """Make the rows of ``count`` awake particles of a list; False if one is full."""
    for k in range(count):
        if not _make_row(problem, state, agenda, agenda.lists[which, k], now, touching):
            return False
    return True


@kernel(inline=True)
def _make_row(problem, state, agenda, i, now, touching):
    """Make the row of awake particle i from all positions at step ``now``; False if it is full.

    ``touching`` is the next check of the particles that it touches: ``now`` if contacts of this
    step have not been looked for yet, otherwise `NEVER`.
    """
    particles, plan, row = state.particles, agenda.plans[i], agenda.rows[i]
    a = particles[i]
    radius, dt = problem.radius, problem.dt
    fastest = _set_course(problem, a, plan, touching == now)
    change_cell(agenda, i, a.x, a.y, a.z)
    leave = distance_to_leave(agenda.clock[0], a.x, a.y, a.z)
    steps = max(np.int64(min(leave / (fastest * dt), float(LONGEST_ROW))), 1)
    contact2 = 4.0 * radius * radius
    count = list_neighbours(agenda, plan.cell, -1)
    while True:
        until, first, size = now + steps, now + steps + 1, 0
        for m in range(count):
            j = np.int64(agenda.near[m])
            b = particles[j]
            if j == i or b.motion == GONE:
                continue
            distance2 = distance2_to(problem, a, b, now)
            # A flying particle is in no open contact.
            check = now if b.motion == FLYING else touching
            if distance2 >= contact2:
                check = steps_apart(problem, agenda, a, plan, b, j, distance2, now, steps * dt)
                if check > until:
                    continue
            if size < SLOTS:
                row[size].j = j
                row[size].next_check = check
            size += 1
            first = min(first, check)
        if size <= SLOTS:
            break
        if steps == 1:
            return False
        steps //= 2  # type: ignore[operator]  # a number to numba
    plan.row_size = size
    plan.row_next = first
    plan.row_until = until
    return True


@kernel(inline=True)
def note_in_row(agenda, k, j, check):
    """Have awake particle k check its distance to particle j at a step."""
    plan, row = agenda.plans[k], agenda.rows[k]
    if check > plan.row_until:
        return
    m = 0
    while m < plan.row_size and row[m].j != j:
        m += 1
    if m == SLOTS:
        # There is no room: the row is made again before the two can touch.
        plan.row_until = check - 1
    else:
        row[m].j = j
        row[m].next_check = check
        plan.row_size = max(plan.row_size, m + 1)
    plan.row_next = min(plan.row_next, check)
