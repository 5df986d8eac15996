"""One step of one particle, used by all steppings.

Velocity Verlet (Swope, Andersen, Berens & Wilson 1982, J. Chem. Phys. 76:637): positions are
advanced with the half-step velocity, forces are evaluated at the new positions with the
predicted full-step velocity, and velocities are completed with the new force. Springs and wear
use the half-step velocity; wear uses the mean of the old and the new force.

A step is `move`, then `touch_plate` and `touch_pair` for all overlaps, then `finish`.
"""

from __future__ import annotations

import math

from abradem.dem.cache import kernel
from abradem.dem.contact import entry_share, normal_force, rotated, slowed, tangential_force
from abradem.dem.plate import facet_of, plate_distance
from abradem.dem.state import (
    FLYING,
    GONE,
    NOT_YET,
    ON_EDGE,
    ON_FACE,
    TOUCHING,
    WAKING,
    energy_of,
    fall_speed,
    flying_place,
    kinetic_energy_of,
)
from abradem.dem.vectors import cross, dot, fma, plus, scaled, split


@kernel(inline=True)
def fly_to(problem, particle, step):
    """Set the position of a flying particle to that at a lattice step."""
    particle.x, particle.y, particle.z = flying_place(problem, particle, step)


@kernel(inline=True)
def move(problem, particle, step):
    """Move a particle from ``step`` to the next one; return the displacement (dx, dy, dz).

    `finish` has already computed the spins of the step.
    """
    x, y, z = particle.x, particle.y, particle.z
    if particle.motion == FLYING:
        fly_to(problem, particle, step + 1)
    else:
        force = (particle.fx, particle.fy, particle.fz)
        half = plus((particle.vx, particle.vy, particle.vz), problem.kick, force)
        particle.half_vx, particle.half_vy, particle.half_vz = half
        particle.next_vx, particle.next_vy, particle.next_vz = plus(half, problem.kick, force)
        particle.x, particle.y, particle.z = plus((x, y, z), problem.dt, half)
        _clear_load(problem, particle)
    return particle.x - x, particle.y - y, particle.z - z


@kernel(inline=True)
def _turn(problem, particle):
    """Compute the spin at this step, half a step later, and the prediction for the next step.

    From one half step to the next, the contact torques are applied first, then the rolling
    resistance. Its square root and division are computed once, so the spin at this step is the
    mean of the two half-step spins.
    """
    turn = problem.turn
    half_x, half_y, half_z = particle.half_wx, particle.half_wy, particle.half_wz
    turned = plus((half_x, half_y, half_z), turn, (particle.mx, particle.my, particle.mz))
    x, y, z = slowed(turned, turn * particle.rolling)
    particle.wx, particle.wy, particle.wz = (
        0.5 * (half_x + x),
        0.5 * (half_y + y),
        0.5 * (half_z + z),
    )
    particle.half_wx, particle.half_wy, particle.half_wz = x, y, z
    particle.next_wx, particle.next_wy, particle.next_wz = (
        x + (x - particle.wx),
        y + (y - particle.wy),
        z + (z - particle.wz),
    )


@kernel(inline=True)
def _clear_load(problem, particle):
    particle.fx = 0.0
    particle.fy = -problem.mass * problem.gravity
    particle.fz = 0.0
    particle.mx = 0.0
    particle.my = 0.0
    particle.mz = 0.0
    particle.rolling = 0.0
    particle.in_contact = 0


@kernel(inline=True)
def wake(problem, particle, step):
    """Set the velocities of a flying particle that touches something in the step from ``step``."""
    if particle.motion != FLYING:
        return
    particle.next_vx = particle.half_vx = particle.vx
    particle.next_vz = particle.half_vz = particle.vz
    particle.next_vy = fall_speed(problem, particle, step + 1)
    particle.half_vy = fma(0.5 * problem.gravity, problem.dt, particle.next_vy)
    particle.next_wx = particle.half_wx = particle.wx
    particle.next_wy = particle.half_wy = particle.wy
    particle.next_wz = particle.half_wz = particle.wz
    particle.motion = WAKING
    _clear_load(problem, particle)


@kernel(inline=True)
def finish(problem, particle, step):
    """Complete the velocities of a particle in contact; without contact it flies from here on."""
    particle.vx, particle.vy, particle.vz = plus(
        (particle.half_vx, particle.half_vy, particle.half_vz),
        problem.kick,
        (particle.fx, particle.fy, particle.fz),
    )
    _turn(problem, particle)
    if particle.in_contact != 0:
        particle.motion = TOUCHING
    else:
        particle.motion = FLYING
        particle.anchor_step = step
        particle.anchor_x = particle.x
        particle.anchor_y = particle.y
        particle.anchor_z = particle.z


@kernel(inline=True)
def _point_velocity(v, w, arm, n):
    """v - arm (w x n): velocity of the surface point at ``-arm n`` from the centre."""
    return plus(v, -arm, cross(w, n))


@kernel(inline=True)
def _load(particle, fn, n, ft, arm):
    """Add a contact force that acts on a particle at ``-arm n`` from its centre."""
    particle.fx, particle.fy, particle.fz = plus(
        (particle.fx + ft[0], particle.fy + ft[1], particle.fz + ft[2]), fn, n
    )
    particle.mx, particle.my, particle.mz = plus(
        (particle.mx, particle.my, particle.mz), -arm, cross(n, ft)
    )
    particle.in_contact = 1


@kernel(inline=True)
def touch_plate(problem, particle, tally, facet_wear):
    """Contact of a particle with the plate: force, torque and wear of this step."""
    ix, iz, worn = press_plate(problem, particle, tally)
    if ix >= 0:
        wear_facet(facet_wear, ix, iz, worn)


@kernel(inline=True)
def wear_facet(facet_wear, ix, iz, worn):
    """Add the wear of a contact, by the three measures, to that of its facet, J."""
    facet_wear[0, ix, iz] += worn[0]
    facet_wear[1, ix, iz] += worn[1]
    facet_wear[2, ix, iz] += worn[2]


@kernel(inline=True)
def press_plate(problem, particle, tally):
    """Contact of a particle with the plate: return facet (ix, iz) and its wear, see `press`.

    Without contact ix is -1.
    """
    distance, n, along, across, on_face = plate_distance(
        problem.plate, particle.x, particle.y, particle.z
    )
    overlap = problem.radius - distance
    if overlap <= 0.0 and particle.plate_stiffness == 0.0:
        return -1, -1, (0.0, 0.0, 0.0)
    total, sliding, friction, _, _, _, _ = press(
        problem, particle, particle, tally, overlap, n, (0.0, 0.0, 0.0), on_face
    )
    ix, iz = facet_of(problem.plate, along, across)
    return ix, iz, (total, sliding, friction)


@kernel(inline=True)
def press(problem, particle, memory, tally, overlap, n, wall, on_face):
    """Contact of a particle with a wall: force, torque and wear of this step, and its memory.

    Wear is F_n ds for an Archard constant of 1 (Archard 1953, J. Appl. Phys. 24:981).

    Parameters
    ----------
    problem : Problem
    particle : record of PARTICLE
    memory : record
        With the fields of the contact with the plate in PARTICLE. In the step that ends a contact
        the overlap is not positive.
    tally : record of TALLY
    overlap : float
        m.
    n : tuple of float
        Unit normal towards the particle.
    wall : tuple of float
        Velocity of the wall at the contact, m/s.
    on_face : bool
        Whether the contact is on the face of the wall, not on an edge.

    Returns
    -------
    tuple of float
        Wear by the three measures, J; work that normal and tangential force exchange, as absolute
        values, J; normal impulse, N s; work that the wall does on the particle by its motion, J.
    """
    radius, dt, law = problem.radius, problem.dt, problem.plate_law
    touched = memory.plate_stiffness != 0.0
    wake(problem, particle, tally.step)
    half_speed, slide = split(
        _point_velocity(
            (
                particle.half_vx - wall[0],
                particle.half_vy - wall[1],
                particle.half_vz - wall[2],
            ),
            (particle.half_wx, particle.half_wy, particle.half_wz),
            radius,
            n,
        ),
        n,
    )
    fn_old = memory.plate_fn
    ft_old = (memory.plate_tx, memory.plate_ty, memory.plate_tz)
    fn, ft, spring = 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    stiffness, stored, slip_now = 0.0, 0.0, 0.0
    if overlap > 0.0:
        speed, slip = split(
            _point_velocity(
                (
                    particle.next_vx - wall[0],
                    particle.next_vy - wall[1],
                    particle.next_vz - wall[2],
                ),
                (particle.next_wx, particle.next_wy, particle.next_wz),
                radius,
                n,
            ),
            n,
        )
        share = 1.0
        if touched:
            spring = rotated((memory.plate_sx, memory.plate_sy, memory.plate_sz), n)
        else:
            share = entry_share(overlap, -half_speed * dt)
        du = scaled(slide, dt * share)
        fn, s, q = normal_force(law, overlap, speed)
        ft, spring, stiffness, stored, slip_now = tangential_force(
            law, fn, s, q, spring, memory.plate_stiffness, du, slip
        )
        _load(particle, fn, n, ft, radius)
        particle.rolling += law.rolling_friction * max(fn, 0.0) * radius
        tally.largest_overlap = max(tally.largest_overlap, overlap)
        if particle.first_contact == NOT_YET:
            particle.first_contact = ON_FACE if on_face else ON_EDGE
            tally.face += 1 if on_face else 0
            tally.edge += 0 if on_face else 1

    # Archard's F_n ds by the three wear measures.
    total = 0.5 * (max(fn_old, 0.0) + max(fn, 0.0)) * math.sqrt(dot(slide, slide)) * dt
    # Without friction every contact slides: the other two wear measures tend to the total.
    sliding, friction = total, total
    mu = law.static_friction
    work_old, work = -dot(ft_old, slide) * dt, -dot(ft, slide) * dt
    if mu > 0.0:
        per_mu = 1.0 / mu
        slipped = memory.plate_slip * max(work_old, 0.0) + slip_now * max(work, 0.0)
        sliding = 0.5 * slipped * per_mu
        friction = (0.5 * (work_old + work) - (stored - memory.plate_energy)) * per_mu
    tally.worn_total += total
    tally.worn_sliding += sliding
    tally.worn_friction += friction

    memory.plate_stiffness = stiffness
    memory.plate_sx, memory.plate_sy, memory.plate_sz = spring
    memory.plate_fn = fn
    memory.plate_tx, memory.plate_ty, memory.plate_tz = ft
    memory.plate_energy = stored
    memory.plate_slip = slip_now
    twice = plus((ft[0] + ft_old[0], ft[1] + ft_old[1], ft[2] + ft_old[2]), fn + fn_old, n)
    return (
        total,
        sliding,
        friction,
        0.5 * abs(fn_old + fn) * abs(half_speed) * dt,
        0.5 * abs(work_old + work),
        0.5 * (fn_old + fn) * dt,
        0.5 * dot(twice, wall) * dt,
    )


@kernel(inline=True)
def touch_pair(problem, pair, a, b, distance, n, tally):
    """Contact of particles a and b; n points from b to a."""
    law, dt = problem.pair_law, problem.dt
    wake(problem, a, tally.step)
    wake(problem, b, tally.step)
    overlap = 2.0 * problem.radius - distance
    arm = 0.5 * distance
    # The arms are equal, so the relative velocity depends on the sum of the spins.
    half_speed, slide = split(
        _point_velocity(
            (a.half_vx - b.half_vx, a.half_vy - b.half_vy, a.half_vz - b.half_vz),
            (a.half_wx + b.half_wx, a.half_wy + b.half_wy, a.half_wz + b.half_wz),
            arm,
            n,
        ),
        n,
    )
    speed, slip = split(
        _point_velocity(
            (a.next_vx - b.next_vx, a.next_vy - b.next_vy, a.next_vz - b.next_vz),
            (a.next_wx + b.next_wx, a.next_wy + b.next_wy, a.next_wz + b.next_wz),
            arm,
            n,
        ),
        n,
    )
    share, spring = 1.0, (0.0, 0.0, 0.0)
    if pair.stiffness != 0.0:
        spring = rotated((pair.sx, pair.sy, pair.sz), n)
    else:
        share = entry_share(overlap, -half_speed * dt)
    du = scaled(slide, dt * share)
    fn, s, q = normal_force(law, overlap, speed)
    ft, spring, stiffness, _, _ = tangential_force(law, fn, s, q, spring, pair.stiffness, du, slip)
    _load(a, fn, n, ft, arm)
    _load(b, fn, (-n[0], -n[1], -n[2]), (-ft[0], -ft[1], -ft[2]), arm)
    rolling = law.rolling_friction * max(fn, 0.0) * problem.radius
    a.rolling += rolling
    b.rolling += rolling
    pair.stiffness = stiffness
    pair.sx, pair.sy, pair.sz = spring
    pair.fn = fn
    pair.tx, pair.ty, pair.tz = ft
    tally.largest_overlap = max(tally.largest_overlap, overlap)


@kernel(inline=True)
def is_outside(box, particle):
    """Whether a particle is outside the box in which particles are kept."""
    if box is None:
        return False
    return (
        particle.x < box.low_x or particle.x > box.high_x
        or particle.y > box.high_y
        or particle.z < box.low_z or particle.z > box.high_z
    )  # fmt: skip


@kernel(inline=True)
def remove_if_fallen(problem, particle, tally):
    """Remove a particle that has fallen below the removal level or left the box."""
    # A particle with a position of nan stays, so that the guard finds it.
    if not (particle.y < problem.removal_height or is_outside(problem.box, particle)):
        return
    tally.energy_out += energy_of(problem, particle, tally.step)
    tally.kinetic_out += kinetic_energy_of(problem, particle, tally.step)
    if particle.first_contact == NOT_YET:
        tally.missed += 1
    particle.motion = GONE
    tally.removed += 1
    tally.gone += 1
