"""What the threads of one simulation share: lists of their particles and pairs, and a barrier.

Each particle belongs to one thread, see `parallel`. The threads meet at a barrier: each counts up
a number of its own and waits until the others have done so too. A thread that waits long sleeps,
so that more threads than cores are slow but do not hang.
"""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np
from numba.core import types
from numba.core.types import ExternalFunction
from numba.extending import intrinsic

from abradem.dem.borrow import borrowed
from abradem.dem.cache import kernel
from abradem.dem.neighbours import Grid, make_grid
from abradem.dem.state import LINE as LINE_BYTES
from abradem.dem.state import PAIR, PAIRS_PER_PARTICLE, PARTICLE, TALLY, lined_up

PART = 64
"""Number of particles whose pairs are a part of a new pair list. Threads look for parts in turn."""

LOOKS = 100_000
"""Looks at the number of another thread, some forty microseconds, before a thread sleeps for about
as long. What it waits for is mostly sooner, unless other work has the core of the other thread; who
sleeps then is woken before those who do not."""

LINE = LINE_BYTES // 8
"""Numbers in two lines of the cache: what a thread writes in every step is that far from what
others write."""

# Columns of `Team.signals` and `Team.sizes`.
PASSED, FALLEN, WORN = 0, 1, 2
MEMBERS, LINKS, BORDER = 0, 1, 2

LEAST, MOST, OVERLAP = 0, 3, 6
"""Columns of `Team.values`: the least and the largest displacement along each axis, m, and the
largest overlap, m."""

# What all threads act on: the step to which they go, the outcome, whether a thread has failed, so
# that the others do not wait, the number of particles that have a thread, and the axis across
# which space is cut.
SHARED = np.dtype([(name, np.int64) for name in ("until", "outcome", "stop", "known", "axis")])

# A pair of the list for a thread: the places of the two in `Team.particles` and that of the pair in
# `State.pairs`. ``ghost`` says which of the two belongs to another thread, ``thread``: none, the
# first or the second. That one has no place; it is in row ``slot`` of what that thread shows.
LINK = np.dtype(
    [("i", np.uint32), ("j", np.uint32)]
    + [(name, np.int64) for name in ("pair", "ghost", "thread", "slot")]
)
NO_GHOST, FIRST, SECOND = 0, 1, 2

# Position of a particle at the border of a thread's slab, m, and whether it is there.
SHOWN = np.dtype([(name, np.float64) for name in ("x", "y", "z")] + [("motion", np.int64)])

# Wear of one contact with the plate in a step, and energy of a removed particle.
WEAR = np.dtype(
    [("i", np.int64), ("ix", np.int64), ("iz", np.int64)]
    + [(name, np.float64) for name in ("total", "sliding", "friction")]
)
LOSS = np.dtype([("i", np.int64), ("energy", np.float64), ("kinetic", np.float64)])


class Team(NamedTuple):
    """The threads of one simulation; the first index is the thread.

    Attributes
    ----------
    signals : ndarray of int, shape (threads, LINE)
        Number of barriers reached; numbers of entries in ``losses`` and ``wear`` in this step.
    values : ndarray, shape (threads, LINE)
        Displacements and overlap of this step, m.
    shared : ndarray of SHARED, shape (1,)
    cuts : ndarray, shape (threads,)
        Where along an axis the particles of each thread end, m.
    tallies : ndarray of TALLY, shape (threads, 2)
        Counters and sums of each thread, in the first column.
    owner : ndarray of int, shape (capacity,)
        The thread of each particle.
    members : ndarray of int, shape (threads, capacity)
        Indices of the particles of each thread, ascending.
    particles : ndarray of PARTICLE, shape (threads, capacity)
        Those particles, side by side. In the array of all, a processor that walks over the
        particles of one thread would fetch those of others ahead, and take them from the other
        processor.
    links : ndarray of LINK, shape (threads, 8 capacity)
        The pairs of each thread, in the order of the pair list.
    memories : ndarray of PAIR, shape (threads, 8 capacity)
        Memory of the contact of each link: lines of the cache that no other thread writes.
    border : ndarray of int, shape (threads, capacity)
        Places in ``particles`` of those that are in a pair with one of another thread.
    shown : ndarray of SHOWN, shape (threads, capacity)
        Their positions, side by side: what other threads read in every step.
    places, slots : ndarrays of int, shape (threads, capacity)
        Working memory of each thread: the place of each of its particles in ``particles``, and of
        any particle in ``border``; -1: none.
    ghosts : ndarray of PARTICLE, shape (threads, 2)
        Copy of a particle of another thread, in the first column.
    wear : ndarray of WEAR, shape (threads, capacity)
    losses : ndarray of LOSS, shape (threads, capacity)
    sizes : ndarray of int, shape (threads, LINE)
        Numbers of particles and pairs of each thread.
    counts : ndarray of int, shape (threads, at least threads)
    heads : ndarray of int, shape (threads,)
    found : ndarray of int, shape (parts,)
        Number of pairs in each part of a new pair list, see `PART`.
    grid : Grid
        Working memory, as ``counts``, ``heads`` and ``found``.
    """

    signals: np.ndarray
    values: np.ndarray
    shared: np.ndarray
    cuts: np.ndarray
    tallies: np.ndarray
    owner: np.ndarray
    members: np.ndarray
    particles: np.ndarray
    links: np.ndarray
    memories: np.ndarray
    border: np.ndarray
    shown: np.ndarray
    places: np.ndarray
    slots: np.ndarray
    ghosts: np.ndarray
    wear: np.ndarray
    losses: np.ndarray
    sizes: np.ndarray
    counts: np.ndarray
    heads: np.ndarray
    found: np.ndarray
    grid: Grid


def make_team(threads: int, capacity: int) -> Team:
    """Return the memory of a number of threads with room for ``capacity`` particles."""
    pairs = capacity * PAIRS_PER_PARTICLE
    return Team(
        signals=lined_up((threads, LINE), np.int64),
        values=lined_up((threads, LINE), np.float64),
        shared=np.zeros(1, SHARED),
        cuts=np.zeros(threads),
        tallies=lined_up((threads, 2), TALLY),
        owner=np.zeros(capacity, np.int64),
        members=lined_up((threads, capacity), np.int64),
        particles=lined_up((threads, capacity), PARTICLE),
        links=lined_up((threads, pairs), LINK),
        memories=lined_up((threads, pairs), PAIR),
        border=lined_up((threads, capacity), np.int64),
        shown=lined_up((threads, capacity), SHOWN),
        places=lined_up((threads, capacity), np.int64),
        slots=lined_up((threads, capacity), np.int64),
        ghosts=lined_up((threads, 2), PARTICLE),
        wear=lined_up((threads, capacity), WEAR),
        losses=lined_up((threads, capacity), LOSS),
        sizes=lined_up((threads, LINE), np.int64),
        counts=lined_up((threads, -(-threads // LINE) * LINE), np.int64),
        heads=np.zeros(threads, np.int64),
        found=np.zeros(-(-capacity // PART), np.int64),
        grid=make_grid.py_func(capacity, np.empty(pairs, PAIR)),
    )


@kernel(inline=True)
def borrowed_grid(grid):
    return Grid(
        borrowed(grid.box),
        borrowed(grid.counts),
        borrowed(grid.first),
        borrowed(grid.cell),
        borrowed(grid.member),
        borrowed(grid.place),
        borrowed(grid.kept),
        borrowed(grid.chain),
        borrowed(grid.head),
    )


@kernel(inline=True)
def borrowed_team(team):
    return Team(
        borrowed(team.signals),
        borrowed(team.values),
        borrowed(team.shared),
        borrowed(team.cuts),
        borrowed(team.tallies),
        borrowed(team.owner),
        borrowed(team.members),
        borrowed(team.particles),
        borrowed(team.links),
        borrowed(team.memories),
        borrowed(team.border),
        borrowed(team.shown),
        borrowed(team.places),
        borrowed(team.slots),
        borrowed(team.ghosts),
        borrowed(team.wear),
        borrowed(team.losses),
        borrowed(team.sizes),
        borrowed(team.counts),
        borrowed(team.heads),
        borrowed(team.found),
        borrowed_grid(team.grid),
    )


def _passed(context, builder, array_type, array, thread):
    """Pointer to the number of barriers that a thread has reached."""
    signals = context.make_array(array_type)(context, builder, array)
    place = builder.mul(thread, context.get_constant(types.int64, LINE))
    return builder.gep(signals.data, [place])


@intrinsic
def _announce(typing_context, signals, thread, number):
    """Set the number of barriers of a thread; all that it wrote before is then visible."""

    def codegen(context, builder, signature, arguments):
        place = _passed(context, builder, signature.args[0], arguments[0], arguments[1])
        builder.store_atomic(arguments[2], place, ordering="release", align=8)
        return context.get_dummy_value()

    return types.void(signals, types.int64, types.int64), codegen


@intrinsic
def _look(typing_context, signals, thread):
    """Return the number of barriers of a thread; all that it wrote before is then visible."""

    def codegen(context, builder, signature, arguments):
        place = _passed(context, builder, signature.args[0], arguments[0], arguments[1])
        return builder.load_atomic(place, ordering="acquire", align=8)

    return types.int64(signals, types.int64), codegen


if os.name == "posix":
    _sleep = ExternalFunction("usleep", types.int32(types.uint32))
else:

    @kernel(inline=True)
    def _sleep(microseconds):
        return np.int32(0)


@kernel
def wait(team, me):
    """Wait until all threads have come here; False if one of them has failed."""
    signals = team.signals
    number = signals[me, PASSED] + 1
    _announce(signals, me, number)
    for other in range(len(signals)):
        looks = 0
        while _look(signals, other) < number:
            looks += 1
            if looks > LOOKS:
                if team.shared[0].stop != 0:
                    return False
                _sleep(np.uint32(1))
    return True
