"""Rows: the partners that an awake particle can touch in the next few hundred steps.

See `islands`.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import NEVER, SLOTS
from abradem.dem.bounds import SAFETY, centre_distance2, distances, steps_to_close
from abradem.dem.cache import kernel
from abradem.dem.state import GONE

REACH = 1.0
"""Largest gap to a partner in a new row, in radii."""

CROWD = 256
"""Number of particles from which on partners are searched in a grid of cells, not among all."""


@kernel(inline=True)
def _enter(problem, agenda, i, size, j, distance2, now):
    """Insert partner j into the row of i in ascending order; return the size, SLOTS + 1 if full."""
    if size >= SLOTS:
        return SLOTS + 1
    rows = agenda.rows
    at = size
    while at > 0 and rows[i, at - 1].j > j:
        rows[i, at].j = rows[i, at - 1].j
        rows[i, at].next_check = rows[i, at - 1].next_check
        at -= 1
    rows[i, at].j = j
    rows[i, size].stiffness = 0.0
    limit = agenda.clock[0].limit
    rows[i, at].next_check = now + 1 + steps_to_close(problem, limit, distance2)
    return size + 1


@kernel
def _partners_of_all(problem, state, agenda, i, now, reach2):
    """Build the row of i from all particles; return its size."""
    a, live, distance2 = state.particles[i], state.tally[0].live, agenda.scratch
    distances(problem, agenda.flights, distance2, live, now, a.x, a.y, a.z)
    for k in range(agenda.clock[0].awake):
        # Awake particles have their current position in the state, in contact or not.
        j = agenda.awake[k]
        distance2[j] = centre_distance2(a, state.particles[j])
    size = 0
    for j in range(live):
        if distance2[j] < reach2 and j != i and state.particles[j].motion != GONE:
            size = _enter(problem, agenda, i, size, j, distance2[j], now)
    return size


@kernel(inline=True)
def _cell_slot(cx, cy, cz, mask):
    """Slot of a cell in a table of ``mask + 1`` slots, a power of two."""
    return ((cx * 73856093) ^ (cy * 19349663) ^ (cz * 83492791)) & mask


@kernel
def _partners_of_grid(problem, state, agenda, i, now, reach):
    """Build the row of i from the cells around it; return its size."""
    tally, clock, flights, cell = state.tally[0], agenda.clock[0], agenda.flights, agenda.grid_cell
    width = 4.0 * problem.radius
    # Largest possible displacement of a particle since the grid was built.
    drift = clock.limit * problem.dt * (now - clock.grid_step)
    if drift > 0.5 * problem.radius or clock.grid_live != tally.live:
        _make_grid(problem, state, agenda, now, width)
        drift = 0.0
    a = state.particles[i]
    look = reach + drift
    low_x, high_x = math.floor((a.x - look) / width), math.floor((a.x + look) / width)
    low_y, high_y = math.floor((a.y - look) / width), math.floor((a.y + look) / width)
    low_z, high_z = math.floor((a.z - look) / width), math.floor((a.z + look) / width)
    mask = _grid_slots(tally.live) - 1
    size = 0
    for cx in range(low_x, high_x + 1):
        for cy in range(low_y, high_y + 1):
            for cz in range(low_z, high_z + 1):
                slot = _cell_slot(cx, cy, cz, mask)
                for m in range(agenda.grid_first[slot], agenda.grid_first[slot + 1]):
                    j = agenda.grid_member[m]
                    if cell[j, 0] != cx or cell[j, 1] != cy or cell[j, 2] != cz or j == i:
                        continue
                    b = state.particles[j]
                    if b.motion == GONE:
                        continue
                    if agenda.asleep[j]:
                        time = problem.dt * (now - flights[6, j])
                        fall = 0.5 * problem.gravity * time
                        dx = a.x - (flights[0, j] + flights[3, j] * time)
                        dy = a.y - (flights[1, j] + (flights[4, j] - fall) * time)
                        dz = a.z - (flights[2, j] + flights[5, j] * time)
                    else:
                        dx, dy, dz = a.x - b.x, a.y - b.y, a.z - b.z
                    distance2 = dx * dx + dy * dy + dz * dz
                    if distance2 < reach * reach:
                        size = _enter(problem, agenda, i, size, j, distance2, now)
    return size


@kernel(inline=True)
def _grid_slots(live):
    """A power of two, at least twice and less than four times the number of particles."""
    size = 16
    while size < 2 * live:
        size *= 2
    return size


@kernel
def _make_grid(problem, state, agenda, now, width):
    """Sort all particles by their cell at step ``now``."""
    tally, clock, flights, cell = state.tally[0], agenda.clock[0], agenda.flights, agenda.grid_cell
    first, live = agenda.grid_first, tally.live
    size = _grid_slots(live)
    first[: size + 1] = 0
    for j in range(live):
        particle = state.particles[j]
        x, y, z = particle.x, particle.y, particle.z
        if agenda.asleep[j]:
            time = problem.dt * (now - flights[6, j])
            x = flights[0, j] + flights[3, j] * time
            y = flights[1, j] + (flights[4, j] - 0.5 * problem.gravity * time) * time
            z = flights[2, j] + flights[5, j] * time
        cell[j, 0] = np.int64(math.floor(x / width))
        cell[j, 1] = np.int64(math.floor(y / width))
        cell[j, 2] = np.int64(math.floor(z / width))
        first[_cell_slot(cell[j, 0], cell[j, 1], cell[j, 2], size - 1)] += 1
    for slot in range(size):
        first[slot + 1] += first[slot]
    # Fill each slot from its end backwards; `first` is then the beginning of each slot.
    for j in range(live - 1, -1, -1):
        slot = _cell_slot(cell[j, 0], cell[j, 1], cell[j, 2], size - 1)
        first[slot] -= 1
        agenda.grid_member[first[slot]] = j
    clock.grid_step = now
    clock.grid_live = live


@kernel
def make_row(problem, state, agenda, i, now):
    """Build the row of particle i from all positions at step ``now``; False if it is full."""
    clock, rows = agenda.clock[0], agenda.rows
    # The memory of open contacts is kept for the new row.
    kept = 0
    for m in range(agenda.row_size[i]):
        if rows[i, m].stiffness != 0.0:
            rows[i, kept] = rows[i, m]
            kept += 1
    memory = rows[i, :kept].copy()

    steps = max(np.int64(REACH * problem.radius / (2.0 * clock.limit * problem.dt)), 1)
    while True:
        reach = 2.0 * problem.radius * (1.0 + SAFETY) + 2.0 * clock.limit * problem.dt * steps
        if state.tally[0].live < CROWD:
            size = _partners_of_all(problem, state, agenda, i, now, reach * reach)
        else:
            size = _partners_of_grid(problem, state, agenda, i, now, reach)
        if size <= SLOTS:
            break
        if steps == 1:
            return False
        steps //= 2  # type: ignore[operator]  # a number to numba
    first = NEVER
    for m in range(size):
        first = min(first, rows[i, m].next_check)
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
def raise_limit(problem, state, agenda, speed, now):
    """Set a speed limit above ``speed`` and build all rows again; False if one is full."""
    clock = agenda.clock[0]
    clock.limit = 1.2 * speed
    for k in range(clock.awake):
        if not make_row(problem, state, agenda, agenda.awake[k], now):
            return False
    return True
