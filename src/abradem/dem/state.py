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
from abradem.dem.mesh import Mesh, grown_mesh, make_mesh
from abradem.dem.model import Case, Setup
from abradem.dem.plate import Plate, make_plate
from abradem.dem.surface import Surface
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
STOP_NOT_FINITE, STOP_WEAR_NOT_FINITE, STOP_ENERGY_GAIN, NEEDS_TEAM = 5, 6, 7, 8
STOP_REASONS = {
    STOP_OVERLAP: "overlap above 20 % of the radius",
    STOP_RELEASE: "release into an overlap",
    STOP_CROWDED: "more neighbours than equal spheres can have",
    STOP_NOT_FINITE: "a position is not a finite number",
    STOP_WEAR_NOT_FINITE: "the wear is not a finite number",
}


class Box(NamedTuple):
    """Walls of the box in which particles are kept; its bottom is the removal level, m."""

    low_x: float
    high_x: float
    high_y: float
    low_z: float
    high_z: float


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
    # Random places that are tried for a particle, and whether one without a place is left out;
    # otherwise it waits for this number of steps.
    attempts: int
    skips: bool
    retry_steps: int
    seed: int
    # Factory patch: centre, unit vectors of its edges, half of their lengths, and velocity of the
    # particles released.
    patch_x: float
    patch_height: float
    patch_z: float
    patch_along: tuple[float, float, float]
    patch_across: tuple[float, float, float]
    patch_half_length: float
    patch_half_width: float
    release_velocity: tuple[float, float, float]
    # With a surface: the box outside which particles are removed. None: there is the level alone.
    box: Box | None


class Schedule(NamedTuple):
    """Given releases: lattice steps (n,), positions, velocities and spins (n, 3), SI."""

    step: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


def _fields(names: str, kind=np.float64):
    return [(name, kind) for name in names.split()]


LINE = 128
"""Two lines of the cache, which processors load together, bytes."""

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
    # To a whole number of lines of the cache, see `lined_up`.
    + _fields("unused_1 unused_2")
)

# One entry of the pair list, with the memory of its contact; stiffness 0: not touching. With
# unsigned indices numba need not check for negative ones, which count from the end.
PAIR = np.dtype(_fields("i j", np.uint32) + _fields("stiffness sx sy sz fn tx ty tz"))

# Clock, counters and sums.
TALLY = np.dtype(
    _fields("step live gone pairs placed skipped draws next_release", np.int64)
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
        Wear of each facet by wear measure, W = 1, J; shape (3, t, 1) with a surface.
    mesh : Mesh or None
        Surface in place of the plate.
    """

    tally: np.ndarray
    particles: np.ndarray
    pairs: np.ndarray
    facet_wear: np.ndarray
    mesh: Mesh | None


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
    if setup.geometry is not None and setup.surface is None:
        raise ValueError(
            "the set-up has a geometry but no surface; abradem.geometry.build.prepared makes it"
        )
    radius = case.particle_radius
    mass = sphere_mass(radius, case.particle_density)
    dt = setup.time_step
    if dt is None:
        dt = setup.time_step_fraction * case.particle.rayleigh_time(radius)
    pair = setup.pair_interaction or case.interaction
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
        removal_height=_removal_height(case, setup),
        scheduled=releases is not None,
        rate=rate,
        attempts=setup.attempts,
        skips=setup.unplaced == "skip",
        retry_steps=max(1, round(RETRY / dt)),
        seed=case.seed,
        **_patch(case, setup),
        box=_box(setup),
    )
    return problem, _schedule(releases, dt)


def lowest_point(case: Case, setup: Setup) -> float:
    """Return the height of the lowest point of the plate or the surface, m."""
    if setup.surface is not None:
        return float(setup.surface.vertices[setup.surface.triangles, 1].min())
    return -0.5 * setup.plate_length * abs(math.sin(math.radians(case.plate_angle)))


def _removal_height(case: Case, setup: Setup) -> float:
    if setup.removal_box is not None:
        return setup.removal_box[0][1]
    return lowest_point(case, setup) - setup.removal_depth


def _box(setup: Setup) -> Box | None:
    """Return the box of a set-up with a surface, by default without walls."""
    if setup.surface is None:
        return None
    if setup.removal_box is None:
        endless = np.inf
        return Box(-endless, endless, endless, -endless, endless)
    low, high = setup.removal_box
    return Box(low[0], high[0], high[1], low[2], high[2])


def _patch(case: Case, setup: Setup) -> dict:
    """Return the fields of `Problem` for the factory patch."""
    speed = case.particle_velocity_y
    feed = setup.feed
    if feed is not None:
        length, along = _length_and_direction(feed.along)
        width, across = _length_and_direction(feed.across)
        _, direction = _length_and_direction(feed.direction)
        return {
            "patch_x": float(feed.centre[0]),
            "patch_height": float(feed.centre[1]),
            "patch_z": float(feed.centre[2]),
            "patch_along": along,
            "patch_across": across,
            "patch_half_length": 0.5 * length,
            "patch_half_width": 0.5 * width,
            "release_velocity": tuple(abs(speed) * share for share in direction),
        }
    height, tilt = setup.patch_place(case.factory_angle)
    return {
        "patch_x": 0.0,
        "patch_height": height,
        "patch_z": 0.0,
        "patch_along": (math.cos(math.radians(tilt)), math.sin(math.radians(tilt)), 0.0),
        "patch_across": (0.0, 0.0, 1.0),
        "patch_half_length": 0.5 * setup.patch_length,
        "patch_half_width": 0.5 * setup.patch_width,
        "release_velocity": (0.0, speed, 0.0),
    }


def _length_and_direction(vector) -> tuple[float, tuple[float, float, float]]:
    """Return the length of a vector, and the unit vector along it; (1, 0, 0) without length."""
    x, y, z = (float(number) for number in vector)
    length = math.hypot(x, y, z)
    return length, (x / length, y / length, z / length) if length else (1.0, 0.0, 0.0)


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


def make_state(problem: Problem, capacity: int, surface: Surface | None = None) -> State:
    """Return an empty state with room for ``capacity`` particles.

    ``surface`` is that of the set-up from which the problem was made.
    """
    shape = (problem.plate.facets_x, problem.plate.facets_z)
    mesh = None
    if surface is not None:
        mesh = make_mesh(surface, problem.radius, capacity)
        shape = (len(mesh.normals), 1)
    return State(
        tally=np.zeros(1, TALLY),
        particles=lined_up(capacity, PARTICLE),
        pairs=np.zeros(capacity * PAIRS_PER_PARTICLE, PAIR),
        facet_wear=np.zeros((len(WORN), *shape)),
        mesh=mesh,
    )


def lined_up(shape: int | tuple[int, ...], kind) -> np.ndarray:
    """Return an array of zeros that begins at the beginning of a line of the cache."""
    size = math.prod(np.atleast_1d(shape).tolist()) * np.dtype(kind).itemsize
    room = np.zeros(size + LINE, np.uint8)
    start = -room.ctypes.data % LINE
    return room[start : start + size].view(kind).reshape(shape)


def grown(state: State, capacity: int) -> State:
    """Return the state with room for ``capacity`` particles."""
    particles = lined_up(capacity, PARTICLE)
    particles[: state.particles.size] = state.particles
    pairs = np.zeros(capacity * PAIRS_PER_PARTICLE, PAIR)
    pairs[: state.pairs.size] = state.pairs
    return state._replace(particles=particles, pairs=pairs, mesh=grown_mesh(state.mesh, capacity))


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
