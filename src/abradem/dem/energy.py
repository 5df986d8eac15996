"""The balance of mechanical energy: inserted, removed, resident and dissipated energy."""

from __future__ import annotations

import math

from abradem.dem.cache import kernel
from abradem.dem.mesh_contact import walls_energy
from abradem.dem.plate import plate_distance
from abradem.dem.state import GONE, energy_of, kinetic_energy_of


@kernel(inline=True)
def _wall_energy(problem, particle, mesh, i):
    """Elastic energy of the contacts of particle i with walls: normal and tangential part, J."""
    if mesh is not None:
        return walls_energy(problem, mesh, i)
    distance = plate_distance(problem.plate, particle.x, particle.y, particle.z)[0]
    if distance >= problem.radius:
        return 0.0, 0.0
    squeezed = 0.4 * problem.plate_law.kn * (problem.radius - distance) ** 2.5
    return squeezed, particle.plate_energy


@kernel
def energy_present(problem, state):
    """Return the energy of all particles present, J: all of it, and that without the potential.

    The first is kinetic, potential and stored elastic energy, with heights from the removal level.
    A Hertz contact stores 2/5 k d^{5/2}, a tangential spring F^2 / (2 k_t).
    """
    tally, particles, pairs = state.tally[0], state.particles, state.pairs
    total, moving = 0.0, 0.0
    radius = problem.radius
    for i in range(tally.live):
        particle = particles[i]
        if particle.motion == GONE:
            continue
        total += energy_of(problem, particle, tally.step)
        moving += kinetic_energy_of(problem, particle, tally.step)
        squeezed, sheared = _wall_energy(problem, particle, state.mesh, i)
        total += squeezed
        total += sheared
        moving += squeezed + sheared
    for p in range(tally.pairs):
        pair = pairs[p]
        if pair.stiffness == 0.0:
            continue
        a, b = particles[pair.i], particles[pair.j]
        distance = math.sqrt((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2)
        squeezed = 0.4 * problem.pair_law.kn * max(2.0 * radius - distance, 0.0) ** 2.5
        total += squeezed
        # The spring is a force (incremental law) or a displacement.
        spring2 = pair.sx**2 + pair.sy**2 + pair.sz**2
        if problem.pair_law.incremental:
            stretched = 0.5 * spring2 / pair.stiffness
        else:
            stretched = 0.5 * spring2 * pair.stiffness
        total += stretched
        moving += squeezed + stretched
    return total, moving


def energy_balance(problem, state) -> dict:
    """Return ``inserted``, ``removed``, ``resident`` and ``dissipated`` energy, J.

    The dissipated energy is the remainder: inserted - removed - resident.
    """
    inserted = float(state.tally["energy_in"][0])
    removed = float(state.tally["energy_out"][0])
    resident = float(energy_present(problem, state)[0])
    return {
        "inserted": inserted,
        "removed": removed,
        "resident": resident,
        "dissipated": inserted - removed - resident,
    }
