"""Awake and sleeping particles, and the near partners of the awake ones: see `islands`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dem.borrow import borrowed
from abradem.dem.cache import kernel
from abradem.dem.state import PAIR, Problem

SLOTS = 32
"""Largest number of near partners in a row: at most about 17 particles fit within three radii."""

NEVER = 2**62
FAR = 1e9

NEAR = np.dtype([("next_check", np.int64), *PAIR.descr])
CLOCK = np.dtype(
    [
        ("awake", np.int64),
        ("next_due", np.int64),
        ("limit", np.float64),
        # The grid of cells: the step at which it was built, and the number of particles in it.
        ("grid_step", np.int64),
        ("grid_live", np.int64),
        # Whether `synchronous` does the stepping at present.
        ("crowded", np.int64),
    ]
)


class Agenda(NamedTuple):
    """The awake particles, and the step at which each sleeping particle is due.

    Attributes
    ----------
    clock : ndarray of CLOCK, shape (1,)
        Number of awake particles, earliest due step of all sleeping particles, speed limit (m/s).
    awake : ndarray, shape (capacity,)
        Indices of the awake particles, ascending.
    asleep : ndarray of bool, shape (capacity,)
    due : ndarray, shape (capacity,)
        A sleeping particle touches nothing before this step.
    flights : ndarray, shape (7, capacity)
        Anchors of all flying particles, x y z vx vy vz step, in one array for fast loops over
        all particles; x is `FAR` for particles that do not fly.
    scratch : ndarray, shape (capacity,)
        Working memory, for example squared distances to all particles, m2.
    grid_first, grid_member : ndarray, shape (4 capacity + 1,) and (capacity,)
        Index at which each slot of the grid begins in ``grid_member``, and the particles sorted
        by the slot of their cell.
    grid_cell : ndarray, shape (capacity, 3)
        Cell of each particle.
    row_size, row_next, row_until : ndarray, shape (capacity,)
        Number of partners in the row of an awake particle, the first step at which it can touch
        one of them, and the last step for which the row is complete.
    rows : ndarray of NEAR, shape (capacity, SLOTS)
        Partners in ascending order. The memory of a contact is in the row of the lower index.
    """

    clock: np.ndarray
    awake: np.ndarray
    asleep: np.ndarray
    due: np.ndarray
    flights: np.ndarray
    scratch: np.ndarray
    grid_first: np.ndarray
    grid_member: np.ndarray
    grid_cell: np.ndarray
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
        grid_first=np.zeros(4 * capacity + 1, np.int64),
        grid_member=np.zeros(capacity, np.int64),
        grid_cell=np.zeros((capacity, 3), np.int64),
        row_size=np.zeros(capacity, np.int64),
        row_next=np.zeros(capacity, np.int64),
        row_until=np.zeros(capacity, np.int64),
        rows=np.zeros((capacity, SLOTS), NEAR),
    )
    agenda.clock["next_due"] = NEVER
    # Any positive start value is valid: the limit is raised when a particle is faster.
    agenda.clock["limit"] = problem.radius / problem.dt * 1e-3
    return agenda


def grown_agenda(agenda: Agenda, problem: Problem, capacity: int) -> Agenda:
    """Return the agenda with room for ``capacity`` particles."""
    larger = make_agenda(problem, capacity)
    size = agenda.awake.size
    larger.clock[:] = agenda.clock
    # The grid is not copied; it is built again at its next use.
    larger.clock["grid_live"] = 0
    larger.flights[:, :size] = agenda.flights
    for name in ("awake", "asleep", "due", "row_size", "row_next", "row_until", "rows"):
        getattr(larger, name)[:size] = getattr(agenda, name)
    return larger


@kernel(inline=True)
def borrowed_agenda(agenda):
    return Agenda(
        borrowed(agenda.clock),
        borrowed(agenda.awake),
        borrowed(agenda.asleep),
        borrowed(agenda.due),
        borrowed(agenda.flights),
        borrowed(agenda.scratch),
        borrowed(agenda.grid_first),
        borrowed(agenda.grid_member),
        borrowed(agenda.grid_cell),
        borrowed(agenda.row_size),
        borrowed(agenda.row_next),
        borrowed(agenda.row_until),
        borrowed(agenda.rows),
    )


@kernel(inline=True)
def record_flight(agenda, particle, i):
    agenda.flights[0, i] = particle.anchor_x
    agenda.flights[1, i] = particle.anchor_y
    agenda.flights[2, i] = particle.anchor_z
    agenda.flights[3, i] = particle.vx
    agenda.flights[4, i] = particle.vy
    agenda.flights[5, i] = particle.vz
    agenda.flights[6, i] = particle.anchor_step
