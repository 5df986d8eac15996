"""Grid of cells: the particles that can be near a particle.

Cells are as wide along x as along z, and as high as wide or higher. A particle may leave its cell
by the slack without being entered in another one. Cells are so wide that particles whose cells are
not adjacent still cannot touch. The grid repeats itself along each axis, so it has no border:
particles a period apart are merely examined for nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numba.core import cgutils, types
from numba.extending import intrinsic

from abradem.dem.agenda import BUCKET, NUMBER, SPILLED
from abradem.dem.bounds import first_time_beyond
from abradem.dem.cache import kernel

COUNT = BUCKET - 1
"""Place of the number of particles in the bucket of a cell, and the largest one."""


@intrinsic
def _copy_bucket(typing_context, near, size, cells, cell):
    """Copy the numbers of a cell to place ``size`` of a list in one move of 32 bytes.

    A loop over the particles of each cell would end at a place that processors cannot guess.
    """

    def codegen(context, builder, signature, arguments):
        target, size, source, cell = arguments
        near = context.make_array(signature.args[0])(context, builder, target)
        cells = context.make_array(signature.args[2])(context, builder, source)
        count = cell.type(BUCKET)
        place = builder.gep(near.data, [size])
        bucket = builder.gep(cells.data, [builder.mul(cell, count)])
        cgutils.raw_memcpy(builder, place, bucket, count, NUMBER.itemsize)
        return context.get_dummy_value()

    return types.void(near, types.int64, cells, types.int64), codegen


@kernel
def empty_cells(agenda):
    """Take all particles out of their cells."""
    agenda.cells[:, COUNT] = 0
    agenda.clock[0].spilled = 0


@kernel(inline=True)
def enter_cell(agenda, i, cell):
    """Enter particle i, which is in no cell, in a cell."""
    agenda.plans[i].cell = cell
    bucket, clock = agenda.cells[cell], agenda.clock[0]
    count = bucket[COUNT]
    if count < COUNT:
        bucket[count] = i
        bucket[COUNT] = count + 1
    else:
        agenda.lists[SPILLED, clock.spilled] = i
        clock.spilled += 1


@kernel(inline=True)
def leave_cell(agenda, i):
    """Remove particle i from its cell."""
    bucket, clock = agenda.cells[agenda.plans[i].cell], agenda.clock[0]
    count = bucket[COUNT]
    for k in range(count):
        if bucket[k] == i:
            bucket[k] = bucket[count - 1]
            bucket[COUNT] = count - 1
            return
    spilled = agenda.lists[SPILLED]
    k = 0
    while spilled[k] != i:
        k += 1
    clock.spilled -= 1
    spilled[k] = spilled[clock.spilled]


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
    """List the particles of a cell and those around it in `Agenda.near`; return their number.

    Unless ``old`` is negative, the cells in and around that cell are left out. Particles without
    room in their cell are listed in any case.
    """
    clock, cells, near = agenda.clock[0], agenda.cells, agenda.near
    bits = clock.bits
    mask = (1 << bits) - 1
    cy, cz, cx = cell & mask, (cell >> bits) & mask, cell >> (2 * bits)
    # One less than the old cell along each axis.
    oy, oz, ox = (old & mask) - 1, ((old >> bits) & mask) - 1, (old >> (2 * bits)) - 1
    # Where these hold, nothing is new in a column, or in a layer, that is also around the old cell.
    same_y = old >= 0 and cy == ((oy + 1) & mask)
    same_column = same_y and cz == ((oz + 1) & mask)
    size = np.int64(0)
    for dx in range(-1, 2):
        x = (cx + dx) & mask
        same_x = old >= 0 and ((x - ox) & mask) < 3
        if same_x and same_column:
            continue
        for dz in range(-1, 2):
            z = (cz + dz) & mask
            same_xz = same_x and ((z - oz) & mask) < 3
            if same_xz and same_y:
                continue
            column = ((x << bits) | z) << bits
            for dy in range(-1, 2):
                y = (cy + dy) & mask
                if same_xz and ((y - oy) & mask) < 3:
                    continue
                # What is copied beyond the particles of the cell is overwritten or not read.
                _copy_bucket(near, size, cells, column | y)
                size += cells[column | y, COUNT]
    for k in range(clock.spilled):
        near[size] = agenda.lists[SPILLED, k]
        size += 1
    return size
