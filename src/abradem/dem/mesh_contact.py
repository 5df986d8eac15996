"""Contacts of particles with a triangulated surface: memory, force and wear of each cell.

The law is that of the plate, `motion.press`. The memory of a contact belongs to the direction of
its normal, not to a triangle: so a spring survives the passage from one triangle to the next, and
the contacts of a particle in a corner have one each.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.borrow import borrowed, borrowed_mesh
from abradem.dem.cache import kernel
from abradem.dem.mesh import MOST_HITS, WALLS
from abradem.dem.mesh_search import (
    SMOOTH,
    find_contacts,
    surface_distance,
    turn_to,
)
from abradem.dem.motion import press
from abradem.dem.state import GONE
from abradem.dem.vectors import cross, dot, plus


@kernel
def touch_surface(problem, particles, tally, wear, mesh, step, chosen, count):
    """Contacts with the surface at lattice step ``step``: forces, torques and wear.

    Parameters
    ----------
    problem : Problem
    particles, tally, wear : ndarray
        Particles, tally and wear of the cells of the state.
    mesh : Mesh
        That of the state.
    step : int
    chosen : ndarray of int, or None
        Particles that can touch, the first ``count``; None means the first ``count`` of all.
    count : int
    """
    particles, tally, wear = borrowed(particles), borrowed(tally), borrowed(wear)
    mesh = borrowed_mesh(mesh)
    turn_to(problem, mesh, step)
    for k in range(count):
        i = np.int64(k)
        if chosen is not None:
            i = chosen[k]
        if particles[i].motion != GONE:
            _touch_mesh(problem, particles[i], tally[0], wear, mesh, i)


@kernel(inline=True)
def _touch_mesh(problem, particle, tally, wear, mesh, i):
    """Contacts of particle i with the surface."""
    count = find_contacts(mesh, i, particle.x, particle.y, particle.z, MOST_HITS, WALLS)
    opened = mesh.open_walls[i]
    if count == 0 and opened == 0:
        return
    hits, walls = mesh.hits, mesh.walls[i]
    # First the contacts that ended in this step, by memory, then the hits.
    first = 0
    if count != 1 or opened > 1 or not _goes_on(hits[0], walls[0], opened):
        first = -WALLS
        _match(mesh, i, count)
    for c in range(first, count):
        w, overlap, on_face = c + WALLS, 0.0, True
        if c < 0:
            if not opened & 1 << w or _is_taken(hits, count, w):
                continue
        else:
            hit = hits[c]
            w = hit.settled
            if w < 0:
                w = 0
                while mesh.open_walls[i] & 1 << w or _is_taken(hits, count, w):
                    w += 1
                hit.settled = w
                _clear(walls[w])
            walls[w].nx, walls[w].ny, walls[w].nz = hit.nx, hit.ny, hit.nz
            walls[w].triangle = hit.triangle
            overlap, on_face = problem.radius - hit.distance, hit.on_face == 1
        _press_on(problem, tally, wear, mesh, particle, walls[w], overlap, on_face)
        mesh.open_walls[i] &= ~(1 << w)
        if walls[w].plate_stiffness != 0.0:
            mesh.open_walls[i] |= 1 << w
    particle.plate_stiffness = 0.0
    for w in range(WALLS):
        if mesh.open_walls[i] & 1 << w:
            particle.plate_stiffness = max(particle.plate_stiffness, walls[w].plate_stiffness)


@kernel(inline=True)
def _goes_on(hit, wall, opened):
    """Whether the one hit is the one open contact, of the first memory; it is also if none is open.

    ``opened`` is 0 or 1, as in `Mesh.open_walls`.
    """
    hit.settled = opened - 1
    return opened == 0 or dot((hit.nx, hit.ny, hit.nz), (wall.nx, wall.ny, wall.nz)) >= SMOOTH


@kernel
def _match(mesh, i, count):
    """Have each hit continue the open contact of particle i with the nearest normal, or none."""
    hits, walls = mesh.hits, mesh.walls[i]
    for c in range(count):
        hit = hits[c]
        hit.settled = -1
        nearest = SMOOTH
        for w in range(WALLS):
            wall = walls[w]
            if mesh.open_walls[i] & 1 << w and not _is_taken(hits, c, w):
                likeness = dot((hit.nx, hit.ny, hit.nz), (wall.nx, wall.ny, wall.nz))
                if likeness >= nearest:
                    nearest = likeness
                    hit.settled = w


@kernel(inline=True)
def _is_taken(hits, count, w):
    """Whether one of the first hits continues the contact of memory w."""
    for c in range(count):
        if hits[c].settled == w:
            return True
    return False


@kernel(inline=True)
def _clear(wall):
    """Have a memory of no contact."""
    wall.plate_stiffness = 0.0
    wall.plate_sx = wall.plate_sy = wall.plate_sz = 0.0
    wall.plate_fn = 0.0
    wall.plate_tx = wall.plate_ty = wall.plate_tz = 0.0
    wall.plate_energy = 0.0
    wall.plate_slip = 0.0


@kernel
def clear_walls(mesh, i):
    """Have no contact of particle i with the surface remembered; nothing for the plate."""
    if mesh is not None:
        for w in range(WALLS):
            _clear(mesh.walls[i, w])
        mesh.open_walls[i] = 0
        for f in range(mesh.frames.size):
            mesh.spots[i, f].room2 = 0.0


@kernel(inline=True)
def _press_on(problem, tally, wear, mesh, particle, wall, overlap, on_face):
    """One contact with the surface: force, and wear and sums of its cell."""
    sums, cell = mesh.sums, wall.triangle
    n = (wall.nx, wall.ny, wall.nz)
    speed = wall_velocity(mesh, cell, particle, n, problem.radius - overlap)
    begins = wall.plate_stiffness == 0.0
    total, sliding, friction, normal_work, tangential_work, impulse, driven = press(
        problem, particle, wall, tally, overlap, n, speed, on_face
    )
    wall.overlap = overlap
    wear[0, cell, 0] += total
    wear[1, cell, 0] += sliding
    wear[2, cell, 0] += friction
    tally.energy_in += driven
    if begins:
        impact = (
            particle.half_vx - speed[0],
            particle.half_vy - speed[1],
            particle.half_vz - speed[2],
        )
        fast = math.sqrt(dot(impact, impact))
        sums[cell, 0] += 1.0
        sums[cell, 1] += fast
        if fast > 0.0:
            sums[cell, 2] += math.degrees(math.acos(min(abs(dot(impact, n)) / fast, 1.0)))
    sums[cell, 3] += normal_work
    sums[cell, 4] += tangential_work
    sums[cell, 5] += impulse


@kernel(inline=True)
def wall_velocity(mesh, cell, particle, n, distance):
    """Velocity of the surface at a contact, m/s: of a belt, or of a part that turns."""
    part = mesh.part[cell]
    frame = mesh.frames[mesh.frame_of[cell]]
    if frame.spin != 0.0:
        arm = plus(
            (particle.x - frame.px, particle.y - frame.py, particle.z - frame.pz), -distance, n
        )
        spin = (frame.spin * frame.dx, frame.spin * frame.dy, frame.spin * frame.dz)
        return cross(spin, arm)
    belt = (mesh.velocity[part, 0], mesh.velocity[part, 1], mesh.velocity[part, 2])
    return plus(belt, -dot(belt, n), n)


@kernel
def is_clear_of(problem, mesh, x, y, z, step):
    """Whether a particle at a point touches no wall at a lattice step."""
    turn_to(problem, mesh, step)
    return surface_distance(mesh, x, y, z) >= problem.radius


@kernel
def walls_energy(problem, mesh, i):
    """Elastic energy of the contacts of particle i: normal and tangential part, J."""
    squeezed, sheared = 0.0, 0.0
    for w in range(WALLS):
        wall = mesh.walls[i, w]
        if wall.plate_stiffness != 0.0:
            squeezed += 0.4 * problem.plate_law.kn * wall.overlap**2.5
            sheared += wall.plate_energy
    return squeezed, sheared
