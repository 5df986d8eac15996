"""Conventional stepping of every particle in every step; the reference for other steppings."""

from __future__ import annotations

import math

from abradem.dem.borrow import borrowed_state
from abradem.dem.cache import kernel
from abradem.dem.factory import release_due
from abradem.dem.mesh_contact import touch_surface
from abradem.dem.motion import finish, move, remove_if_fallen, touch_pair, touch_plate
from abradem.dem.neighbours import append_pairs, compact, rebuild_pairs
from abradem.dem.plate import height_over
from abradem.dem.state import (
    DONE,
    GONE,
    OVERLAP_STOP,
    SKIN,
    STOP_CROWDED,
    STOP_OVERLAP,
    TOUCHING,
    WAKING,
)
from abradem.dem.vectors import dot, scaled

LONGEST_PIECE = 1024
"""Largest number of steps before the gaps of removed particles are closed."""


@kernel
def advance(problem, schedule, state, last_step):
    """Advance to lattice step ``last_step``; return the outcome, always after a whole step.

    Several calls give bitwise the same result as a single call, except for the positions of the
    gaps of removed particles in the arrays.
    """
    state = borrowed_state(state)
    tally = state.tally[0]
    while tally.step < last_step:
        outcome = prepare(problem, schedule, state)
        if outcome == DONE:
            until = min(last_step, tally.next_release, tally.step + LONGEST_PIECE)
            outcome = _steps(problem, state, until)
        if outcome != DONE:
            return outcome
    return DONE


@kernel
def prepare(problem, schedule, state):
    """Close gaps and release the particles that are due before steps; return the outcome."""
    tally = state.tally[0]
    if tally.gone > 16 + tally.live // 8:
        compact(state)
    if tally.step < tally.next_release:
        return DONE
    before = tally.live
    outcome = release_due(problem, schedule, state, None)
    for new in range(before, tally.live):
        if not append_pairs(problem, state, new):
            return STOP_CROWDED
    return outcome


@kernel
def _steps(problem, state, last_step):
    """Advance all particles to ``last_step``, at least by one lattice step.

    One loop over the particles finishes a step and begins the next. Contacts with the plate have
    a separate loop, because the processor overlaps the iterations of short loops better.
    """
    state = borrowed_state(state)
    tally, particles = state.tally[0], state.particles
    outcome = DONE
    finishing, moving = False, True
    while True:
        # Start values of 0, so that they are finite if nothing moves.
        least_x = least_y = least_z = most_x = most_y = most_z = 0.0
        for i in range(tally.live):
            particle = particles[i]
            if particle.motion == GONE:
                continue
            if finishing:
                if particle.motion == TOUCHING or particle.motion == WAKING:
                    finish(problem, particle, tally.step)
                remove_if_fallen(problem, particle, tally)
            if not moving or particle.motion == GONE:
                continue
            dx, dy, dz = move(problem, particle, tally.step)
            least_x, most_x = min(least_x, dx), max(most_x, dx)
            least_y, most_y = min(least_y, dy), max(most_y, dy)
            least_z, most_z = min(least_z, dz), max(most_z, dz)
        if not moving:
            return outcome
        _touch_walls(problem, state, state.mesh)
        # Two particles approach at most by the difference of their displacements, so a jet that
        # falls on particles at rest counts once, not twice.
        spread2 = (most_x - least_x) ** 2 + (most_y - least_y) ** 2 + (most_z - least_z) ** 2
        tally.drift += math.sqrt(spread2)
        if tally.drift > SKIN * problem.radius and not rebuild_pairs(problem, state):
            return STOP_CROWDED
        _touch_pairs(problem, state)
        tally.step += 1
        if tally.largest_overlap / problem.radius > OVERLAP_STOP:
            outcome = STOP_OVERLAP
        finishing, moving = True, tally.step < last_step and outcome == DONE


@kernel(inline=True)
def _touch_walls(problem, state, mesh):
    """Contacts with the plate or, if there is one, with the surface."""
    tally, particles, facet_wear = state.tally[0], state.particles, state.facet_wear
    if mesh is not None:
        touch_surface(
            problem, particles, state.tally, facet_wear, mesh, tally.step + 1, None, tally.live
        )
        return
    for i in range(tally.live):
        particle = particles[i]
        height = height_over(problem.plate, particle.x, particle.y)
        near = abs(height) < problem.radius or particle.plate_stiffness != 0.0
        if near and particle.motion != GONE:
            touch_plate(problem, particle, tally, facet_wear)


@kernel(inline=True)
def _touch_pairs(problem, state):
    """Contacts between the particles of the pair list."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    contact2 = 4.0 * problem.radius * problem.radius
    for p in range(tally.pairs):
        pair = pairs[p]
        a, b = particles[pair.i], particles[pair.j]
        apart = (a.x - b.x, a.y - b.y, a.z - b.z)
        distance2 = dot(apart, apart)
        if distance2 < contact2 and a.motion != GONE and b.motion != GONE:
            distance = math.sqrt(distance2)
            n = scaled(apart, 1.0 / distance)
            touch_pair(problem, pair, a, b, distance, n, tally)
        else:
            pair.stiffness = 0.0
