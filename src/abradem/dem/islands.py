"""Fast stepping: only particles that touch something are stepped.

Between contacts a particle moves on an exact parabola (`state.flight`), so it need not be stepped
until it can touch something. A particle is *awake* while it touches something, and *asleep* while
it flies. Awake particles take the same steps as in `synchronous`, in the same order. If no particle
is awake, the time jumps to the next step at which one is due.

All bounds are lower bounds of the lattice step at which a contact can begin, and all are found
among the particles in the cells around a particle (`cells`):

- sleeping particle and plate or removal level: roots of the parabola (`flights.plan_plate`);
- two sleeping particles: gravity cancels, the relative motion is a straight line, and the closest
  approach is exact (`flights.plan_pairs`);
- awake particle and any other: the row of one of them (`rows`).

A sleeping particle is due, in a queue sorted by step, when it can touch something or is in another
cell. So a step looks at the awake particles, at those that are due, and at nothing else.

If most particles touch something, the bounds cost more than they save. `synchronous` then does the
stepping until fewer touch: in a crowd of more than `SMALLEST_CROWD` particles it takes over if more
than a share is awake, and hands back if at most another share touches something (`agenda`).

A bound that is too early costs a little time but never misses a contact. Whether two particles
touch is decided by the same expression as in `synchronous`. Both give bitwise equal results.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem import synchronous
from abradem.dem.agenda import (
    DUE,
    LANDED,
    NEVER,
    RING,
    borrowed_agenda,
    dequeue,
    enqueue,
)
from abradem.dem.borrow import borrowed_state
from abradem.dem.cache import kernel
from abradem.dem.cells import cell_of, empty_cells, enter_cell, leave_cell
from abradem.dem.factory import release_due
from abradem.dem.flights import forget_meeting, plan_flights, plan_pairs
from abradem.dem.mesh_contact import touch_surface
from abradem.dem.motion import finish, fly_to, move, remove_if_fallen, touch_pair, touch_plate
from abradem.dem.neighbours import compact
from abradem.dem.plate import height_over
from abradem.dem.rows import BLOW, distance2_to, make_rows, note_in_row, steps_apart
from abradem.dem.state import (
    DONE,
    FLYING,
    GONE,
    NEEDS_TEAM,
    OVERLAP_STOP,
    STOP_CROWDED,
    STOP_OVERLAP,
    TOUCHING,
    fall_speed,
)
from abradem.dem.vectors import dot, scaled

SMALLEST_CROWD = 256
"""Number of particles for each thread from which on `synchronous` can take over."""

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
            if clock.threads > 1:
                return NEEDS_TEAM
            until = min(last_step, tally.step + CROWD_STEPS)
            outcome = synchronous.advance(problem, schedule, state, until)
            if outcome == DONE and not resume_if_thinned(problem, state, agenda):
                outcome = STOP_CROWDED
            continue
        if clock.bits == 0 and not plan_all(problem, state, agenda):
            outcome = STOP_CROWDED
            break
        if tally.gone > 16 + tally.live // 8:
            _compact(state, agenda)
        if tally.step >= tally.next_release:
            before = tally.live
            outcome = release_due(problem, schedule, state, agenda)
            _plan_released(problem, state, agenda, before)
            if outcome != DONE:
                break
        if clock.awake == 0:
            _jump(agenda, tally, min(tally.next_release, last_step))
            if tally.step >= min(tally.next_release, last_step):
                continue
        outcome = _step(problem, state, agenda)
        if clock.awake > clock.crowd * tally.live and tally.live > SMALLEST_CROWD * clock.threads:
            _refresh(problem, state)
            # `synchronous` then builds its pair list in the first step.
            tally.drift = np.inf
            clock.crowded = 1
    if clock.crowded == 0:
        _refresh(problem, state)
    return outcome


@kernel(inline=True)
def _jump(agenda, tally, last):
    """Advance the time, but not beyond step ``last``, to that before one with an entry due."""
    step, end = tally.step, min(last, tally.step + RING)
    while step < end and agenda.queue[(step + 1) & (RING - 1)] < 0:
        step += 1
    tally.step = step


@kernel(inline=True)
def _step(problem, state, agenda):
    """Advance the awake particles by one lattice step, in the same order as `synchronous`."""
    tally, particles, clock = state.tally[0], state.particles, agenda.clock[0]
    awake, plans = agenda.awake, agenda.plans
    now = tally.step + 1
    clock.begun = 0
    hasty = 0
    for k in range(clock.awake):
        i = awake[k]
        plan = plans[i]
        dx, dy, dz = move(problem, particles[i], tally.step)
        dx -= problem.dt * plan.course_x
        dy -= problem.dt * plan.course_y
        dz -= problem.dt * plan.course_z
        if dx * dx + dy * dy + dz * dz > plan.stray2 or plan.row_until < now:
            agenda.lists[LANDED, hasty] = i
            hasty += 1
    # Rows of particles that strayed farther than assumed are made again before contacts are
    # looked for.
    if hasty > 0 and not make_rows(problem, state, agenda, LANDED, hasty, now, now):
        return STOP_CROWDED

    if agenda.queue[now & (RING - 1)] >= 0:
        _meet_due(problem, state, agenda, now)
    k = 0
    while k < clock.awake:
        i = awake[k]
        k += 1
        if plans[i].row_next <= now:
            k += _check_row(problem, state, agenda, i, now)
    if clock.begun > 0 and not _merge_begun(state, agenda):
        return STOP_CROWDED

    _touch_walls(problem, state, agenda, state.mesh, now)
    _touch_pairs(problem, state, agenda, now)
    tally.step = now
    landed, changed, kept = 0, 0, 0
    for k in range(clock.awake):
        i = awake[k]
        particle, plan = particles[i], plans[i]
        if particle.motion != FLYING:
            finish(problem, particle, now)
            if particle.motion == FLYING:
                plan.plate_due = plan.meet_due = now
        remove_if_fallen(problem, particle, tally)
        if particle.motion == TOUCHING:
            awake[kept] = i
            kept += 1
            if plan.row_until < 0 or plan.impact > 0.0:
                agenda.lists[DUE, changed] = i
                changed += 1
        else:
            plan.awake = 0
            if particle.motion == GONE:
                leave_cell(agenda, i)
            else:
                agenda.lists[LANDED, landed] = i
                landed += 1
    clock.awake = kept
    if landed > 0:
        plan_flights(problem, state, agenda, landed, now)
    if changed > 0 and not make_rows(problem, state, agenda, DUE, changed, now, NEVER):
        return STOP_CROWDED
    if tally.largest_overlap / problem.radius > OVERLAP_STOP:
        return STOP_OVERLAP
    return DONE


@kernel(inline=True)
def _touch_walls(problem, state, agenda, mesh, now):
    """Contacts of the awake particles with the plate or, if there is one, with the surface."""
    particles, awake = state.particles, agenda.awake
    if mesh is not None:
        touch_surface(
            problem, particles, state.tally, state.facet_wear, mesh, now, awake,
            agenda.clock[0].awake,
        )  # fmt: skip
        return
    for k in range(agenda.clock[0].awake):
        particle = particles[awake[k]]
        height = height_over(problem.plate, particle.x, particle.y)
        if abs(height) < problem.radius or particle.plate_stiffness != 0.0:
            touch_plate(problem, particle, state.tally[0], state.facet_wear)


@kernel
def _meet_due(problem, state, agenda, now):
    """Examine all sleeping particles that are due at step ``now``."""
    plans, lists = agenda.plans, agenda.lists
    count = 0
    i = agenda.queue[now & (RING - 1)]
    while i >= 0:
        if plans[i].due <= now:
            lists[DUE, count] = i
            count += 1
        i = plans[i].queue_next
    for k in range(count):
        i = lists[DUE, k]
        plan = plans[i]
        forget_meeting(state, plan, now)
        if min(plan.meet_due, plan.leave_due) <= now:
            for m in range(plan_pairs(problem, state, agenda, i, now)):
                _begin(problem, state, agenda, i, np.int64(agenda.near[m]), now)
        if plan.plate_due <= now:
            # It is stepped like the awake particles, which finds out whether it touches.
            _attend(problem, state, agenda, i, now)
        elif plan.awake == 0:
            # Its entry in the queue is still that of the earlier due step.
            dequeue(agenda, i)
            enqueue(agenda, i)


@kernel(inline=True)
def _check_row(problem, state, agenda, i, now):
    """Check the partners of awake particle i that are due; return how many below i were woken."""
    particles, plan, row = state.particles, agenda.plans[i], agenda.rows[i]
    contact2 = 4.0 * problem.radius * problem.radius
    a = particles[i]
    first, woken = plan.row_until + 1, 0
    for m in range(plan.row_size):
        near = row[m]
        if near.next_check <= now:
            j = near.j
            b = particles[j]
            if b.motion == GONE:
                near.next_check = NEVER
                continue
            distance2 = distance2_to(problem, a, b, now)
            if distance2 < contact2:
                near.next_check = NEVER
                if j < i and agenda.plans[j].awake == 0:
                    woken += 1
                _begin(problem, state, agenda, i, j, now)
                continue
            horizon = problem.dt * (plan.row_until - now)
            check = steps_apart(problem, agenda, a, plan, b, j, distance2, now, horizon)
            near.next_check = max(check, now + 1)
        first = min(first, near.next_check)
    plan.row_next = first
    return woken


@kernel(inline=True)
def _clear_row(plan):
    """Have a particle that is awake from now on without a row."""
    plan.impact = 0.0
    plan.course_x = plan.course_y = plan.course_z = 0.0
    plan.stray = 0.0
    plan.row_size = 0
    plan.row_next = NEVER
    plan.row_until = -1


@kernel(inline=True)
def _order(i, j):
    """Number that puts pairs in the order of their first and then their second particle."""
    return (np.int64(i) << 32) | np.int64(j)


@kernel
def _attend(problem, state, agenda, i, now):
    """Have sleeping particle i stepped to step ``now``."""
    clock, awake, plan = agenda.clock[0], agenda.awake, agenda.plans[i]
    if plan.awake != 0:
        return
    dequeue(agenda, i)
    plan.awake = 1
    _clear_row(plan)
    fly_to(problem, state.particles[i], now)
    k = clock.awake
    while k > 0 and awake[k - 1] > i:
        awake[k] = awake[k - 1]
        k -= 1
    awake[k] = i
    clock.awake += 1


@kernel
def _begin(problem, state, agenda, i, j, now):
    """Note that the contact of particles i and j begins at step ``now``, unless it is open."""
    pairs, clock, begun = state.pairs, agenda.clock[0], agenda.begun
    key = _order(min(i, j), max(i, j))
    low, high = 0, state.tally[0].pairs
    while low < high:
        middle = (low + high) // 2
        if _order(pairs[middle].i, pairs[middle].j) < key:
            low = middle + 1
        else:
            high = middle
    if low < state.tally[0].pairs and _order(pairs[low].i, pairs[low].j) == key:
        return
    at = clock.begun
    while at > 0 and begun[at - 1] > key:
        at -= 1
    if at > 0 and begun[at - 1] == key:
        return
    _attend(problem, state, agenda, i, now)
    _attend(problem, state, agenda, j, now)
    impact = _relative_speed(problem, state.particles[i], state.particles[j], now)
    for k in (i, j):
        if BLOW * impact > agenda.plans[k].stray:
            agenda.plans[k].impact = max(agenda.plans[k].impact, impact)
    # Too many contacts are noticed when they are merged.
    if clock.begun < begun.size:
        for m in range(clock.begun, at, -1):
            begun[m] = begun[m - 1]
        begun[at] = key
    clock.begun += 1


@kernel(inline=True)
def _relative_speed(problem, a, b, now):
    a_vy = fall_speed(problem, a, now) if a.motion == FLYING else a.vy
    b_vy = fall_speed(problem, b, now) if b.motion == FLYING else b.vy
    apart = (a.vx - b.vx, a_vy - b_vy, a.vz - b.vz)
    return math.sqrt(dot(apart, apart))


@kernel
def _merge_begun(state, agenda):
    """Merge the contacts that begin into the ascending list of pairs; False if it is full."""
    tally, pairs, begun = state.tally[0], state.pairs, agenda.begun
    count = agenda.clock[0].begun
    total = tally.pairs + count
    if total > pairs.size:
        return False
    source, target = tally.pairs - 1, total - 1
    for f in range(count - 1, -1, -1):
        while source >= 0 and _order(pairs[source].i, pairs[source].j) > begun[f]:
            pairs[target] = pairs[source]
            source -= 1
            target -= 1
        pairs[target].i = begun[f] >> 32
        pairs[target].j = begun[f] & 0xFFFFFFFF
        pairs[target].stiffness = 0.0
        target -= 1
    tally.pairs = total
    return True


@kernel(inline=True)
def _touch_pairs(problem, state, agenda, now):
    """Contacts between particles; those that have ended leave the list."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    contact2 = 4.0 * problem.radius * problem.radius
    kept = 0
    for p in range(tally.pairs):
        pair = pairs[p]
        a, b = particles[pair.i], particles[pair.j]
        apart = (a.x - b.x, a.y - b.y, a.z - b.z)
        distance2 = dot(apart, apart)
        if distance2 < contact2 and a.motion != GONE and b.motion != GONE:
            distance = math.sqrt(distance2)
            n = scaled(apart, 1.0 / distance)
            touch_pair(problem, pair, a, b, distance, n, tally)
            if kept < p:
                pairs[kept] = pair
            kept += 1
        elif a.motion != GONE and b.motion != GONE:
            note_in_row(agenda, np.int64(pair.i), np.int64(pair.j), now + 1)
    tally.pairs = kept


@kernel
def _plan_released(problem, state, agenda, first):
    """Plan the particles just released, from index ``first`` on."""
    tally, count = state.tally[0], 0
    for new in range(first, tally.live):
        plan = agenda.plans[new]
        plan.awake = 0
        plan.plate_due = plan.meet_due = tally.step
        agenda.lists[LANDED, count] = new
        count += 1
    plan_flights(problem, state, agenda, count, tally.step)


@kernel
def _refresh(problem, state):
    """Set the positions of all flying particles to those of the current step."""
    for i in range(state.tally[0].live):
        particle = state.particles[i]
        if particle.motion == FLYING:
            fly_to(problem, particle, state.tally[0].step)


@kernel
def plan_all(problem, state, agenda):
    """Plan all particles from their positions at the current step; False if a row is full."""
    tally, clock, particles, pairs = state.tally[0], agenda.clock[0], state.particles, state.pairs
    agenda.queue[:] = -1
    empty_cells(agenda)
    clock.bits = 0
    while 8**clock.bits < len(agenda.cells):
        clock.bits += 1
    clock.awake, flying = 0, 0
    for i in range(tally.live):
        particle, plan = particles[i], agenda.plans[i]
        if particle.motion == GONE:
            continue
        enter_cell(agenda, i, cell_of(agenda, particle.x, particle.y, particle.z))
        plan.plate_due = plan.meet_due = tally.step
        plan.meet_with = -1
        plan.awake = 1 if particle.motion == TOUCHING else 0
        if plan.awake != 0:
            _clear_row(plan)
            agenda.awake[clock.awake] = i
            agenda.lists[DUE, clock.awake] = i
            clock.awake += 1
        else:
            agenda.lists[LANDED, flying] = i
            flying += 1
    _sort_open(tally, pairs)
    if not make_rows(problem, state, agenda, DUE, clock.awake, tally.step, NEVER):
        return False
    plan_flights(problem, state, agenda, flying, tally.step)
    return True


@kernel
def _sort_open(tally, pairs):
    """Keep the open contacts of the list of pairs, in ascending order."""
    one = np.empty(1, pairs.dtype)
    kept = 0
    for p in range(tally.pairs):
        if pairs[p].stiffness != 0.0:
            one[0] = pairs[p]
            order = _order(one[0].i, one[0].j)
            at = kept
            while at > 0 and _order(pairs[at - 1].i, pairs[at - 1].j) > order:
                pairs[at] = pairs[at - 1]
                at -= 1
            pairs[at] = one[0]
            kept += 1
    tally.pairs = kept


@kernel
def resume_if_thinned(problem, state, agenda):
    """Take over from `synchronous` if few particles touch; False if a row is full."""
    tally, particles = state.tally[0], state.particles
    touching = 0
    for i in range(tally.live):
        touching += 1 if particles[i].motion == TOUCHING else 0
    if touching > agenda.clock[0].thin * tally.live:
        return True
    agenda.clock[0].crowded = 0
    return plan_all(problem, state, agenda)


@kernel
def _compact(state, agenda):
    """Close the gaps of removed particles, in the agenda and in the state."""
    tally, clock, plans, rows = state.tally[0], agenda.clock[0], agenda.plans, agenda.rows
    target = np.empty(tally.live, np.int64)
    kept = 0
    for i in range(tally.live):
        target[i] = -1
        if state.particles[i].motion != GONE:
            target[i] = kept
            if kept != i:
                plans[kept] = plans[i]
                if plans[i].awake != 0:
                    for m in range(plans[i].row_size):
                        rows[kept, m] = rows[i, m]
            kept += 1
    for k in range(clock.awake):
        i = target[agenda.awake[k]]
        agenda.awake[k] = i
        size = 0
        for m in range(plans[i].row_size):
            j = target[rows[i, m].j]
            if j >= 0:
                rows[i, size].j = j
                rows[i, size].next_check = rows[i, m].next_check
                size += 1
        plans[i].row_size = size
    for i in range(tally.live):
        if target[i] >= 0 and plans[target[i]].meet_with >= 0:
            plans[target[i]].meet_with = target[plans[target[i]].meet_with]
    compact(state)
    agenda.queue[:] = -1
    empty_cells(agenda)
    for i in range(tally.live):
        enter_cell(agenda, i, plans[i].cell)
        if plans[i].awake == 0:
            enqueue(agenda, i)
