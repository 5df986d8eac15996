"""Fast stepping: time passes only where something touches.

Between contacts a particle is on an exact parabola (`state.flight`), so nothing needs to be
stepped until it can meet something. A particle is *asleep* while a bound says that it cannot, and
*awake* otherwise. Awake particles, the islands of contact in a sea of flight, take the very
steps of `synchronous`, in the same order; when none is awake, time jumps to the next bound.

All bounds are lower bounds of the lattice step at which a contact can open:

- asleep against the plate and the removal level: roots of the parabola;
- asleep against asleep: gravity cancels, the relative motion is a straight line, the closest
  approach is exact;
- awake against anything: a row of near partners, each with the step before which a gap cannot
  close at the speed limit. The limit holds for all flights (energy down to the removal level)
  and is verified for every awake particle in every step; where it is broken, it is raised and
  all rows are made anew before the step's contacts are looked for.

A bound that was too early costs a little time, never a contact, and whether two particles touch
is decided by the same expression as in `synchronous`. Both give the same bits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.dem.borrow import borrowed, borrowed_state
from abradem.dem.cache import kernel
from abradem.dem.factory import release_due
from abradem.dem.motion import finish, move, remove_if_fallen, touch_pair, touch_plate
from abradem.dem.neighbours import compact
from abradem.dem.plate import height_over
from abradem.dem.state import (
    DONE,
    FLYING,
    GONE,
    NEEDS_ROOM,
    OVERLAP_STOP,
    PAIR,
    STOP_CROWDED,
    STOP_OVERLAP,
    TOUCHING,
    WAKING,
    Problem,
    State,
    flight,
)

SLOTS = 32
"""Room for near partners in a row: within three radii hardly more than 17 spheres fit."""

REACH = 1.0
"""How far beyond contact a row looks when it is made, in radii."""

NAP = 4
"""A particle that would sleep no longer than this many steps stays awake."""

SAFETY = 1e-7
"""Share by which radii are enlarged in predictions, far above rounding."""

NEVER = 2**62
FAR = 1e9

NEAR = np.dtype([("next_check", np.int64), *PAIR.descr])
CLOCK = np.dtype([("awake", np.int64), ("next_due", np.int64), ("limit", np.float64)])


class Agenda(NamedTuple):
    """What is awake, and until when the others sleep.

    Attributes
    ----------
    clock : ndarray of CLOCK, shape (1,)
        Number awake, earliest step any sleeper is due, speed limit (m/s).
    awake : ndarray, shape (capacity,)
        Indices of the awake, ascending.
    asleep : ndarray of bool, shape (capacity,)
    due : ndarray, shape (capacity,)
        A sleeper touches nothing before this step.
    flights : ndarray, shape (7, capacity)
        Anchors of all flying particles, x y z vx vy vz step, for quick passes over all; x is
        `FAR` for the others.
    scratch : ndarray, shape (capacity,)
    row_size, row_next, row_until : ndarray, shape (capacity,)
        Partners in the row of an awake particle, the first step at which one of them can be
        touched, the last step for which the row is complete.
    rows : ndarray of NEAR, shape (capacity, SLOTS)
        Partners in ascending order; the contact's memory lies with the lower index.
    """

    clock: np.ndarray
    awake: np.ndarray
    asleep: np.ndarray
    due: np.ndarray
    flights: np.ndarray
    scratch: np.ndarray
    row_size: np.ndarray
    row_next: np.ndarray
    row_until: np.ndarray
    rows: np.ndarray


def make_agenda(problem: Problem, capacity: int) -> Agenda:
    """Return an empty agenda with room for ``capacity`` particles."""
    agenda = Agenda(
        clock=np.zeros(1, CLOCK),
        awake=np.zeros(capacity, np.int64),
        asleep=np.zeros(capacity, np.bool_),
        due=np.full(capacity, NEVER),
        flights=np.full((7, capacity), FAR),
        scratch=np.zeros(capacity),
        row_size=np.zeros(capacity, np.int64),
        row_next=np.zeros(capacity, np.int64),
        row_until=np.zeros(capacity, np.int64),
        rows=np.zeros((capacity, SLOTS), NEAR),
    )
    agenda.clock["next_due"] = NEVER
    # Any positive limit is right; it rises to what is met.
    agenda.clock["limit"] = problem.radius / problem.dt * 1e-3
    return agenda


def grown_agenda(agenda: Agenda, problem: Problem, capacity: int) -> Agenda:
    """Return the agenda with room for ``capacity`` particles."""
    larger = make_agenda(problem, capacity)
    size = agenda.awake.size
    larger.clock[:] = agenda.clock
    larger.flights[:, :size] = agenda.flights
    for name in ("awake", "asleep", "due", "row_size", "row_next", "row_until", "rows"):
        getattr(larger, name)[:size] = getattr(agenda, name)
    return larger


@kernel(inline=True)
def _borrowed_agenda(agenda):
    return Agenda(
        borrowed(agenda.clock),
        borrowed(agenda.awake),
        borrowed(agenda.asleep),
        borrowed(agenda.due),
        borrowed(agenda.flights),
        borrowed(agenda.scratch),
        borrowed(agenda.row_size),
        borrowed(agenda.row_next),
        borrowed(agenda.row_until),
        borrowed(agenda.rows),
    )


@kernel
def advance(problem, schedule, state, agenda, last_step):
    """Advance to lattice step ``last_step``; return how that ended, at a whole step."""
    state, agenda = borrowed_state(state), _borrowed_agenda(agenda)
    tally, clock = state.tally[0], agenda.clock[0]
    outcome = DONE
    while tally.step < last_step and outcome == DONE:
        if tally.gone > 16 + tally.live // 8:
            _compact(state, agenda)
        if tally.step >= tally.next_release:
            _refresh(problem, state)
            before = tally.live
            outcome = release_due(problem, schedule, state)
            for new in range(before, tally.live):
                if not _welcome(problem, state, agenda, new):
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
    _publish(problem, state, agenda)
    return outcome


@kernel(inline=True)
def _step(problem, state, agenda):
    """Advance the awake by one lattice step; same order of everything as in `synchronous`."""
    tally, particles, clock = state.tally[0], state.particles, agenda.clock[0]
    awake, rows, facet_wear = agenda.awake, agenda.rows, state.facet_wear
    now = tally.step + 1
    for k in range(clock.awake):
        if agenda.row_until[awake[k]] < now and not _make_row(
            problem, state, agenda, awake[k], tally.step
        ):
            return STOP_CROWDED

    farthest2 = 0.0
    for k in range(clock.awake):
        particle = particles[awake[k]]
        farthest2 = max(farthest2, move(problem, particle, tally.step))
        height = height_over(problem.plate, particle.x, particle.y)
        if abs(height) < problem.radius or particle.plate_stiffness != 0.0:
            touch_plate(problem, particle, tally, facet_wear)
    if farthest2 > (clock.limit * problem.dt) ** 2 and not _raise_limit(
        problem, state, agenda, math.sqrt(farthest2) / problem.dt, now
    ):
        return STOP_CROWDED

    # Sleepers that are met wake first, so that contacts are then taken in order.
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
            if _distance2(particles[i], other) < contact2:
                if not _wake(problem, state, agenda, near.j, now):
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
                _record_flight(agenda, particle, i)
            if _may_sleep(problem, state, agenda, i, now):
                agenda.asleep[i] = True
                kept -= 1
    clock.awake = kept
    if tally.largest_overlap > OVERLAP_STOP:
        return STOP_OVERLAP
    # A flight faster than the limit, found just above, may be met from the next step on.
    if clock.limit < 0.0 and not _raise_limit(problem, state, agenda, -clock.limit, now):
        return STOP_CROWDED
    return DONE


@kernel(inline=True)
def _distance2(a, b):
    dx, dy, dz = a.x - b.x, a.y - b.y, a.z - b.z
    return dx * dx + dy * dy + dz * dz


@kernel(inline=True)
def _steps_to_close(problem, limit, distance2):
    """Steps in which two particles cannot close their gap, both at the speed limit."""
    gap = math.sqrt(distance2) - 2.0 * problem.radius * (1.0 + SAFETY)
    return np.int64(math.floor(gap / (2.0 * limit * problem.dt)))


@kernel(inline=True)
def _touch_partners(problem, state, agenda, i, now):
    """Contacts of awake particle i with partners of higher index; look ahead for all."""
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
            dx, dy, dz = a.x - b.x, a.y - b.y, a.z - b.z
            distance2 = dx * dx + dy * dy + dz * dz
            if distance2 < contact2:
                if near.j > i:
                    distance = math.sqrt(distance2)
                    n = (dx / distance, dy / distance, dz / distance)
                    touch_pair(problem, near, a, b, distance, n, tally)
                near.next_check = now + 1
            else:
                near.stiffness = 0.0
                steps = _steps_to_close(problem, limit, distance2)
                near.next_check = now + 1 + max(steps, 0)
        first = min(first, near.next_check)
    agenda.row_next[i] = first


@kernel(inline=True)
def _record_flight(agenda, particle, i):
    agenda.flights[0, i] = particle.anchor_x
    agenda.flights[1, i] = particle.anchor_y
    agenda.flights[2, i] = particle.anchor_z
    agenda.flights[3, i] = particle.vx
    agenda.flights[4, i] = particle.vy
    agenda.flights[5, i] = particle.vz
    agenda.flights[6, i] = particle.anchor_step


@kernel(inline=True)
def first_time_within(x, v, a, half, start):
    """First time t >= start at which abs(x + v t + a t^2/2) <= half, or infinity."""
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

    The first time at which the centre lies in the box around the plate that reaches one radius
    beyond it on all sides: the first times along the three axes are iterated until they agree.
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
def _due_step(problem, now, time):
    """Lattice step before which nothing happens, for something ``time`` ahead; rounding safe."""
    steps = time / problem.dt
    if steps > 1e15:
        return NEVER
    return now + np.int64(steps)


@kernel
def _may_sleep(problem, state, agenda, i, now):
    """Find until when flying particle i meets nothing; tell the others; False for a short nap.

    A particle that stays awake meets sleepers through its row, so they need not be told.
    """
    clock, flights, due = agenda.clock[0], agenda.flights, agenda.due
    time = problem.dt * (now - flights[6, i])
    vx, vz = flights[3, i], flights[5, i]
    vy = flights[4, i] - problem.gravity * time
    x = flight(flights[0, i], vx, 0.0, time)
    y = flight(flights[1, i], flights[4, i], -problem.gravity, time)
    z = flight(flights[2, i], vz, 0.0, time)

    drop = max(y - problem.removal_height, 0.0)
    fastest = math.sqrt(vx * vx + vy * vy + vz * vz + 2.0 * problem.gravity * drop)
    if fastest * (1.0 + SAFETY) > abs(clock.limit):
        clock.limit = -fastest

    until = first_time_within(drop, vy, -problem.gravity, 0.0, 0.0)
    until = min(until, time_to_plate(problem, x, y, z, vx, vy, vz))
    mine = _due_step(problem, now, until)
    due[i] = mine
    if mine <= now + NAP:
        return False

    _miss_distances(problem, flights, agenda.scratch, state.tally[0].live, now, x, y, z, vx, vy, vz)
    reach2 = (2.0 * problem.radius * (1.0 + SAFETY)) ** 2
    for j in range(state.tally[0].live):
        if agenda.scratch[j] >= reach2 or j == i or flights[0, j] == FAR:
            continue
        meet = _due_step(problem, now, _time_to_meet(problem, flights, j, now, x, y, z, vx, vy, vz))
        mine = min(mine, meet)
        if meet < due[j]:
            due[j] = meet
            if agenda.asleep[j]:
                clock.next_due = min(clock.next_due, meet)
    due[i] = mine
    if mine <= now + NAP:
        return False
    clock.next_due = min(clock.next_due, mine)
    return True


@kernel(inline=True)
def _relative_flight(problem, flights, j, now, x, y, z, vx, vy, vz):
    """Place and velocity of a flying particle against flying particle j at step ``now``."""
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
def _miss_distances(problem, flights, out, live, now, x, y, z, vx, vy, vz):
    """Square of the least distance that a flying particle will have to each other, m2.

    Both fall alike, so the relative motion is a straight line. A plain loop without branches:
    the compiler makes vector code of it.
    """
    for j in range(live):
        px, py, pz, ux, uy, uz = _relative_flight(problem, flights, j, now, x, y, z, vx, vy, vz)
        nearing = max(-(px * ux + py * uy + pz * uz), 0.0)
        speed2 = ux * ux + uy * uy + uz * uz + 1e-300
        away = FAR if nearing == 0.0 else 0.0
        out[j] = away + (px * px + py * py + pz * pz) - nearing * nearing / speed2


@kernel(inline=True)
def _time_to_meet(problem, flights, j, now, x, y, z, vx, vy, vz):
    """Time until a flying particle is within reach of flying particle j, s, or infinity."""
    px, py, pz, ux, uy, uz = _relative_flight(problem, flights, j, now, x, y, z, vx, vy, vz)
    reach = 2.0 * problem.radius * (1.0 + SAFETY)
    gap2 = max(px * px + py * py + pz * pz - reach * reach, 0.0)
    nearing = -(px * ux + py * uy + pz * uz)
    discriminant = max(nearing * nearing - (ux * ux + uy * uy + uz * uz) * gap2, 0.0)
    if nearing <= 0.0:
        return np.inf
    return gap2 / (nearing + math.sqrt(discriminant))


@kernel(inline=True)
def _distances(problem, flights, out, live, now, x, y, z):
    """Square of the distance of a place to every flying particle at step ``now``, m2."""
    for j in range(live):
        time = problem.dt * (now - flights[6, j])
        dx = x - (flights[0, j] + flights[3, j] * time)
        dy = y - (flights[1, j] + (flights[4, j] - 0.5 * problem.gravity * time) * time)
        dz = z - (flights[2, j] + flights[5, j] * time)
        out[j] = dx * dx + dy * dy + dz * dz


@kernel
def _make_row(problem, state, agenda, i, now):
    """Make the row of particle i from all positions at step ``now``; False if it is too full."""
    particles, flights, clock = state.particles, agenda.flights, agenda.clock[0]
    rows = agenda.rows
    # Memory of open contacts outlives the row.
    kept = 0
    for m in range(agenda.row_size[i]):
        if rows[i, m].stiffness != 0.0:
            rows[i, kept] = rows[i, m]
            kept += 1
    memory = rows[i, :kept].copy()

    a = particles[i]
    live = state.tally[0].live
    distance2 = agenda.scratch
    _distances(problem, flights, distance2, live, now, a.x, a.y, a.z)
    for k in range(clock.awake):
        # What is awake stands where it is, in contact or not.
        distance2[agenda.awake[k]] = _distance2(a, particles[agenda.awake[k]])
    steps = max(np.int64(REACH * problem.radius / (2.0 * clock.limit * problem.dt)), 1)
    while True:
        reach = 2.0 * problem.radius * (1.0 + SAFETY) + 2.0 * clock.limit * problem.dt * steps
        size = 0
        first = NEVER
        for j in range(live):
            if distance2[j] >= reach * reach or j == i or particles[j].motion == GONE:
                continue
            if size == SLOTS:
                size += 1
                break
            near = rows[i, size]
            near.j = j
            near.stiffness = 0.0
            near.next_check = now + 1 + _steps_to_close(problem, clock.limit, distance2[j])
            first = min(first, near.next_check)
            size += 1
        if size <= SLOTS:
            break
        if steps == 1:
            return False
        steps //= 2
    m = 0
    for c in range(kept):
        while rows[i, m].j != memory[c].j:
            m += 1
        check = rows[i, m].next_check
        rows[i, m] = memory[c]
        rows[i, m].next_check = check
    agenda.row_size[i] = size
    agenda.row_next[i] = first
    agenda.row_until[i] = now + steps
    return True


@kernel
def _raise_limit(problem, state, agenda, speed, now):
    """Set a speed limit above ``speed`` and make all rows anew; False if one is too full."""
    clock = agenda.clock[0]
    clock.limit = 1.2 * speed
    for k in range(clock.awake):
        if not _make_row(problem, state, agenda, agenda.awake[k], now):
            return False
    return True


@kernel
def _wake(problem, state, agenda, i, now):
    """Wake particle i, whose position is that of step ``now``; False if its row is too full."""
    clock, awake = agenda.clock[0], agenda.awake
    agenda.asleep[i] = False
    agenda.row_size[i] = 0
    k = clock.awake
    while k > 0 and awake[k - 1] > i:
        awake[k] = awake[k - 1]
        k -= 1
    awake[k] = i
    clock.awake += 1
    return _make_row(problem, state, agenda, i, now)


@kernel
def _wake_due(problem, state, agenda):
    """Wake all that may touch something in the coming step; False if a row is too full."""
    tally, clock = state.tally[0], agenda.clock[0]
    clock.next_due = NEVER
    for i in range(tally.live):
        if not agenda.asleep[i]:
            continue
        if agenda.due[i] <= tally.step + 1:
            _fly_to(problem, state.particles[i], tally.step)
            if not _wake(problem, state, agenda, i, tally.step):
                return False
        else:
            clock.next_due = min(clock.next_due, agenda.due[i])
    return True


@kernel
def _welcome(problem, state, agenda, new):
    """Take in a particle that was just released; False if a row is too full."""
    tally, clock = state.tally[0], agenda.clock[0]
    particle = state.particles[new]
    _record_flight(agenda, particle, new)
    agenda.asleep[new] = False
    agenda.row_size[new] = 0
    if _may_sleep(problem, state, agenda, new, tally.step):
        agenda.asleep[new] = True
    elif not _wake(problem, state, agenda, new, tally.step):
        return False
    if clock.limit < 0.0:
        return _raise_limit(problem, state, agenda, -clock.limit, tally.step)
    # Rows that were made before do not know it yet.
    for k in range(clock.awake):
        i = agenda.awake[k]
        left = agenda.row_until[i] - tally.step
        reach = 2.0 * problem.radius * (1.0 + SAFETY) + 2.0 * clock.limit * problem.dt * left
        distance2 = _distance2(state.particles[i], particle)
        if i == new or distance2 >= reach * reach:
            continue
        if agenda.row_size[i] == SLOTS:
            if not _make_row(problem, state, agenda, i, tally.step):
                return False
            continue
        # It is the highest index of all, hence the last of the row.
        near = agenda.rows[i, agenda.row_size[i]]
        near.j = new
        near.stiffness = 0.0
        near.next_check = tally.step + 1 + _steps_to_close(problem, clock.limit, distance2)
        agenda.row_next[i] = min(agenda.row_next[i], near.next_check)
        agenda.row_size[i] += 1
    return True


@kernel(inline=True)
def _fly_to(problem, particle, step):
    """Put a flying particle where it is at a lattice step."""
    time = problem.dt * (step - particle.anchor_step)
    particle.x = flight(particle.anchor_x, particle.vx, 0.0, time)
    particle.y = flight(particle.anchor_y, particle.vy, -problem.gravity, time)
    particle.z = flight(particle.anchor_z, particle.vz, 0.0, time)


@kernel
def _refresh(problem, state):
    """Put all flying particles where they are now."""
    for i in range(state.tally[0].live):
        particle = state.particles[i]
        if particle.motion == FLYING:
            _fly_to(problem, particle, state.tally[0].step)


@kernel
def _publish(problem, state, agenda):
    """Leave positions and open pair contacts as `synchronous` leaves them."""
    tally, clock, pairs = state.tally[0], agenda.clock[0], state.pairs
    _refresh(problem, state)
    found = 0
    for k in range(clock.awake):
        i = agenda.awake[k]
        for m in range(agenda.row_size[i]):
            near = agenda.rows[i, m]
            if near.stiffness != 0.0:
                pair = pairs[found]
                pair.i, pair.j, pair.stiffness = i, near.j, near.stiffness
                pair.sx, pair.sy, pair.sz = near.sx, near.sy, near.sz
                pair.fn, pair.tx, pair.ty, pair.tz = near.fn, near.tx, near.ty, near.tz
                found += 1
    tally.pairs = found


@kernel
def _compact(state, agenda):
    """Close the gaps that removed particles left, in the agenda too."""
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
    compact(state)
