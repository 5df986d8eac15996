"""Pair list from a hashed grid of cells: work and memory grow linearly with the particles.

Cells are 2 R plus the skin wide. Their integer coordinates are hashed into a table and the
particles sorted by it (counting sort); cells that share a slot are told apart by coordinates.
"""

from __future__ import annotations

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.state import GONE, SKIN


@kernel(inline=True)
def cell_slot(cx, cy, cz, mask):
    """Slot of a cell in a table of ``mask + 1`` slots, a power of two."""
    return ((cx * 73856093) ^ (cy * 19349663) ^ (cz * 83492791)) & mask


@kernel(inline=True)
def _distance2(a, b):
    dx, dy, dz = a.x - b.x, a.y - b.y, a.z - b.z
    return dx * dx + dy * dy + dz * dz


@kernel
def rebuild_pairs(problem, state):
    """Make the list of all pairs nearer than 2 R plus the skin; False if it does not fit.

    Contacts that are open keep their memory.
    """
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    live = tally.live
    reach = (2.0 + SKIN) * problem.radius

    # Open contacts, chained by their first particle.
    kept_count = 0
    for p in range(tally.pairs):
        if pairs[p].stiffness != 0.0:
            kept_count += 1
    kept = np.empty(kept_count, pairs.dtype)
    chain = np.empty(kept_count, np.int64)
    head = np.full(live, -1, np.int64)
    c = 0
    for p in range(tally.pairs):
        if pairs[p].stiffness != 0.0:
            kept[c] = pairs[p]
            chain[c] = head[pairs[p].i]
            head[pairs[p].i] = c
            c += 1

    size = 16
    while size < 2 * live:
        size *= 2
    cell = np.empty((live, 3), np.int64)
    slot = np.empty(live, np.int64)
    first = np.zeros(size + 1, np.int64)
    for i in range(live):
        if particles[i].motion == GONE:
            slot[i] = -1
            continue
        cell[i, 0] = np.int64(np.floor(particles[i].x / reach))
        cell[i, 1] = np.int64(np.floor(particles[i].y / reach))
        cell[i, 2] = np.int64(np.floor(particles[i].z / reach))
        slot[i] = cell_slot(cell[i, 0], cell[i, 1], cell[i, 2], size - 1)
        first[slot[i] + 1] += 1
    for s in range(size):
        first[s + 1] += first[s]
    fill = first[:-1].copy()
    members = np.empty(first[size], np.int64)
    for i in range(live):
        if slot[i] >= 0:
            members[fill[slot[i]]] = i
            fill[slot[i]] += 1

    found = 0
    for i in range(live):
        if particles[i].motion == GONE:
            continue
        start = found
        for offset in range(27):
            cx = cell[i, 0] + offset // 9 - 1
            cy = cell[i, 1] + offset // 3 % 3 - 1
            cz = cell[i, 2] + offset % 3 - 1
            s = cell_slot(cx, cy, cz, size - 1)
            for m in range(first[s], first[s + 1]):
                j = members[m]
                if j <= i or cell[j, 0] != cx or cell[j, 1] != cy or cell[j, 2] != cz:
                    continue
                if _distance2(particles[i], particles[j]) >= reach * reach:
                    continue
                if found == pairs.size:
                    return False
                # In ascending order of the partner: forces are then summed in one order,
                # whatever the grid, and every stepping gives the same bits.
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
    tally.pairs = found
    tally.drift = 0.0
    return True


@kernel
def append_pairs(problem, state, new):
    """Add the pairs of a new particle with all before it; False if they do not fit."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    reach = (2.0 + SKIN) * problem.radius
    for j in range(new):
        if particles[j].motion == GONE:
            continue
        if _distance2(particles[j], particles[new]) < reach * reach:
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
    """Close the gaps that removed particles left; the pair list follows."""
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    target = np.empty(tally.live, np.int64)
    kept = 0
    for i in range(tally.live):
        target[i] = -1
        if particles[i].motion != GONE:
            target[i] = kept
            particles[kept] = particles[i]
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
