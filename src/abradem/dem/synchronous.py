"""Conventional stepping: every live particle, every step. The reference of all others."""

from __future__ import annotations

import math

from abradem.dem.borrow import borrowed_state
from abradem.dem.cache import kernel
from abradem.dem.factory import release_due
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


@kernel
def advance(problem, schedule, state, last_step):
    """Advance to lattice step ``last_step``; return how that ended, at a whole step.

    Calling it in pieces gives the same bits as calling it once.
    """
    state = borrowed_state(state)
    tally = state.tally[0]
    while tally.step < last_step:
        if tally.gone > 16 + tally.live // 8:
            compact(state)
        if tally.step >= tally.next_release:
            before = tally.live
            outcome = release_due(problem, schedule, state)
            for new in range(before, tally.live):
                if not append_pairs(problem, state, new):
                    return STOP_CROWDED
            if outcome != DONE:
                return outcome
        outcome = step(problem, state)
        if outcome != DONE:
            return outcome
    return DONE


@kernel
def step(problem, state):
    """Advance all particles by one lattice step."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    facet_wear = state.facet_wear
    farthest2 = 0.0
    for i in range(tally.live):
        particle = particles[i]
        if particle.motion == GONE:
            continue
        farthest2 = max(farthest2, move(problem, particle, tally.step))
        height = height_over(problem.plate, particle.x, particle.y)
        if abs(height) < problem.radius or particle.plate_stiffness != 0.0:
            touch_plate(problem, particle, tally, facet_wear)
    tally.drift += math.sqrt(farthest2)
    if 2.0 * tally.drift > SKIN * problem.radius and not rebuild_pairs(problem, state):
        return STOP_CROWDED

    contact2 = 4.0 * problem.radius * problem.radius
    for p in range(tally.pairs):
        pair = pairs[p]
        a, b = particles[pair.i], particles[pair.j]
        dx, dy, dz = a.x - b.x, a.y - b.y, a.z - b.z
        distance2 = dx * dx + dy * dy + dz * dz
        if distance2 < contact2 and a.motion != GONE and b.motion != GONE:
            distance = math.sqrt(distance2)
            n = (dx / distance, dy / distance, dz / distance)
            touch_pair(problem, pair, a, b, distance, n, tally)
        else:
            pair.stiffness = 0.0

    tally.step += 1
    for i in range(tally.live):
        particle = particles[i]
        if particle.motion == TOUCHING or particle.motion == WAKING:
            finish(problem, particle, tally.step)
        if particle.motion != GONE:
            remove_if_fallen(problem, particle, tally)
    if tally.largest_overlap > OVERLAP_STOP:
        return STOP_OVERLAP
    return DONE
