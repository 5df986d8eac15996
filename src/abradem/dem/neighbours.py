"""Pair list from a grid of cells: time and memory are linear in the number of particles.

The grid is a box around all particles. Its cells are 2 R plus the skin wide, or wider if the box
would otherwise have too many cells: a particle far away makes the search slower, not wrong.
Particles and their positions are sorted by cell (counting sort), so that the neighbours of a
particle are in nine contiguous pieces of memory.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dem.bounds import centre_distance2
from abradem.dem.cache import kernel
from abradem.dem.mesh import move_walls
from abradem.dem.state import GONE, SKIN

CELLS_PER_PARTICLE, FURTHER_CELLS = 8, 64
"""Largest number of grid cells: so many per particle, and so many more."""


@kernel(inline=True)
def _cells(extent, width):
    """Number of cells along an axis; one if it is not finite or does not fit an integer."""
    number = extent / width
    return np.int64(number) + 1 if 0.0 <= number < 2.0**62 else np.int64(1)


class Grid(NamedTuple):
    """Working memory for a new pair list: the grid of cells, and the contacts that are open.

    Attributes
    ----------
    box : ndarray, shape (2, 3)
        Corner of the grid and widths of a cell, m.
    counts : ndarray of int, shape (3,)
        Number of cells along each axis.
    first : ndarray of int, shape (cells + 1,)
        First entry of each cell in ``member`` and ``place``.
    cell : ndarray of int, shape (capacity,)
        Cell of each particle.
    member, place : ndarrays, shapes (capacity,) and (capacity, 3)
        Particles and their positions, m, sorted by cell.
    kept : ndarray of PAIR
        Open contacts.
    chain, head : ndarrays of int
        The next open contact with the same first particle, and the first one of each particle; -1:
        there is none.
    """

    box: np.ndarray
    counts: np.ndarray
    first: np.ndarray
    cell: np.ndarray
    member: np.ndarray
    place: np.ndarray
    kept: np.ndarray
    chain: np.ndarray
    head: np.ndarray


@kernel
def make_grid(capacity, pairs):
    """Return working memory for ``capacity`` particles and as many open contacts as ``pairs``."""
    return Grid(
        np.empty((2, 3)),
        np.empty(3, np.int64),
        np.empty(CELLS_PER_PARTICLE * capacity + FURTHER_CELLS + 1, np.int64),
        np.empty(capacity, np.int64),
        np.empty(capacity, np.int64),
        np.empty((capacity, 3)),
        np.empty(pairs.size, pairs.dtype),
        np.empty(pairs.size, np.int64),
        np.empty(capacity, np.int64),
    )


@kernel
def _lay_grid(tally, particles, grid, reach):
    """Lay a box of cells around all particles.

    Cells are at least ``reach`` wide. If there are too many, they are widened along the axis
    with the most cells.
    """
    low_x = low_y = low_z = np.inf
    high_x = high_y = high_z = -np.inf
    for i in range(tally.live):
        particle = particles[i]
        if particle.motion != GONE:
            low_x, high_x = min(low_x, particle.x), max(high_x, particle.x)
            low_y, high_y = min(low_y, particle.y), max(high_y, particle.y)
            low_z, high_z = min(low_z, particle.z), max(high_z, particle.z)
    wide_x = wide_y = wide_z = reach
    while True:
        nx = _cells(high_x - low_x, wide_x)
        ny = _cells(high_y - low_y, wide_y)
        nz = _cells(high_z - low_z, wide_z)
        if np.float64(nx) * ny * nz <= CELLS_PER_PARTICLE * tally.live + FURTHER_CELLS:
            break
        if nx >= ny and nx >= nz:
            wide_x *= 2.0
        elif ny >= nz:
            wide_y *= 2.0
        else:
            wide_z *= 2.0
    box, counts = grid.box, grid.counts
    box[0, 0], box[0, 1], box[0, 2] = low_x, low_y, low_z
    box[1, 0], box[1, 1], box[1, 2] = wide_x, wide_y, wide_z
    counts[0], counts[1], counts[2] = nx, ny, nz


@kernel
def rebuild_pairs(problem, state):
    """Build the list of all pairs closer than 2 R plus the skin; False if it does not fit.

    Open contacts keep their memory.
    """
    tally, pairs = state.tally[0], state.pairs
    grid = make_grid(tally.live, pairs[: tally.pairs])
    sort_into_cells(problem, state, grid)
    found = find_pairs(problem, state, grid, 0, tally.live, pairs, 0)
    if found < 0:
        return False
    tally.pairs = found
    tally.drift = 0.0
    return True


@kernel
def sort_into_cells(problem, state, grid):
    """Sort particles into the cells of a grid, and copy the open contacts of the pair list."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    live = tally.live

    # Open contacts, as one linked list for each first particle.
    grid.head[:live] = -1
    c = 0
    for p in range(tally.pairs):
        if pairs[p].stiffness != 0.0:
            grid.kept[c] = pairs[p]
            grid.chain[c] = grid.head[pairs[p].i]
            grid.head[pairs[p].i] = c
            c += 1

    _lay_grid(tally, particles, grid, (2.0 + SKIN) * problem.radius)
    low, width, first, cell = grid.box[0], grid.box[1], grid.first, grid.cell
    member, place = grid.member, grid.place
    nx, ny, nz = grid.counts[0], grid.counts[1], grid.counts[2]
    first[: nx * ny * nz + 1] = 0
    for i in range(live):
        particle = particles[i]
        if particle.motion == GONE:
            continue
        # Positions of nan get a cell too, so that the guard finds them.
        cx = min(max(np.int64((particle.x - low[0]) / width[0]), 0), nx - 1)
        cy = min(max(np.int64((particle.y - low[1]) / width[1]), 0), ny - 1)
        cz = min(max(np.int64((particle.z - low[2]) / width[2]), 0), nz - 1)
        cell[i] = (cx * ny + cy) * nz + cz
        first[cell[i]] += 1
    for c in range(nx * ny * nz):
        first[c + 1] += first[c]
    # Fill each cell from its end backwards; `first` is then the beginning of each cell.
    for i in range(live - 1, -1, -1):
        particle = particles[i]
        if particle.motion == GONE:
            continue
        first[cell[i]] -= 1
        at = first[cell[i]]
        member[at] = i
        place[at, 0], place[at, 1], place[at, 2] = particle.x, particle.y, particle.z


@kernel
def find_pairs(problem, state, grid, begin, end, pairs, found):
    """Write the pairs with first particles from ``begin`` to before ``end`` into ``pairs``.

    They follow the first ``found`` pairs. Return the number of pairs, or -1 if they do not fit.
    """
    particles = state.particles
    reach = (2.0 + SKIN) * problem.radius
    first, cell, member, places = grid.first, grid.cell, grid.member, grid.place
    kept, chain, head = grid.kept, grid.chain, grid.head
    nx, ny, nz = grid.counts[0], grid.counts[1], grid.counts[2]
    for i in range(begin, end):
        particle = particles[i]
        if particle.motion == GONE:
            continue
        start = found
        x, y, z = particle.x, particle.y, particle.z
        cz = cell[i] % nz
        cy = cell[i] // nz % ny
        cx = cell[i] // nz // ny
        for bx in range(max(cx - 1, 0), min(cx + 2, nx)):
            for by in range(max(cy - 1, 0), min(cy + 2, ny)):
                # Neighbouring cells along z are contiguous.
                row = (bx * ny + by) * nz
                for m in range(first[row + max(cz - 1, 0)], first[row + min(cz + 2, nz)]):
                    j = member[m]
                    if j <= i:
                        continue
                    dx, dy, dz = x - places[m, 0], y - places[m, 1], z - places[m, 2]
                    if not dx * dx + dy * dy + dz * dz < reach * reach:
                        continue
                    if found == pairs.size:
                        return -1
                    # Partners are in ascending order. Forces are then summed in the same order
                    # for every grid, and all steppings give bitwise equal results.
                    at = found
                    while at > start and pairs[at - 1].j > j:
                        pairs[at].j = pairs[at - 1].j
                        at -= 1
                    pairs[at].j = j
                    found += 1
        for p in range(start, found):
            pairs[p].i = i
            pairs[p].stiffness = 0.0
            k = head[i]
            while k >= 0:
                if kept[k].j == pairs[p].j:
                    pairs[p] = kept[k]
                    break
                k = chain[k]
    return found


@kernel
def append_pairs(problem, state, new):
    """Add the pairs of a new particle with all earlier ones; False if they do not fit."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    reach = (2.0 + SKIN) * problem.radius
    for j in range(new):
        if particles[j].motion == GONE:
            continue
        if centre_distance2(particles[j], particles[new]) < reach * reach:
            p = tally.pairs
            if p == pairs.size:
                return False
            pairs[p].i = j
            pairs[p].j = new
            pairs[p].stiffness = 0.0
            tally.pairs = p + 1
    return True


@kernel
def compact(state):
    """Close the gaps of removed particles in the arrays and update the pair list."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    target = np.empty(tally.live, np.int64)
    kept = 0
    for i in range(tally.live):
        target[i] = -1
        if particles[i].motion != GONE:
            target[i] = kept
            particles[kept] = particles[i]
            move_walls(state.mesh, i, kept)
            kept += 1
    kept_pairs = 0
    for p in range(tally.pairs):
        i, j = target[pairs[p].i], target[pairs[p].j]
        if i >= 0 and j >= 0:
            pairs[kept_pairs] = pairs[p]
            pairs[kept_pairs].i = i
            pairs[kept_pairs].j = j
            kept_pairs += 1
    tally.live = kept
    tally.pairs = kept_pairs
    tally.gone = 0
