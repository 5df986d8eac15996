"""Fast stepping: only particles that can touch something are stepped.

Between contacts a particle moves on an exact parabola (`state.flight`), so it need not be stepped
until it can touch something. A particle is *asleep* while a bound excludes a contact, and *awake*
otherwise. Awake particles form islands of contact. They take the same steps as in `synchronous`,
in the same order. If no particle is awake, the time jumps to the next bound.

All bounds are lower bounds of the lattice step at which a contact can begin:

- sleeping particle and plate or removal level: roots of the parabola;
- two sleeping particles: gravity cancels, the relative motion is a straight line, and the closest
  approach is exact;
- awake particle and any other: a row of near partners, each with the step before which the gap
  cannot close at the speed limit. The limit is valid for all flights (energy down to the removal
  level) and is checked for every awake particle in every step. If a particle exceeds it, the limit
  is raised and all rows are built again before the contacts of the step are searched.

If hardly any particle sleeps because many are in contact, the bounds cost more than they save.
`synchronous` then does the stepping until fewer particles touch.

A bound that is too early costs a little time but never misses a contact. Whether two particles
touch is decided by the same expression as in `synchronous`. Both give bitwise equal results.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem import synchronous
from abradem.dem.agenda import FAR, NEVER, SLOTS, borrowed_agenda, record_flight
from abradem.dem.borrow import borrowed_state
from abradem.dem.bounds import (
    SAFETY,
    centre_distance2,
    due_step,
    first_time_within,
    miss_distances,
    steps_to_close,
    time_to_meet,
    time_to_plate,
)
from abradem.dem.cache import kernel
from abradem.dem.factory import release_due
from abradem.dem.motion import finish, fly_to, move, remove_if_fallen, touch_pair, touch_plate
from abradem.dem.neighbours import compact
from abradem.dem.plate import height_over
from abradem.dem.rows import make_row, raise_limit
from abradem.dem.state import (
    DONE,
    FLYING,
    GONE,
    OVERLAP_STOP,
    STOP_CROWDED,
    STOP_OVERLAP,
    TOUCHING,
    WAKING,
    fall,
    flight,
)
from abradem.dem.vectors import dot, scaled

NAP = 4
"""A particle that could sleep for at most this number of steps stays awake."""

NAP_PER_PARTICLE = 0.15
"""Increase of `NAP` for each particle present. Before a particle sleeps, all others are checked,
and the check of one costs as much as this number of steps of an awake particle."""

SMALLEST_CROWD = 256
CROWDED, THINNED = 0.18, 0.10
"""In a crowd of more than `SMALLEST_CROWD` particles `synchronous` takes over if more than the
share `CROWDED` is awake, and hands back if at most the share `THINNED` touches something."""

CROWD_STEPS = 5000
"""Number of steps after which `synchronous` may hand back."""


@kernel
def advance(problem, schedule, state, agenda, last_step):
    """Advance to lattice step ``last_step``; return the outcome, always after a whole step."""
    state, agenda = borrowed_state(state), borrowed_agenda(agenda)
    tally, clock = state.tally[0], agenda.clock[0]
    outcome = DONE
    while tally.step < last_step and outcome == DONE:
        if clock.crowded != 0:
            until = min(last_step, tally.step + CROWD_STEPS)
            outcome = synchronous.advance(problem, schedule, state, until)
            if outcome == DONE and not _resume_if_thinned(problem, state, agenda):
                outcome = STOP_CROWDED
            continue
        if tally.gone > 16 + tally.live // 8:
            _compact(state, agenda)
        if tally.step >= tally.next_release:
            _refresh(problem, state)
            before = tally.live
            outcome = release_due(problem, schedule, state)
            if not _add_released(problem, state, agenda, before):
                outcome = STOP_CROWDED
            if outcome != DONE:
                break
        if clock.next_due <= tally.step + 1 and not _wake_due(problem, state, agenda):
            outcome = STOP_CROWDED
            break
        if clock.awake == 0:
            tally.step = min(clock.next_due - 1, tally.next_release, last_step)
            continue
        outcome = _step(problem, state, agenda)
        if clock.awake > NAP + CROWDED * tally.live and tally.live > SMALLEST_CROWD:
            _write_back(problem, state, agenda)
            # `synchronous` then builds its pair list in the first step.
            tally.drift = np.inf
            clock.crowded = 1
    if clock.crowded == 0:
        _write_back(problem, state, agenda)
    return outcome


@kernel(inline=True)
def _step(problem, state, agenda):
    """Advance the awake particles by one lattice step, in the same order as `synchronous`."""
    tally, particles, clock = state.tally[0], state.particles, agenda.clock[0]
    awake, rows, facet_wear = agenda.awake, agenda.rows, state.facet_wear
    now = tally.step + 1
    for k in range(clock.awake):
        if agenda.row_until[awake[k]] < now and not make_row(
            problem, state, agenda, awake[k], tally.step
        ):
            return STOP_CROWDED

    farthest2 = 0.0
    for k in range(clock.awake):
        particle = particles[awake[k]]
        dx, dy, dz = move(problem, particle, tally.step)
        farthest2 = max(farthest2, dx * dx + dy * dy + dz * dz)
        height = height_over(problem.plate, particle.x, particle.y)
        if abs(height) < problem.radius or particle.plate_stiffness != 0.0:
            touch_plate(problem, particle, tally, facet_wear)
    if farthest2 > (clock.limit * problem.dt) ** 2 and not raise_limit(
        problem, state, agenda, math.sqrt(farthest2) / problem.dt, now
    ):
        return STOP_CROWDED

    # First wake all sleeping particles that are touched, so that contacts are in order below.
    contact2 = 4.0 * problem.radius * problem.radius
    k = 0
    while k < clock.awake:
        i = awake[k]
        k += 1
        if agenda.row_next[i] > now:
            continue
        for m in range(agenda.row_size[i]):
            near = rows[i, m]
            if near.next_check > now or not agenda.asleep[near.j]:
                continue
            other = particles[near.j]
            move(problem, other, tally.step)
            if centre_distance2(particles[i], other) < contact2:
                if not _wake(problem, state, agenda, np.int64(near.j), now):
                    return STOP_CROWDED
                if near.j < i:
                    k += 1

    for k in range(clock.awake):
        i = awake[k]
        if agenda.row_next[i] <= now:
            _touch_partners(problem, state, agenda, i, now)

    tally.step = now
    kept = 0
    for k in range(clock.awake):
        i = awake[k]
        particle = particles[i]
        landed = particle.motion == TOUCHING or particle.motion == WAKING
        if landed:
            finish(problem, particle, now)
        remove_if_fallen(problem, particle, tally)
        if particle.motion == GONE:
            agenda.flights[0, i] = FAR
            continue
        awake[kept] = i
        kept += 1
        if particle.motion == TOUCHING:
            agenda.flights[0, i] = FAR
        elif landed or agenda.due[i] <= now:
            if landed:
                record_flight(agenda, particle, i)
            if _may_sleep(problem, state, agenda, i, now):
                agenda.asleep[i] = True
                kept -= 1
    clock.awake = kept
    if tally.largest_overlap / problem.radius > OVERLAP_STOP:
        return STOP_OVERLAP
    # A flight faster than the limit, found just above, can cause contacts from the next step on.
    if clock.limit < 0.0 and not raise_limit(problem, state, agenda, -clock.limit, now):
        return STOP_CROWDED
    return DONE


@kernel(inline=True)
def _touch_partners(problem, state, agenda, i, now):
    """Contacts of awake particle i with partners of higher index; next checks of all partners."""
    particles, tally = state.particles, state.tally[0]
    limit = agenda.clock[0].limit
    contact2 = 4.0 * problem.radius * problem.radius
    a = particles[i]
    first = NEVER
    for m in range(agenda.row_size[i]):
        near = agenda.rows[i, m]
        if near.next_check <= now:
            b = particles[near.j]
            if b.motion == GONE:
                near.stiffness = 0.0
                near.next_check = NEVER
                continue
            apart = (a.x - b.x, a.y - b.y, a.z - b.z)
            distance2 = dot(apart, apart)
            if distance2 < contact2:
                if near.j > i:
                    distance = math.sqrt(distance2)
                    n = scaled(apart, 1.0 / distance)
                    touch_pair(problem, near, a, b, distance, n, tally)
                near.next_check = now + 1
            else:
                near.stiffness = 0.0
                steps = steps_to_close(problem, limit, distance2)
                near.next_check = now + 1 + max(steps, 0)
        first = min(first, near.next_check)
    agenda.row_next[i] = first


@kernel
def _may_sleep(problem, state, agenda, i, now):
    """Set the due step of flying particle i and return whether it can sleep long enough.

    Unless the plate or the removal level is too close, the due steps of all particles that it can
    touch are brought forward. Otherwise it stays awake and finds sleeping partners by its row.
    """
    clock, flights, due = agenda.clock[0], agenda.flights, agenda.due
    time = problem.dt * (now - flights[6, i])
    vx, vz = flights[3, i], flights[5, i]
    vy = flights[4, i] - problem.gravity * time
    x = flight(flights[0, i], vx, time)
    y = fall(flights[1, i], flights[4, i], problem.gravity, time)
    z = flight(flights[2, i], vz, time)

    drop = max(y - problem.removal_height, 0.0)
    fastest = math.sqrt(vx * vx + vy * vy + vz * vz + 2.0 * problem.gravity * drop)
    if fastest * (1.0 + SAFETY) > abs(clock.limit):
        clock.limit = -fastest

    until = first_time_within(drop, vy, -problem.gravity, 0.0, 0.0)
    until = min(until, time_to_plate(problem, x, y, z, vx, vy, vz))
    mine = due_step(problem, now, until)
    due[i] = mine
    nap = NAP + np.int64(NAP_PER_PARTICLE * state.tally[0].live)
    if mine <= now + nap:
        return False

    miss_distances(problem, flights, agenda.scratch, state.tally[0].live, now, x, y, z, vx, vy, vz)
    reach2 = (2.0 * problem.radius * (1.0 + SAFETY)) ** 2
    for j in range(state.tally[0].live):
        if agenda.scratch[j] >= reach2 or j == i or flights[0, j] == FAR:
            continue
        meet = due_step(problem, now, time_to_meet(problem, flights, j, now, x, y, z, vx, vy, vz))
        mine = min(mine, meet)
        if meet < due[j]:
            due[j] = meet
            if agenda.asleep[j]:
                clock.next_due = min(clock.next_due, meet)
    due[i] = mine
    if mine <= now + nap:
        return False
    clock.next_due = min(clock.next_due, mine)
    return True


@kernel
def _wake(problem, state, agenda, i, now):
    """Wake particle i, whose position is that of step ``now``; False if its row is full."""
    clock, awake = agenda.clock[0], agenda.awake
    agenda.asleep[i] = False
    agenda.row_size[i] = 0
    k = clock.awake
    while k > 0 and awake[k - 1] > i:
        awake[k] = awake[k - 1]
        k -= 1
    awake[k] = i
    clock.awake += 1
    return make_row(problem, state, agenda, i, now)


@kernel
def _wake_due(problem, state, agenda):
    """Wake all particles that can touch something in the next step; False if a row is full."""
    tally, clock = state.tally[0], agenda.clock[0]
    clock.next_due = NEVER
    for i in range(tally.live):
        if not agenda.asleep[i]:
            continue
        if agenda.due[i] <= tally.step + 1:
            fly_to(problem, state.particles[i], tally.step)
            if not _wake(problem, state, agenda, i, tally.step):
                return False
        else:
            clock.next_due = min(clock.next_due, agenda.due[i])
    return True


@kernel
def _add_released(problem, state, agenda, first):
    """Add the particles just released, from index ``first`` on; False if a row is full."""
    tally, clock = state.tally[0], agenda.clock[0]
    for new in range(first, tally.live):
        record_flight(agenda, state.particles[new], new)
        agenda.asleep[new] = False
        agenda.due[new] = NEVER
        agenda.row_size[new] = 0
    # Existing rows do not contain them yet.
    for k in range(clock.awake):
        for new in range(first, tally.live):
            if not _add_to_row(problem, state, agenda, agenda.awake[k], new):
                return False
    return _sleep_or_wake(problem, state, agenda, first)


@kernel
def _sleep_or_wake(problem, state, agenda, first):
    """Let flying particles from index ``first`` on sleep, or wake them; False if a row is full."""
    tally, clock = state.tally[0], agenda.clock[0]
    for i in range(first, tally.live):
        if state.particles[i].motion != FLYING:
            continue
        if _may_sleep(problem, state, agenda, i, tally.step):
            agenda.asleep[i] = True
        elif not _wake(problem, state, agenda, i, tally.step):
            return False
    if clock.limit < 0.0:
        return raise_limit(problem, state, agenda, -clock.limit, tally.step)
    return True


@kernel
def _add_to_row(problem, state, agenda, i, new):
    """Add a new particle, the last one, to the row of i if it is near; False if the row is full."""
    rows, size, limit = agenda.rows, agenda.row_size[i], agenda.clock[0].limit
    now = state.tally[0].step
    left = agenda.row_until[i] - now
    reach = 2.0 * problem.radius * (1.0 + SAFETY) + 2.0 * limit * problem.dt * left
    distance2 = centre_distance2(state.particles[i], state.particles[new])
    if distance2 >= reach * reach or (size > 0 and rows[i, size - 1].j >= new):
        return True
    if size == SLOTS:
        # A new row is valid for fewer steps and contains all partners.
        return make_row(problem, state, agenda, i, now)
    near = rows[i, size]
    near.j = new
    near.stiffness = 0.0
    near.next_check = now + 1 + steps_to_close(problem, limit, distance2)
    agenda.row_next[i] = min(agenda.row_next[i], near.next_check)
    agenda.row_size[i] = size + 1
    return True


@kernel
def _refresh(problem, state):
    """Set the positions of all flying particles to those of the current step."""
    for i in range(state.tally[0].live):
        particle = state.particles[i]
        if particle.motion == FLYING:
            fly_to(problem, particle, state.tally[0].step)


@kernel(inline=True)
def _copy_memory(source, target):
    """Copy the memory of an open contact between a row and the pair list."""
    target.stiffness = source.stiffness
    target.sx, target.sy, target.sz = source.sx, source.sy, source.sz
    target.fn, target.tx, target.ty, target.tz = source.fn, source.tx, source.ty, source.tz


@kernel
def _write_back(problem, state, agenda):
    """Write positions and open pair contacts to the state, as `synchronous` does."""
    tally, clock, pairs = state.tally[0], agenda.clock[0], state.pairs
    _refresh(problem, state)
    found = 0
    for k in range(clock.awake):
        i = agenda.awake[k]
        for m in range(agenda.row_size[i]):
            near = agenda.rows[i, m]
            if near.stiffness != 0.0:
                pair = pairs[found]
                pair.i, pair.j = i, near.j
                _copy_memory(near, pair)
                found += 1
    tally.pairs = found


@kernel
def _resume_if_thinned(problem, state, agenda):
    """Take over from `synchronous` if few particles touch; False if a row is full."""
    tally, clock, particles = state.tally[0], agenda.clock[0], state.particles
    touching = 0
    for i in range(tally.live):
        touching += 1 if particles[i].motion == TOUCHING else 0
    if touching > THINNED * tally.live:
        return True
    clock.crowded = 0
    clock.awake = 0
    clock.next_due = NEVER
    clock.grid_live = 0
    for i in range(tally.live):
        agenda.asleep[i] = False
        agenda.due[i] = NEVER
        agenda.row_size[i] = 0
        agenda.flights[0, i] = FAR
        if particles[i].motion == FLYING:
            record_flight(agenda, particles[i], i)
        elif particles[i].motion == TOUCHING:
            agenda.awake[clock.awake] = i
            clock.awake += 1
    for k in range(clock.awake):
        if not make_row(problem, state, agenda, agenda.awake[k], tally.step):
            return False
    for p in range(tally.pairs):
        pair = state.pairs[p]
        for m in range(agenda.row_size[pair.i]):
            near = agenda.rows[pair.i, m]
            if near.j == pair.j and pair.stiffness != 0.0:
                _copy_memory(pair, near)
    return _sleep_or_wake(problem, state, agenda, 0)


@kernel
def _compact(state, agenda):
    """Close the gaps of removed particles, in the agenda and in the state."""
    tally, clock = state.tally[0], agenda.clock[0]
    target = np.empty(tally.live, np.int64)
    kept = 0
    for i in range(tally.live):
        target[i] = -1
        if state.particles[i].motion != GONE:
            target[i] = kept
            if kept != i:
                agenda.asleep[kept] = agenda.asleep[i]
                agenda.due[kept] = agenda.due[i]
                agenda.row_size[kept] = agenda.row_size[i]
                agenda.row_next[kept] = agenda.row_next[i]
                agenda.row_until[kept] = agenda.row_until[i]
                for axis in range(7):
                    agenda.flights[axis, kept] = agenda.flights[axis, i]
                if not agenda.asleep[i]:
                    for m in range(agenda.row_size[i]):
                        agenda.rows[kept, m] = agenda.rows[i, m]
            kept += 1
    for k in range(clock.awake):
        i = target[agenda.awake[k]]
        agenda.awake[k] = i
        size = 0
        for m in range(agenda.row_size[i]):
            j = target[agenda.rows[i, m].j]
            if j >= 0:
                agenda.rows[i, size] = agenda.rows[i, m]
                agenda.rows[i, size].j = j
                size += 1
        agenda.row_size[i] = size
    clock.grid_live = 0
    compact(state)
