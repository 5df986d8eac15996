"""Constants of a simulation, the state of all particles, and the functions that create them.

Free flight is never integrated. A particle that touches nothing is described by an *anchor*: the
state and lattice step of its release or of the end of its last contact. `flight` and `fall`
evaluate its parabola from there. All steppings use these functions, so that particles in flight
are bitwise equal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.contact import Law, make_law
from abradem.dem.model import Case, Setup
from abradem.dem.plate import Plate, make_plate
from abradem.dem.vectors import fma
from abradem.elastic import sphere_mass

SKIN = 0.3
"""Reach of the pair list beyond contact, in radii."""

PAIRS_PER_PARTICLE = 8
"""Pairs per particle in the pair list. Equal spheres have at most 12 neighbours, and each pair is
stored once."""

OVERLAP_STOP = 0.2
"""Overlap, as a share of the radius, above which a case is stopped."""

RETRY = 5e-4
"""Waiting time of a particle for which there was no free position on the patch, s."""

# Motion of a particle.
GONE, FLYING, WAKING, TOUCHING = 0, 1, 2, 3

# First contact of a particle with the plate.
NOT_YET, ON_FACE, ON_EDGE = 0, 1, 2

# Outcomes of `advance`.
DONE, NEEDS_ROOM, STOP_OVERLAP, STOP_RELEASE, STOP_CROWDED = 0, 1, 2, 3, 4
STOP_NOT_FINITE, STOP_WEAR_NOT_FINITE, STOP_ENERGY_GAIN = 5, 6, 7
STOP_REASONS = {
    STOP_OVERLAP: "overlap above 20 % of the radius",
    STOP_RELEASE: "release into an overlap",
    STOP_CROWDED: "more neighbours than equal spheres can have",
    STOP_NOT_FINITE: "a position is not a finite number",
    STOP_WEAR_NOT_FINITE: "the wear is not a finite number",
}


class Problem(NamedTuple):
    """Constants of a simulation, SI."""

    dt: float
    gravity: float
    radius: float
    mass: float
    inertia: float
    # dt / 2m and dt / I: change of velocity by a unit force in half a step, and change of spin by
    # a unit torque in a step.
    kick: float
    turn: float
    plate: Plate
    plate_law: Law
    pair_law: Law
    removal_height: float
    # Feed: from the factory (scheduled is False) or from given releases (True).
    scheduled: bool
    rate: float
    retry_steps: int
    seed: int
    patch_cos: float
    patch_sin: float
    patch_half_length: float
    patch_half_width: float
    patch_height: float
    release_speed: float


class Schedule(NamedTuple):
    """Given releases: lattice steps (n,), positions, velocities and spins (n, 3), SI."""

    step: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


def _fields(names: str, kind=np.float64):
    return [(name, kind) for name in names.split()]


# One particle. The fields that a step of a flying particle reads come first: two cache lines.
# Velocity and spin of a flying particle are those of its anchor.
PARTICLE = np.dtype(
    _fields("motion anchor_step", np.int64)
    + _fields("anchor_x anchor_y anchor_z vx vy vz x y z")
    + _fields("plate_stiffness")  # 0: not touching the plate
    + _fields("identity first_contact in_contact", np.int64)
    + _fields("wx wy wz")
    # Velocity and spin at half the step, and predicted for its end.
    + _fields("half_vx half_vy half_vz half_wx half_wy half_wz")
    + _fields("next_vx next_vy next_vz next_wx next_wy next_wz")
    # Load: force, torque and rolling resistance.
    + _fields("fx fy fz mx my mz rolling")
    # Memory of the contact with the plate.
    + _fields("plate_sx plate_sy plate_sz plate_fn plate_tx plate_ty plate_tz plate_energy")
    # Share of the tangential velocity that is slip.
    + _fields("plate_slip")
)

# One entry of the pair list, with the memory of its contact; stiffness 0: not touching. With
# unsigned indices numba need not check for negative ones, which count from the end.
PAIR = np.dtype(_fields("i j", np.uint32) + _fields("stiffness sx sy sz fn tx ty tz"))

# Clock, counters and sums.
TALLY = np.dtype(
    _fields("step live gone pairs placed draws next_release", np.int64)
    + _fields("face edge missed removed", np.int64)
    # Largest possible approach of any two particles since the pair list was built, m.
    + _fields("drift")
    # Largest overlap so far, m.
    + _fields("largest_overlap")
    # Mechanical energy of all particles released and removed, and the kinetic part of it, J.
    + _fields("energy_in energy_out kinetic_in kinetic_out")
    # Wear of the whole plate for W = 1, J.
    + _fields("worn_total worn_sliding worn_friction")
)


WORN = ("worn_total", "worn_sliding", "worn_friction")
"""Fields of `TALLY` for the wear measures, in the order of `abradem.quantities.WEAR_MEASURES`."""


class State(NamedTuple):
    """State of a simulation.

    All values are in a few arrays of records. A record is passed to a kernel as a pointer, while
    every array passed to it costs reference counting.

    Attributes
    ----------
    tally : ndarray of TALLY, shape (1,)
    particles : ndarray of PARTICLE, shape (capacity,)
    pairs : ndarray of PAIR, shape (capacity * PAIRS_PER_PARTICLE,)
    facet_wear : ndarray, shape (3, nx, nz)
        Wear of each facet by wear measure, W = 1, J.
    """

    tally: np.ndarray
    particles: np.ndarray
    pairs: np.ndarray
    facet_wear: np.ndarray


def make_problem(case: Case, setup: Setup, releases=None) -> tuple[Problem, Schedule]:
    """Return the constants of a simulation and the schedule of given releases.

    Parameters
    ----------
    case : Case
    setup : Setup
    releases : tuple of array_like, optional
        Times (n,) in s, ascending, positions (n, 3) in m, velocities (n, 3) in m/s and,
        optionally, spins (n, 3) in rad/s of the released particles; they replace the factory.

    Returns
    -------
    problem : Problem
    schedule : Schedule
        Empty without ``releases``.

    Raises
    ------
    ValueError
        If the releases have other shapes, are not finite or do not ascend in time from 0 on.
    """
    radius = case.particle_radius
    mass = sphere_mass(radius, case.particle_density)
    dt = setup.time_step
    if dt is None:
        dt = setup.time_step_fraction * case.particle.rayleigh_time(radius)
    pair = setup.pair_interaction or case.interaction
    angle = math.radians(case.plate_angle)
    lowest = -0.5 * setup.plate_length * abs(math.sin(angle))
    patch_height, tilt = setup.patch_place(case.factory_angle)
    rate = setup.number_rate if setup.number_rate is not None else setup.mass_rate / mass
    problem = Problem(
        dt=dt,
        gravity=setup.gravity,
        radius=radius,
        mass=mass,
        inertia=0.4 * mass * radius**2,
        kick=0.5 * dt / mass,
        turn=dt / (0.4 * mass * radius**2),
        plate=make_plate(setup.plate_length, setup.plate_width, case.plate_angle, setup.facets),
        plate_law=make_law(
            case.particle, case.plate, case.interaction, setup.contact, radius, mass
        ),
        pair_law=make_law(
            case.particle, case.particle, pair, setup.contact, 0.5 * radius, 0.5 * mass
        ),
        removal_height=lowest - setup.removal_depth,
        scheduled=releases is not None,
        rate=rate,
        retry_steps=max(1, round(RETRY / dt)),
        seed=case.seed,
        patch_cos=math.cos(math.radians(tilt)),
        patch_sin=math.sin(math.radians(tilt)),
        patch_half_length=0.5 * setup.patch_length,
        patch_half_width=0.5 * setup.patch_width,
        patch_height=patch_height,
        release_speed=case.particle_velocity_y,
    )
    return problem, _schedule(releases, dt)


def _schedule(releases, dt):
    if releases is None:
        return Schedule(np.zeros(0, np.int64), *(np.zeros((0, 3)) for _ in range(3)))
    times = np.asarray(releases[0], dtype=float)
    vectors = [np.ascontiguousarray(v, dtype=float) for v in releases[1:]]
    if len(vectors) == 2:
        vectors.append(np.zeros((times.size, 3)))
    if len(vectors) != 3 or any(v.shape != (times.size, 3) for v in vectors):
        raise ValueError(
            "releases must be (times (n,), positions (n, 3), velocities (n, 3)[, spins (n, 3)])"
        )
    if not all(np.isfinite(v).all() for v in (times, *vectors)):
        raise ValueError("releases must be finite numbers")
    if np.any(np.diff(times) < 0) or np.any(times < 0):
        raise ValueError("release times must be ascending and not negative")
    return Schedule(np.rint(times / dt).astype(np.int64), *vectors)


def make_state(problem: Problem, capacity: int) -> State:
    """Return an empty state with room for ``capacity`` particles."""
    return State(
        tally=np.zeros(1, TALLY),
        particles=np.zeros(capacity, PARTICLE),
        pairs=np.zeros(capacity * PAIRS_PER_PARTICLE, PAIR),
        facet_wear=np.zeros((len(WORN), problem.plate.facets_x, problem.plate.facets_z)),
    )


def grown(state: State, capacity: int) -> State:
    """Return the state with room for ``capacity`` particles."""
    particles = np.zeros(capacity, PARTICLE)
    particles[: state.particles.size] = state.particles
    pairs = np.zeros(capacity * PAIRS_PER_PARTICLE, PAIR)
    pairs[: state.pairs.size] = state.pairs
    return state._replace(particles=particles, pairs=pairs)


@kernel(inline=True)
def flight(start, velocity, time):
    """Position x0 + v0 t along a horizontal axis, m."""
    return fma(velocity, time, start)


@kernel(inline=True)
def fall(start, velocity, gravity, time):
    """Height y0 + v0 t - g t^2 / 2, m."""
    return fma(fma(-0.5 * gravity, time, velocity), time, start)


@kernel(inline=True)
def flying_place(problem, particle, step):
    """Position (x, y, z) of a flying particle at a lattice step, m."""
    time = problem.dt * (step - particle.anchor_step)
    return (
        flight(particle.anchor_x, particle.vx, time),
        fall(particle.anchor_y, particle.vy, problem.gravity, time),
        flight(particle.anchor_z, particle.vz, time),
    )


@kernel(inline=True)
def fall_speed(problem, particle, step):
    """Vertical velocity of a flying particle at a lattice step, m/s."""
    return fma(-problem.gravity, problem.dt * (step - particle.anchor_step), particle.vy)


@kernel(inline=True)
def kinetic_energy_of(problem, particle, step):
    """Kinetic energy of a particle, J."""
    vy = fall_speed(problem, particle, step) if particle.motion == FLYING else particle.vy
    speed2 = particle.vx**2 + vy**2 + particle.vz**2
    spin2 = particle.wx**2 + particle.wy**2 + particle.wz**2
    return 0.5 * problem.mass * speed2 + 0.5 * problem.inertia * spin2


@kernel(inline=True)
def energy_of(problem, particle, step):
    """Kinetic energy of a particle plus its potential energy above the removal level, J."""
    height = particle.y - problem.removal_height
    return kinetic_energy_of(problem, particle, step) + problem.mass * problem.gravity * height
