"""What is awake, until when the others sleep, and whom the awake may meet: see `islands`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dem.borrow import borrowed
from abradem.dem.cache import kernel
from abradem.dem.state import PAIR, Problem

SLOTS = 32
"""Room for near partners in a row: within three radii hardly more than 17 spheres fit."""

NEVER = 2**62
FAR = 1e9

NEAR = np.dtype([("next_check", np.int64), *PAIR.descr])
CLOCK = np.dtype(
    [
        ("awake", np.int64),
        ("next_due", np.int64),
        ("limit", np.float64),
        # The grid of cells: when it was made, and of how many particles.
        ("grid_step", np.int64),
        ("grid_live", np.int64),
        # Whether `synchronous` has taken over.
        ("crowded", np.int64),
    ]
)


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
    grid_first, grid_member : ndarray, shape (4 capacity + 1,) and (capacity,)
        Particles sorted by the slot of their cell, and where each slot begins.
    grid_cell : ndarray, shape (capacity, 3)
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
    # Any positive limit is right; it rises to what is met.
    agenda.clock["limit"] = problem.radius / problem.dt * 1e-3
    return agenda


def grown_agenda(agenda: Agenda, problem: Problem, capacity: int) -> Agenda:
    """Return the agenda with room for ``capacity`` particles."""
    larger = make_agenda(problem, capacity)
    size = agenda.awake.size
    larger.clock[:] = agenda.clock
    # The grid is not taken along; it is made again when next looked into.
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
