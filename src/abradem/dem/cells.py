"""Grid of cells: the particles that can be near a particle.

Cells are as wide along x as along z, and as high as wide or higher. A particle may leave its cell
by the slack without being entered in another one. Cells are so wide that particles whose cells are
not adjacent still cannot touch. The grid repeats itself along each axis, so it has no border:
particles a period apart are merely examined for nothing.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.agenda import NEIGHBOURS
from abradem.dem.bounds import first_time_beyond
from abradem.dem.cache import kernel


@kernel(inline=True)
def enter_cell(agenda, i, cell):
    """Enter particle i, which is in no cell, in a cell."""
    plan = agenda.plans[i]
    first = agenda.cells[cell]
    plan.cell, plan.cell_previous = cell, -1
    agenda.cell_next[i] = first
    if first >= 0:
        agenda.plans[first].cell_previous = i
    agenda.cells[cell] = i


@kernel(inline=True)
def leave_cell(agenda, i):
    """Remove particle i from its cell."""
    plan = agenda.plans[i]
    behind = agenda.cell_next[i]
    if plan.cell_previous >= 0:
        agenda.cell_next[plan.cell_previous] = behind
    else:
        agenda.cells[plan.cell] = behind
    if behind >= 0:
        agenda.plans[behind].cell_previous = plan.cell_previous


@kernel(inline=True)
def cell_of(agenda, x, y, z):
    """Cell of a point."""
    clock = agenda.clock[0]
    bits = clock.bits
    mask = (1 << bits) - 1
    cx = np.int64(math.floor(x / clock.width)) & mask
    cy = np.int64(math.floor(y / clock.height)) & mask
    cz = np.int64(math.floor(z / clock.width)) & mask
    return (((cx << bits) | cz) << bits) | cy


@kernel(inline=True)
def change_cell(agenda, i, x, y, z):
    """Enter particle i in the cell of a point."""
    cell = cell_of(agenda, x, y, z)
    if cell != agenda.plans[i].cell:
        leave_cell(agenda, i)
        enter_cell(agenda, i, cell)


@kernel(inline=True)
def distance_to_leave(clock, x, y, z):
    """Distance that a particle at a point can move without leaving the cell by the slack, m."""
    along = min(_to_border(x, clock.width), _to_border(z, clock.width))
    return min(along, _to_border(y, clock.height)) + clock.slack


@kernel(inline=True)
def _to_border(x, size):
    low = x - math.floor(x / size) * size
    return min(low, size - low)


@kernel(inline=True)
def time_to_leave(clock, gravity, x, y, z, vx, vy, vz):
    """Time after which a flying particle has left the cell of its position by the slack, s."""
    slack, height = clock.slack, clock.height
    time_x = _time_along(x, vx, clock.width, slack)
    time_z = _time_along(z, vz, clock.width, slack)
    low = y - math.floor(y / height) * height
    time_y = first_time_beyond(low + slack, height - low + slack, vy, gravity)
    return min(time_x, min(time_y, time_z))


@kernel(inline=True)
def _time_along(x, v, width, slack):
    low = x - math.floor(x / width) * width
    ahead = width - low if v > 0.0 else low
    return (ahead + slack) / abs(v)


@kernel(inline=True)
def list_neighbours(agenda, cell, old):
    """List the particles of a cell and those around it; return their number.

    Unless ``old`` is negative, the cells in and around that cell are left out.
    """
    bits = agenda.clock[0].bits
    mask = (1 << bits) - 1
    cy, cz, cx = cell & mask, (cell >> bits) & mask, cell >> (2 * bits)
    # One less than the old cell along each axis.
    oy, oz, ox = (old & mask) - 1, ((old >> bits) & mask) - 1, (old >> (2 * bits)) - 1
    size = 0
    for dx in range(-1, 2):
        x = (cx + dx) & mask
        same_x = old >= 0 and ((x - ox) & mask) < 3
        for dz in range(-1, 2):
            z = (cz + dz) & mask
            same_xz = same_x and ((z - oz) & mask) < 3
            column = ((x << bits) | z) << bits
            for dy in range(-1, 2):
                y = (cy + dy) & mask
                if same_xz and ((y - oy) & mask) < 3:
                    continue
                j = np.int64(agenda.cells[column | y])
                while j >= 0:
                    agenda.lists[NEIGHBOURS, size] = j
                    size += 1
                    j = np.int64(agenda.cell_next[j])
    return size
