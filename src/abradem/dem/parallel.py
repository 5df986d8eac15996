"""Conventional stepping of one simulation by several threads, with the bits of a single one.

Each particle belongs to one thread (domain decomposition in slabs, e.g. Plimpton 1995, J. Comput.
Phys. 117:1). A thread moves its particles, takes their contacts with the plate and, after a
barrier, those between particles that concern one of its own, in the order of the pair list. Of a
contact between particles of two threads both compute all, with a copy of the particle of the other
(a *ghost*), and each adds the force to its own. So the forces on a particle are summed in the order
of `synchronous`, whatever the number of threads. Where sums run over particles, as for wear, each
thread writes down its terms and the first one adds them in the order of the particles.

Nothing that a thread reads of a ghost changes meanwhile: positions, the velocities of a particle
that touched something in the step before, and the flight of any other.

A thread keeps its particles and the memory of its contacts in arrays of its own for the length of a
pair list, and shows positions near its border side by side. Where particles of several threads lie
in one array, each core takes lines of the cache from the others all the time, not least by fetching
ahead, and two threads are slower than one.

Slabs are chosen, at each new pair list, so that each thread has the same number of instructions.
"""

from __future__ import annotations

import math
import threading

import numpy as np

from abradem.dem.borrow import borrowed_state
from abradem.dem.cache import kernel
from abradem.dem.motion import (
    finish,
    move,
    press_plate,
    remove_if_fallen,
    touch_pair,
    wear_facet,
)
from abradem.dem.neighbours import find_pairs, sort_into_cells
from abradem.dem.plate import height_over
from abradem.dem.state import (
    DONE,
    FLYING,
    GONE,
    OVERLAP_STOP,
    SKIN,
    STOP_CROWDED,
    STOP_OVERLAP,
    TOUCHING,
    WAKING,
)
from abradem.dem.synchronous import LONGEST_PIECE, prepare
from abradem.dem.team import (
    BORDER,
    FALLEN,
    FIRST,
    LEAST,
    LINKS,
    MEMBERS,
    MOST,
    NO_GHOST,
    OVERLAP,
    PART,
    SECOND,
    WORN,
    Team,
    borrowed_team,
    make_team,
    wait,
)
from abradem.dem.vectors import dot, scaled

FLIGHT, CONTACT, PLATE, LISTED, PAIR_CONTACT = 50, 130, 350, 10, 140
"""Instructions of a step, counted (docs/performance.md): of a particle that flies or touches
something, of its contact with the plate, and half of those of a pair of the list and of a contact
between particles."""

SUM = 150
"""Adding the wear of a contact, which the first thread does for all: by its time, in terms of the
instructions above, as it waits for memory and for wrongly guessed branches."""

BINS = 1024
"""Number of places at which a slab can end."""


class Threads:
    """The threads that step one simulation together."""

    def __init__(self, threads: int):
        self.threads = threads
        self.team: Team | None = None

    def advance(self, problem, schedule, state, last_step: int) -> int:
        """Advance to lattice step ``last_step``; return the outcome, as in `synchronous`."""
        capacity = state.particles.size
        if self.team is None or self.team.owner.size != capacity:
            self.team = make_team(self.threads, capacity)
        team = self.team
        team.signals[:] = 0
        team.shared[:] = 0
        failures: list[BaseException] = []

        def run(me: int) -> int:
            try:
                return advance(problem, schedule, state, team, me, last_step)
            except BaseException as error:
                failures.append(error)
                team.shared["stop"] = 1
                return DONE

        others = []
        try:
            for me in range(1, self.threads):
                others.append(threading.Thread(target=run, args=(me,), daemon=True))
                others[-1].start()
        except BaseException as error:
            others.pop()
            failures.append(error)
            team.shared["stop"] = 1
        outcome = run(0)
        for other in others:
            other.join()
        if failures:
            raise failures[0]
        return outcome


@kernel(nogil=True)
def advance(problem, schedule, state, team, me, last_step):
    """Advance to lattice step ``last_step`` as thread ``me``, while the others do the same.

    The outcome is always after a whole step.
    """
    state, team = borrowed_state(state), borrowed_team(team)
    shared = team.shared[0]
    while True:
        if me == 0:
            _begin_piece(problem, schedule, state, team, last_step)
        if not wait(team, me):
            return DONE
        if shared.outcome != DONE or shared.until == state.tally[0].step:
            return shared.outcome
        _take_share(state, team, me)
        if not wait(team, me) or not _steps(problem, state, team, me, shared.until):
            return DONE
        if me == 0:
            _end_piece(state, team)


@kernel
def _begin_piece(problem, schedule, state, team, last_step):
    """Release particles, and say how far the threads go: until the next release at most."""
    tally, shared = state.tally[0], team.shared[0]
    shared.until = tally.step
    if shared.outcome == DONE and tally.step < last_step:
        gaps, known = tally.gone, shared.known
        shared.outcome = prepare(problem, schedule, state)
        shared.until = min(last_step, tally.next_release, tally.step + LONGEST_PIECE)
        if known == 0 or tally.gone < gaps:
            _share_out(state, team)
        for i in range(shared.known, tally.live):
            team.owner[i] = _owner_of(team, state.particles[i])
        shared.known = tally.live
    for me in range(len(team.tallies)):
        own = team.tallies[me, 0]
        own.step, own.drift, own.largest_overlap = tally.step, tally.drift, tally.largest_overlap


@kernel
def _end_piece(state, team):
    """Add up what the threads have counted."""
    tally = state.tally[0]
    tally.step, tally.drift = team.tallies[0, 0].step, team.tallies[0, 0].drift
    for me in range(len(team.tallies)):
        own = team.tallies[me, 0]
        tally.largest_overlap = max(tally.largest_overlap, own.largest_overlap)
        tally.face += own.face
        tally.edge += own.edge
        tally.missed += own.missed
        tally.removed += own.removed
        tally.gone += own.gone
        own.face = own.edge = own.missed = own.removed = own.gone = 0


@kernel
def _share_out(state, team):
    """Cut the space into slabs of equal work, and give each thread the particles of one."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    threads, shared = len(team.cuts), team.shared[0]
    work = np.zeros(tally.live, np.int64)
    total, sums = 0, 0
    for i in range(tally.live):
        particle = particles[i]
        if particle.motion == FLYING:
            work[i] = FLIGHT
        elif particle.motion != GONE:
            work[i] = CONTACT
            if particle.plate_stiffness != 0.0:
                work[i] += PLATE
                sums += SUM
        total += work[i]
    for p in range(tally.pairs):
        pair = pairs[p]
        half = LISTED if pair.stiffness == 0.0 else LISTED + PAIR_CONTACT
        work[pair.i] += half
        work[pair.j] += half
        total += 2 * half

    low, high = _longer_extent(tally, particles, shared)
    scale = BINS / (high - low) if high > low else 0.0
    in_bin = np.zeros(BINS, np.int64)
    for i in range(tally.live):
        if particles[i].motion != GONE:
            # Positions of nan get a bin too, so that the guard finds them.
            place = np.int64((_along(particles[i], shared.axis) - low) * scale)
            in_bin[min(max(place, 0), BINS - 1)] += work[i]  # type: ignore[index]
    # The first thread also adds up the wear.
    share = (total + sums) / threads
    passed, cut = float(sums), 0
    for c in range(BINS):
        passed += in_bin[c]
        while cut < threads - 1 and passed >= share * (cut + 1):
            team.cuts[cut] = low + (c + 1) / scale if scale > 0.0 else low
            cut += 1
    team.cuts[cut:] = np.inf
    for i in range(tally.live):
        team.owner[i] = _owner_of(team, particles[i])
    shared.known = tally.live


@kernel
def _longer_extent(tally, particles, shared):
    """Choose the horizontal axis along which the particles extend further; return its ends, m."""
    low_x = low_z = np.inf
    high_x = high_z = -np.inf
    for i in range(tally.live):
        particle = particles[i]
        if particle.motion != GONE:
            low_x, high_x = min(low_x, particle.x), max(high_x, particle.x)
            low_z, high_z = min(low_z, particle.z), max(high_z, particle.z)
    shared.axis = 0 if high_x - low_x >= high_z - low_z else 1
    return (low_x, high_x) if shared.axis == 0 else (low_z, high_z)


@kernel(inline=True)
def _along(particle, axis):
    return particle.x if axis == 0 else particle.z


@kernel(inline=True)
def _owner_of(team, particle):
    """Return the thread of a particle by its position."""
    place = _along(particle, team.shared[0].axis)
    owner = 0
    while owner < len(team.cuts) - 1 and place >= team.cuts[owner]:
        owner += 1
    return owner


@kernel
def _take_share(state, team, me):
    """List the particles of a thread, the pairs with at least one of them, and what it shows."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    owner, sizes, slots, places = team.owner, team.sizes[me], team.slots[me], team.places[me]
    members, links, memories = team.members[me], team.links[me], team.memories[me]
    shown = team.counts[me]
    count = 0
    for i in range(tally.live):
        slots[i] = -1
        if owner[i] == me and particles[i].motion != GONE:
            members[count] = i
            places[i] = count
            team.particles[me, count] = particles[i]
            count += 1
    sizes[MEMBERS] = count
    shown[:] = 0
    count = 0
    for p in range(tally.pairs):
        i, j = pairs[p].i, pairs[p].j
        mine, others = owner[i] == me, owner[j] == me
        # All threads number what is shown alike.
        if owner[i] != owner[j]:
            _number(team, me, i)
            _number(team, me, j)
        if not (mine or others):
            continue
        link = links[count]
        link.i = places[i] if mine else 0
        link.j = places[j] if others else 0
        link.pair, link.ghost = p, NO_GHOST
        if not mine:
            link.ghost, link.thread, link.slot = FIRST, owner[i], slots[i]
        elif not others:
            link.ghost, link.thread, link.slot = SECOND, owner[j], slots[j]
        memories[count] = pairs[p]
        count += 1
    sizes[LINKS], sizes[BORDER] = count, shown[me]


@kernel(inline=True)
def _number(team, me, i):
    """Give a particle at the border of its slab a place among those that its thread shows."""
    slots, owner = team.slots[me], team.owner[i]
    if slots[i] < 0:
        slots[i] = team.counts[me, owner]
        team.counts[me, owner] += 1
        if owner == me:
            team.border[me, slots[i]] = team.places[me, i]


@kernel
def _return_share(state, team, me):
    """Write the particles of a thread, and the memory of its contacts, back to the state."""
    for k in range(team.sizes[me, MEMBERS]):
        state.particles[team.members[me, k]] = team.particles[me, k]
    links, memories = team.links[me], team.memories[me]
    for k in range(team.sizes[me, LINKS]):
        link = links[k]
        if link.ghost != FIRST:
            pair = state.pairs[link.pair]
            if memories[k].stiffness != 0.0:
                state.pairs[link.pair] = memories[k]
            elif pair.stiffness != 0.0:
                pair.stiffness = 0.0


@kernel
def _rebuild_pairs(problem, state, team, me):
    """Build a new pair list as `neighbours.rebuild_pairs` does, and share it out.

    Return False if another thread failed.
    """
    tally, pairs, own = state.tally[0], state.pairs, team.memories[me]
    threads, found = len(team.cuts), team.found
    _return_share(state, team, me)
    if not wait(team, me):
        return False
    if me == 0:
        sort_into_cells(problem, state, team.grid)
    if not wait(team, me):
        return False
    parts = (tally.live + PART - 1) // PART
    count = 0
    for part in range(me, parts, threads):
        end = min((part + 1) * PART, tally.live)
        after = find_pairs(problem, state, team.grid, part * PART, end, own, count)
        if after < 0:
            found[part] = pairs.size + 1
            break
        found[part] = after - count
        count = after
    if not wait(team, me):
        return False
    total = 0
    for part in range(parts):
        total += found[part]
    if total > pairs.size:
        team.shared[0].outcome = STOP_CROWDED
        return wait(team, me)
    at, count = 0, 0
    for part in range(parts):
        if part % threads == me:
            for p in range(found[part]):
                pairs[at + p] = own[count + p]
            count += found[part]
        at += found[part]
    if me == 0:
        tally.pairs = total
    if not wait(team, me):
        return False
    if me == 0:
        _share_out(state, team)
    if not wait(team, me):
        return False
    _take_share(state, team, me)
    _show(team, me)
    return wait(team, me)


@kernel
def _steps(problem, state, team, me, until):
    """Step the particles of a thread to lattice step ``until``; False if another thread failed.

    At the barrier in the middle of a step all particles have moved, at the other all forces are
    known.
    """
    state, team = borrowed_state(state), borrowed_team(team)
    tally, shared, signals = team.tallies[me, 0], team.shared[0], team.signals
    finishing, moving = False, True
    while True:
        _move_members(problem, team, me, finishing, moving)
        if moving:
            _show(team, me)
            _touch_plate(problem, team, me)
        else:
            _return_share(state, team, me)
        if not wait(team, me):
            return False
        if me == 0:
            _add_up(state, team)
        if not moving:
            return True
        tally.drift += _spread(team)
        if tally.drift > SKIN * problem.radius:
            if not _rebuild_pairs(problem, state, team, me):
                return False
            if shared.outcome != DONE:
                return True
            tally.drift = 0.0
        _touch_pairs(problem, team, me)
        team.values[me, OVERLAP] = tally.largest_overlap
        if not wait(team, me):
            return False
        tally.step += 1
        for other in range(len(signals)):
            tally.largest_overlap = max(tally.largest_overlap, team.values[other, OVERLAP])
        stops = tally.largest_overlap / problem.radius > OVERLAP_STOP
        if stops and me == 0:
            shared.outcome = STOP_OVERLAP
        finishing, moving = True, tally.step < until and not stops


@kernel(inline=True)
def _move_members(problem, team, me, finishing, moving):
    """Finish a step of the particles of a thread and begin the next, as in `synchronous`."""
    particles, members, tally = team.particles[me], team.members[me], team.tallies[me, 0]
    values, signals = team.values[me], team.signals[me]
    least_x = least_y = least_z = most_x = most_y = most_z = 0.0
    fallen = 0
    for k in range(team.sizes[me, MEMBERS]):
        particle = particles[k]
        if particle.motion == GONE:
            continue
        if finishing:
            if particle.motion == TOUCHING or particle.motion == WAKING:
                finish(problem, particle, tally.step)
            remove_if_fallen(problem, particle, tally)
            if particle.motion == GONE:
                loss = team.losses[me, fallen]
                fallen += 1
                loss.i, loss.energy, loss.kinetic = members[k], tally.energy_out, tally.kinetic_out
                tally.energy_out = tally.kinetic_out = 0.0
                continue
        if not moving:
            continue
        dx, dy, dz = move(problem, particle, tally.step)
        least_x, most_x = min(least_x, dx), max(most_x, dx)
        least_y, most_y = min(least_y, dy), max(most_y, dy)
        least_z, most_z = min(least_z, dz), max(most_z, dz)
    signals[FALLEN] = fallen
    signals[WORN] = 0
    values[LEAST], values[LEAST + 1], values[LEAST + 2] = least_x, least_y, least_z
    values[MOST], values[MOST + 1], values[MOST + 2] = most_x, most_y, most_z


@kernel(inline=True)
def _show(team, me):
    """Write down the positions of particles that other threads look at."""
    for k in range(team.sizes[me, BORDER]):
        particle, shown = team.particles[me, team.border[me, k]], team.shown[me, k]
        shown.x, shown.y, shown.z = particle.x, particle.y, particle.z
        shown.motion = particle.motion


@kernel(inline=True)
def _touch_plate(problem, team, me):
    """Contacts of the particles of a thread with the plate; their wear is written down."""
    particles, members, tally = team.particles[me], team.members[me], team.tallies[me, 0]
    worn = 0
    for k in range(team.sizes[me, MEMBERS]):
        particle = particles[k]
        height = height_over(problem.plate, particle.x, particle.y)
        near = abs(height) < problem.radius or particle.plate_stiffness != 0.0
        if near and particle.motion != GONE:
            ix, iz, terms = press_plate(problem, particle, tally)
            if ix >= 0:
                wear = team.wear[me, worn]
                worn += 1
                wear.i, wear.ix, wear.iz = members[k], ix, iz
                wear.total, wear.sliding, wear.friction = terms
    team.signals[me, WORN] = worn


@kernel
def _add_up(state, team):
    """Add the wear and the lost energy that the threads have written down, by particle."""
    tally, signals = state.tally[0], team.signals
    at = team.heads
    at[:] = 0
    while True:
        first = _writer_of_next(team.wear, at, signals[:, WORN])
        if first < 0:
            break
        wear = team.wear[first, at[first]]
        at[first] += 1
        tally.worn_total += wear.total
        tally.worn_sliding += wear.sliding
        tally.worn_friction += wear.friction
        wear_facet(state.facet_wear, wear.ix, wear.iz, (wear.total, wear.sliding, wear.friction))
    at[:] = 0
    while True:
        first = _writer_of_next(team.losses, at, signals[:, FALLEN])
        if first < 0:
            break
        loss = team.losses[first, at[first]]
        at[first] += 1
        tally.energy_out += loss.energy
        tally.kinetic_out += loss.kinetic


@kernel(inline=True)
def _writer_of_next(written, at, counts):
    """Return the thread whose next record is of the first particle, or -1 if none is left."""
    first, least = -1, np.int64(2**62)
    for me in range(len(at)):
        if at[me] < counts[me] and written[me, at[me]].i < least:
            first, least = me, written[me, at[me]].i
    return first


@kernel(inline=True)
def _spread(team):
    """Return the largest difference between the displacements of two particles, m."""
    values = team.values
    least_x = least_y = least_z = most_x = most_y = most_z = 0.0
    for me in range(len(values)):
        least_x, most_x = min(least_x, values[me, LEAST]), max(most_x, values[me, MOST])
        least_y, most_y = min(least_y, values[me, LEAST + 1]), max(most_y, values[me, MOST + 1])
        least_z, most_z = min(least_z, values[me, LEAST + 2]), max(most_z, values[me, MOST + 2])
    return math.sqrt((most_x - least_x) ** 2 + (most_y - least_y) ** 2 + (most_z - least_z) ** 2)


@kernel(inline=True)
def _touch_pairs(problem, team, me):
    """Contacts between particles that concern those of a thread."""
    particles, tally = team.particles[me], team.tallies[me, 0]
    links, memories, ghost = team.links[me], team.memories[me], team.ghosts[me, 0]
    contact2 = 4.0 * problem.radius * problem.radius
    for k in range(team.sizes[me, LINKS]):
        link, pair = links[k], memories[k]
        a, b = particles[link.i], particles[link.j]
        if link.ghost == NO_GHOST:
            apart = (a.x - b.x, a.y - b.y, a.z - b.z)
            there = a.motion != GONE and b.motion != GONE
        elif link.ghost == FIRST:
            shown = team.shown[link.thread, link.slot]
            apart = (shown.x - b.x, shown.y - b.y, shown.z - b.z)
            there = shown.motion != GONE and b.motion != GONE
        else:
            shown = team.shown[link.thread, link.slot]
            apart = (a.x - shown.x, a.y - shown.y, a.z - shown.z)
            there = a.motion != GONE and shown.motion != GONE
        distance2 = dot(apart, apart)
        if distance2 < contact2 and there:
            distance = math.sqrt(distance2)
            n = scaled(apart, 1.0 / distance)
            if link.ghost == FIRST:
                _copy(_ghost_of(team, link), ghost)
                a = ghost
            elif link.ghost == SECOND:
                _copy(_ghost_of(team, link), ghost)
                b = ghost
            touch_pair(problem, pair, a, b, distance, n, tally)
        elif pair.stiffness != 0.0:
            pair.stiffness = 0.0


@kernel(inline=True)
def _ghost_of(team, link):
    """Return the particle of another thread in a pair."""
    return team.particles[link.thread, team.border[link.thread, link.slot]]


@kernel(inline=True)
def _copy(particle, ghost):
    """Copy of a particle of another thread what a contact needs.

    The other thread may be waking it in this step, so that what `wake` sets may be half written.
    All that comes from its flight, and is found from there once more.
    """
    touching = particle.motion == TOUCHING
    ghost.motion = TOUCHING if touching else FLYING
    ghost.anchor_step = particle.anchor_step
    ghost.vx, ghost.vy, ghost.vz = particle.vx, particle.vy, particle.vz
    ghost.wx, ghost.wy, ghost.wz = particle.wx, particle.wy, particle.wz
    if touching:
        ghost.half_vx, ghost.half_vy, ghost.half_vz = (
            particle.half_vx, particle.half_vy, particle.half_vz
        )  # fmt: skip
        ghost.half_wx, ghost.half_wy, ghost.half_wz = (
            particle.half_wx, particle.half_wy, particle.half_wz
        )  # fmt: skip
        ghost.next_vx, ghost.next_vy, ghost.next_vz = (
            particle.next_vx, particle.next_vy, particle.next_vz
        )  # fmt: skip
        ghost.next_wx, ghost.next_wy, ghost.next_wz = (
            particle.next_wx, particle.next_wy, particle.next_wz
        )  # fmt: skip
