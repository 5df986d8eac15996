"""Rows: the partners that an awake particle can touch in the next few hundred steps.

An awake particle has a *pace*, a speed that it is assumed not to exceed, which is checked in every
step. A pair in which one is awake and one flies, or both are awake, is in the row of one of them
until it can touch at the earliest: paces and flights bound how fast its gap can close. It is in
the row that was made last, and older rows may be late for it. See `islands`.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import NEIGHBOURS, SLOTS
from abradem.dem.bounds import SAFETY, centre_distance2, due_step, time_to_reach
from abradem.dem.cache import kernel
from abradem.dem.cells import change_cell, distance_to_leave, list_neighbours
from abradem.dem.state import FLYING, GONE, fall_speed, flying_place
from abradem.dem.vectors import dot

LONGEST_ROW = 512
"""Largest number of steps for which a row is made."""

WAY = 0.3
"""Distance, in radii, that a particle covers at its pace while its row is valid."""

HASTE = 1.25
"""Pace of a new row, in terms of the speed of the particle."""

REST = 0.01
"""Distance, in radii, that a particle at rest may cover while its row is valid."""


@kernel(inline=True)
def steps_apart(problem, agenda, a, pace, b, j, distance2, now, horizon):
    """First step at which awake particle a can touch particle j = b, if within the horizon.

    ``distance2`` is the square of their distance at step ``now``, m2; ``horizon`` is in s.
    """
    reach = 2.0 * problem.radius * (1.0 + SAFETY)
    if b.motion == FLYING:
        x, y, z = flying_place(problem, b, now)
        apart = (x - a.x, y - a.y, z - a.z)
        speed = (b.vx, fall_speed(problem, b, now), b.vz)
        # Within the horizon, gravity bends the path by less than g t T / 2.
        bent = pace + 0.5 * problem.gravity * horizon
        return due_step(problem, now, time_to_reach(reach, apart, speed, distance2, bent))
    gap = max(math.sqrt(distance2) - reach, 0.0)
    return due_step(problem, now, gap / (pace + agenda.plans[j].pace))


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
    speed2 = max(
        dot((a.vx, a.vy, a.vz), (a.vx, a.vy, a.vz)),
        dot((a.half_vx, a.half_vy, a.half_vz), (a.half_vx, a.half_vy, a.half_vz)),
    )
    rest = REST * radius / (LONGEST_ROW * dt)
    pace = max(HASTE * math.sqrt(speed2), plan.impact) + rest
    plan.pace = pace
    plan.stride2 = (pace * dt) ** 2
    plan.impact = 0.0
    change_cell(problem, agenda, i, a.x, a.y, a.z)
    leave = distance_to_leave(problem, agenda.clock[0].tall, a.x, a.y, a.z)
    way = min(WAY * radius, leave)
    steps = np.int64(min(way / (pace * dt), float(LONGEST_ROW)))
    steps = max(steps, 1)
    contact2 = 4.0 * radius * radius
    count = list_neighbours(agenda, plan.cell, -1)
    while True:
        until, first, size = now + steps, now + steps + 1, 0
        for m in range(count):
            j = agenda.lists[NEIGHBOURS, m]
            b = particles[j]
            if j == i or b.motion == GONE:
                continue
            distance2 = distance2_to(problem, a, b, now)
            # A flying particle is in no open contact.
            check = now if b.motion == FLYING else touching
            if distance2 >= contact2:
                check = steps_apart(problem, agenda, a, pace, b, j, distance2, now, steps * dt)
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
