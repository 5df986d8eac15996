"""Release of particles: from the factory patch at a given rate, or from a given schedule.

The k-th particle, counted from 0, is due at (k + 1/2) / rate. Random positions on the patch are
drawn until the particle overlaps nothing. A particle for which no free position is found in the
given number of attempts waits and is tried again, in the order of release, or it is left out. So
a crowded patch delivers less.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.cells import cell_of, enter_cell, list_neighbours
from abradem.dem.counter_random import uniform
from abradem.dem.mesh_contact import clear_walls, is_clear_of
from abradem.dem.plate import plate_distance
from abradem.dem.state import (
    DONE,
    FLYING,
    GONE,
    NEEDS_ROOM,
    NOT_YET,
    STOP_RELEASE,
    energy_of,
    flying_place,
    kinetic_energy_of,
)


@kernel
def release_step(problem, k):
    """Lattice step at which particle k of the factory is due."""
    step = (k + 0.5) / (problem.rate * problem.dt)
    # No simulation reaches this step. A larger value would overflow and be due immediately.
    if not step < 1e18:
        return np.int64(10**18)
    return np.int64(math.ceil(step))


@kernel(inline=True)
def _overlap(problem, x, y, z, other):
    dx, dy, dz = x - other[0], y - other[1], z - other[2]
    return dx * dx + dy * dy + dz * dz < 4.0 * problem.radius * problem.radius


@kernel(inline=True)
def _is_free(problem, particles, x, y, z, near, near_count):
    """Whether a new particle at (x, y, z) overlaps no near particle."""
    for k in range(near_count):
        other = particles[near[k]]
        if _overlap(problem, x, y, z, (other.x, other.y, other.z)):
            return False
    return True


@kernel(inline=True)
def _is_off_the_walls(problem, state, mesh, x, y, z):
    """Whether a new particle at (x, y, z) overlaps neither the plate nor the surface."""
    if mesh is None:
        return plate_distance(problem.plate, x, y, z)[0] >= problem.radius
    return is_clear_of(problem, mesh, x, y, z, state.tally[0].step)


@kernel(inline=True)
def _is_free_in_cells(problem, state, agenda, x, y, z):
    """Whether a new particle at (x, y, z) overlaps no particle in the cells.

    The positions of flying particles in the state may be those of an earlier step.
    """
    cell = cell_of(agenda, x, y, z)
    for m in range(list_neighbours(agenda, cell, -1)):
        other = state.particles[agenda.near[m]]
        place = (other.x, other.y, other.z)
        if other.motion == FLYING:
            place = flying_place(problem, other, state.tally[0].step)
        if _overlap(problem, x, y, z, place):
            return False
    return True


@kernel
def _place(problem, state, agenda, place, velocity, spin):
    """Add a particle with the given position, velocity and spin at the current step."""
    if agenda is not None:
        cell = cell_of(agenda, place[0], place[1], place[2])
        enter_cell(agenda, state.tally[0].live, cell)
    tally = state.tally[0]
    new = tally.live
    particle = state.particles[new]
    particle.motion = FLYING
    particle.anchor_step = tally.step
    particle.identity = tally.placed
    particle.first_contact = NOT_YET
    particle.x, particle.y, particle.z = place
    particle.anchor_x, particle.anchor_y, particle.anchor_z = place
    particle.vx, particle.vy, particle.vz = velocity
    particle.wx, particle.wy, particle.wz = spin
    particle.plate_stiffness = 0.0
    particle.plate_sx = particle.plate_sy = particle.plate_sz = 0.0
    particle.plate_fn = 0.0
    particle.plate_tx = particle.plate_ty = particle.plate_tz = 0.0
    particle.plate_energy = 0.0
    particle.plate_slip = 0.0
    clear_walls(state.mesh, new)
    tally.live = new + 1
    tally.placed += 1
    tally.draws = 0
    tally.energy_in += energy_of(problem, particle, tally.step)
    tally.kinetic_in += kinetic_energy_of(problem, particle, tally.step)


@kernel
def release_due(problem, schedule, state, agenda):
    """Release every particle that is due at the current step; return the outcome.

    With an agenda, particles in the way are found in its cells, and new ones are entered there.
    If it is None, all particles are examined. Both give the same.
    """
    if problem.scheduled:
        return _release_scheduled(problem, schedule, state, agenda)
    return _release_from_patch(problem, state, agenda)


@kernel
def _release_from_patch(problem, state, agenda):
    tally, particles = state.tally[0], state.particles
    # Only particles near the patch can overlap a new one.
    far = math.hypot(problem.patch_half_length, problem.patch_half_width) + 2.0 * problem.radius
    near_count = 0
    if agenda is None:
        near = np.empty(particles.size, np.int64)
        for j in range(tally.live):
            other = particles[j]
            dx, dz = other.x - problem.patch_x, other.z - problem.patch_z
            dy = other.y - problem.patch_height
            if other.motion != GONE and dx**2 + dy**2 + dz**2 < far * far:
                near[near_count] = j
                near_count += 1

    while release_step(problem, tally.placed + tally.skipped) <= tally.step:
        if tally.live == particles.size:
            return NEEDS_ROOM
        due = tally.placed + tally.skipped
        placed = False
        for _ in range(problem.attempts):
            u = uniform(problem.seed, due, tally.draws)
            v = uniform(problem.seed, due, tally.draws + 1)
            tally.draws += 2
            along = problem.patch_half_length * (2.0 * u - 1.0)
            across = problem.patch_half_width * (2.0 * v - 1.0)
            way, side = problem.patch_along, problem.patch_across
            x = problem.patch_x + along * way[0] + across * side[0]
            y = problem.patch_height + along * way[1] + across * side[1]
            z = problem.patch_z + along * way[2] + across * side[2]
            if agenda is None:
                free = _is_free(problem, particles, x, y, z, near, near_count)
            else:
                free = _is_free_in_cells(problem, state, agenda, x, y, z)
            if free and _is_off_the_walls(problem, state, state.mesh, x, y, z):
                if agenda is None:
                    near[near_count] = tally.live
                    near_count += 1
                velocity = problem.release_velocity
                _place(problem, state, agenda, (x, y, z), velocity, (0.0, 0.0, 0.0))
                placed = True
                break
        if not placed and problem.skips:
            tally.skipped += 1
            tally.draws = 0
        elif not placed:
            tally.next_release = tally.step + problem.retry_steps
            return DONE
    tally.next_release = release_step(problem, tally.placed + tally.skipped)
    return DONE


@kernel
def _release_scheduled(problem, schedule, state, agenda):
    tally, particles = state.tally[0], state.particles
    total = schedule.step.size
    while tally.placed < total and schedule.step[tally.placed] <= tally.step:
        if tally.live == particles.size:
            return NEEDS_ROOM
        at = schedule.position[tally.placed]
        place = (at[0], at[1], at[2])
        if agenda is None:
            near = np.empty(tally.live, np.int64)
            near_count = 0
            for j in range(tally.live):
                if particles[j].motion != GONE:
                    near[near_count] = j
                    near_count += 1
            free = _is_free(problem, particles, *place, near, near_count)
        else:
            free = _is_free_in_cells(problem, state, agenda, *place)
        if not (free and _is_off_the_walls(problem, state, state.mesh, *place)):
            return STOP_RELEASE
        v, w = schedule.velocity[tally.placed], schedule.spin[tally.placed]
        _place(problem, state, agenda, place, (v[0], v[1], v[2]), (w[0], w[1], w[2]))
    if tally.placed == total:
        tally.next_release = np.iinfo(np.int64).max
    else:
        tally.next_release = schedule.step[tally.placed]
    return DONE
