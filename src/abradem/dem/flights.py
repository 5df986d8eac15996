"""When a flying particle is due: see `islands`."""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import LANDED, NEVER, enqueue
from abradem.dem.bounds import (
    SAFETY,
    due_step,
    first_time_within,
    time_to_meet,
    time_to_plate,
    time_to_reach,
)
from abradem.dem.cache import kernel
from abradem.dem.cells import change_cell, list_neighbours, time_to_leave
from abradem.dem.mesh_flights import time_in_box, time_to_surface
from abradem.dem.plate import plate_distance
from abradem.dem.rows import note_in_row
from abradem.dem.state import FLYING, GONE, fall_speed, flying_place
from abradem.dem.vectors import dot

GLANCE = 64
"""Largest number of steps until a particle beside an edge of the plate is examined again."""


@kernel(inline=True)
def plan_plate(problem, state, agenda, i, now):
    """Find the first step at which flying particle i can touch a wall or be removed."""
    particle = state.particles[i]
    x, y, z = flying_place(problem, particle, now)
    vx, vy, vz = particle.vx, fall_speed(problem, particle, now), particle.vz
    time = _time_to_walls(problem, state.mesh, i, now, x, y, z, vx, vy, vz)
    agenda.plans[i].plate_due = max(due_step(problem, now, time), now + 1)


@kernel(inline=True)
def _time_to_walls(problem, mesh, i, now, x, y, z, vx, vy, vz):
    """Lower bound of the time until flying particle i touches a wall or is removed, s."""
    if mesh is not None:
        until = time_in_box(problem, problem.box, x, y, z, vx, vy, vz)
        return time_to_surface(problem, mesh, i, now, until, x, y, z, vx, vy, vz)
    drop = max(y - problem.removal_height, 0.0)
    until = first_time_within(drop, vy, -problem.gravity, 0.0, 0.0)
    plate = time_to_plate(problem, x, y, z, vx, vy, vz)
    if plate < GLANCE * problem.dt:
        # In or near the box around the plate, but perhaps outside its rounded edges.
        gap = plate_distance(problem.plate, x, y, z)[0] - problem.radius * (1.0 + SAFETY)
        fastest = math.sqrt(vx * vx + vy * vy + vz * vz) + problem.gravity * GLANCE * problem.dt
        plate = max(plate, min(gap / fastest, GLANCE * problem.dt))
    return min(until, plate)


@kernel(inline=True)
def plan_pairs(problem, state, agenda, i, now):
    """Find the first steps at which flying particle i can touch another and leaves its cell.

    If it only is in another cell, the particles that were near before are left out, since they
    have been examined. Awake particles note it in their rows. Return the number of flying
    particles that it touches at step ``now``; they are the first of the list of neighbours.
    """
    particles, plan = state.particles, agenda.plans[i]
    particle = particles[i]
    radius, gravity, dt = problem.radius, problem.gravity, problem.dt
    x, y, z = flying_place(problem, particle, now)
    vx, vy, vz = particle.vx, fall_speed(problem, particle, now), particle.vz
    old = plan.cell
    if plan.meet_due <= now:
        old, plan.meet_with = -1, -1
        plan.meet_due = plan.meet_next = NEVER
    # The two earliest meetings.
    first, second, partner = np.inf, np.inf, np.int64(-1)
    change_cell(agenda, i, x, y, z)
    leave = time_to_leave(agenda.clock[0], gravity, x, y, z, vx, vy, vz)
    reach = 2.0 * radius * (1.0 + SAFETY)
    contact2 = 4.0 * radius * radius
    touched = 0
    for m in range(list_neighbours(agenda, plan.cell, old)):
        j = np.int64(agenda.near[m])
        b = particles[j]
        if j == i or b.motion == GONE:
            continue
        if b.motion == FLYING:
            other = flying_place(problem, b, now)
            apart = (x - other[0], y - other[1], z - other[2])
            distance2 = dot(apart, apart)
            speed = (vx - b.vx, vy - fall_speed(problem, b, now), vz - b.vz)
            if distance2 < contact2:
                agenda.near[touched] = j
                touched += 1
            else:
                meet = time_to_meet(reach * reach, apart, speed, distance2)
                if meet < second:
                    if meet < first:
                        first, second, partner = meet, first, j
                    else:
                        second = meet
        elif agenda.plans[j].row_until >= now:
            apart = (x - b.x, y - b.y, z - b.z)
            distance2 = dot(apart, apart)
            course = agenda.plans[j]
            left = dt * (course.row_until - now)
            growth = course.stray + 0.5 * gravity * left
            speed = (vx - course.course_x, vy - course.course_y, vz - course.course_z)
            meet = time_to_reach(reach, apart, speed, distance2, growth, left)
            if meet < np.inf:
                note_in_row(agenda, j, i, due_step(problem, now, meet))
    if touched > 0:
        plan.meet_due, plan.meet_with = now + 1, -1
    elif first < np.inf:
        _note_meetings(problem, plan, now, first, second, partner)
    plan.leave_due = max(due_step(problem, now, leave), now + 1)
    return touched


@kernel(inline=True)
def _note_meetings(problem, plan, now, first, second, partner):
    """Note the two earliest meetings, in seconds from step ``now``, beside those known before."""
    due = max(due_step(problem, now, first), now + 1)
    if due < plan.meet_due:
        plan.meet_next = min(plan.meet_due, due_step(problem, now, second))
        plan.meet_due, plan.meet_with, plan.meet_found = due, partner, now
    else:
        plan.meet_next = min(plan.meet_next, due)


@kernel(inline=True)
def forget_meeting(state, plan, now):
    """Pass over a meeting that is due if the other particle has changed its flight since.

    Such a meeting is in the plan or the row of the other particle.
    """
    if plan.meet_due <= now and plan.meet_with >= 0:
        other = state.particles[plan.meet_with]
        if other.motion != FLYING or other.anchor_step > plan.meet_found:
            plan.meet_due, plan.meet_with = plan.meet_next, -1


@kernel
def plan_flights(problem, state, agenda, count, now):
    """Renew the bounds that are due of ``count`` flying particles, and enter these in the queue.

    They are those of the list `LANDED`.
    """
    for k in range(count):
        i = agenda.lists[LANDED, k]
        plan = agenda.plans[i]
        if plan.plate_due <= now:
            plan_plate(problem, state, agenda, i, now)
        if min(plan.meet_due, plan.leave_due) <= now:
            plan_pairs(problem, state, agenda, i, now)
        enqueue(agenda, i)
