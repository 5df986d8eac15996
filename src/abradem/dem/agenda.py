"""What is planned for each particle: the cell it is in, when it is due, what it can touch.

See `islands`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dem.borrow import borrowed
from abradem.dem.cache import kernel
from abradem.dem.state import Problem, lined_up

SLOTS = 32
"""Largest number of near partners in a row: at most about 17 particles fit within three radii."""

NEVER = 2**62

SAFETY = 1e-7
"""Relative enlargement of radii in predictions, far above the rounding error."""

CROWD, THIN = 0.28, 0.2
"""Shares of the particles that touch something, above which `synchronous` takes over and up to
which it hands back. What is faster changes between these shares, see docs/notes/performance.md."""

SLACK = 0.1
"""Distance by which a particle may leave its cell, in radii."""

FEW, FEW_SLACK, FEW_TALL = 512, 0.4, 4.0
"""Room for particles up to which cells have this larger slack, and are taller than wide by this
factor: a thin jet then falls through fewer cells, and few particles are in each."""

RING = 4096
"""Number of slots of the queue, a power of two. Slot ``step % RING`` lists who is due at a step."""

NUMBER = np.dtype(np.int32)
"""Type of the numbers of particles in cells and in what a search finds."""

BUCKET = 8
"""Numbers for each cell: the particles in it, and at last how many. Those that find no room are in
a list that every search looks through; in cells of equal spheres there are hardly ever any."""

# Plan of one particle. The lists of the queue are linked in both directions by index; -1 ends them.
PLAN = np.dtype(
    [
        ("awake", np.int64),
        # Row: first step at which it needs attention, and last step for which it is complete
        # (-1: there is no row).
        ("row_next", np.int64),
        ("row_until", np.int64),
        # Course of an awake particle, m/s, and the square of the distance by which it may stray
        # from it in a step, m2.
        ("course_x", np.float64),
        ("course_y", np.float64),
        ("course_z", np.float64),
        ("stray2", np.float64),
        # Relative speed of the contacts that began in this step, m/s.
        ("impact", np.float64),
        # Speed by which its velocity may differ from the course, m/s, and size of the row.
        ("stray", np.float64),
        ("row_size", np.int64),
        # Flying particle: first step at which it can touch the plate or fall below the removal
        # level, at which it can touch a flying one, at which it has left its cell, and the
        # earliest of these.
        ("due", np.int64),
        ("plate_due", np.int64),
        ("meet_due", np.int64),
        ("leave_due", np.int64),
        # The flying particle that it can touch at ``meet_due`` (-1: unknown), the step at which
        # this was found, and the first step at which it can touch any other.
        ("meet_with", np.int64),
        ("meet_found", np.int64),
        ("meet_next", np.int64),
        ("queue_next", np.int64),
        ("queue_previous", np.int64),
        ("cell", np.int64),
    ]
)

NEAR = np.dtype([("j", np.int64), ("next_check", np.int64)])

CLOCK = np.dtype(
    [
        # Number of awake particles.
        ("awake", np.int64),
        # Number of contacts that begin in this step.
        ("begun", np.int64),
        # Number of particles without room in their cell.
        ("spilled", np.int64),
        # Cells per axis of the grid: two to this power; 0: lists of cells and queue are not valid.
        ("bits", np.int64),
        # Width and height of a cell, and distance by which a particle may leave it, m.
        ("width", np.float64),
        ("height", np.float64),
        ("slack", np.float64),
        # Whether `synchronous` does the stepping at present, and the shares of particles in contact
        # above which it takes over and at which it hands back.
        ("crowded", np.int64),
        ("crowd", np.float64),
        ("thin", np.float64),
        # Number of threads that step a crowd.
        ("threads", np.int64),
    ]
)

SPILLED, DUE, LANDED = 0, 1, 2
"""Uses of `Agenda.lists`."""


class Agenda(NamedTuple):
    """The awake particles, and the step at which each sleeping particle is due.

    Attributes
    ----------
    clock : ndarray of CLOCK, shape (1,)
    plans : ndarray of PLAN, shape (capacity,)
    awake : ndarray of int, shape (capacity,)
        Indices of the awake particles, ascending.
    rows : ndarray of NEAR, shape (capacity, SLOTS)
        Near partners of an awake particle, each with the step before which they cannot touch.
    queue : ndarray of int, shape (RING,)
        First sleeping particle of each slot of the queue.
    cells : ndarray of int32, shape (cells, BUCKET)
        Particles in each cell, and their number.
    near : ndarray of int32, shape (capacity + BUCKET,)
        The particles that a search in cells has found.
    lists : ndarray of int, shape (3, capacity)
        Lists of particles: those without room in their cell, and working memory.
    begun : ndarray of int, shape (8 capacity,)
        Contacts that begin in this step, ascending: first index times 2^32 plus the second.
    """

    clock: np.ndarray
    plans: np.ndarray
    awake: np.ndarray
    rows: np.ndarray
    queue: np.ndarray
    cells: np.ndarray
    near: np.ndarray
    lists: np.ndarray
    begun: np.ndarray


def make_agenda(problem: Problem, capacity: int, threads: int = 1) -> Agenda:
    """Return an empty agenda with room for ``capacity`` particles.

    Threads take over from `islands` where the stepping by one thread does.
    """
    agenda = Agenda(
        clock=np.zeros(1, CLOCK),
        plans=np.zeros(capacity, PLAN),
        awake=np.zeros(capacity, np.int64),
        rows=np.zeros((capacity, SLOTS), NEAR),
        queue=np.full(RING, -1),
        cells=lined_up((8 ** _bits(capacity), BUCKET), NUMBER),
        near=np.zeros(capacity + BUCKET, NUMBER),
        lists=np.zeros((3, capacity), np.int64),
        begun=np.zeros(8 * capacity, np.int64),
    )
    agenda.clock["bits"] = _bits(capacity)
    slack = problem.radius * (FEW_SLACK if capacity <= FEW else SLACK)
    width = 2.0 * problem.radius * (1.0 + SAFETY) + 2.0 * slack
    agenda.clock["slack"], agenda.clock["width"] = slack, width
    agenda.clock["height"] = width * (FEW_TALL if capacity <= FEW else 1.0)
    agenda.clock["crowd"] = CROWD
    agenda.clock["thin"] = THIN
    agenda.clock["threads"] = threads
    return agenda


def _bits(capacity: int) -> int:
    """Return the power of two of the number of cells per axis: at least two cells a particle."""
    bits = 3
    while 8**bits < 2 * capacity:
        bits += 1
    return bits


def grown_agenda(agenda: Agenda, problem: Problem, capacity: int) -> Agenda:
    """Return the agenda with room for ``capacity`` particles."""
    larger = make_agenda(problem, capacity)
    size = agenda.awake.size
    for name in CLOCK.names or ():
        if name not in ("slack", "width", "height"):
            larger.clock[name] = agenda.clock[name]
    # Lists of cells and queue are built again at their next use.
    larger.clock["bits"] = 0
    for name in ("plans", "awake", "rows"):
        getattr(larger, name)[:size] = getattr(agenda, name)
    return larger


@kernel(inline=True)
def borrowed_agenda(agenda):
    return Agenda(
        borrowed(agenda.clock),
        borrowed(agenda.plans),
        borrowed(agenda.awake),
        borrowed(agenda.rows),
        borrowed(agenda.queue),
        borrowed(agenda.cells),
        borrowed(agenda.near),
        borrowed(agenda.lists),
        borrowed(agenda.begun),
    )


@kernel(inline=True)
def enqueue(agenda, i):
    """Enter sleeping particle i in the queue at its due step."""
    plan = agenda.plans[i]
    plan.due = min(plan.plate_due, min(plan.meet_due, plan.leave_due))
    slot = plan.due & (RING - 1)
    first = agenda.queue[slot]
    plan.queue_next, plan.queue_previous = first, -1
    if first >= 0:
        agenda.plans[first].queue_previous = i
    agenda.queue[slot] = i


@kernel(inline=True)
def dequeue(agenda, i):
    """Remove sleeping particle i from the queue."""
    plan = agenda.plans[i]
    if plan.queue_previous >= 0:
        agenda.plans[plan.queue_previous].queue_next = plan.queue_next
    else:
        agenda.queue[plan.due & (RING - 1)] = plan.queue_next
    if plan.queue_next >= 0:
        agenda.plans[plan.queue_next].queue_previous = plan.queue_previous
