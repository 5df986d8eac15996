"""Part 12: triangulated surfaces against the plate, closed forms and other codes."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from abradem.dem.surface import Surface, standing_surface
from abradem.verification import closed_forms as exact
from abradem.verification.checks import Check, checks_table
from abradem.verification.chutes import chute_checks, compare_chutes
from abradem.verification.scenes import Film, Scene, solid
from abradem.verification.surface_scenes import arc, belt, cut_plane, drum, extruded, room_corner

PART = 12
GRAVITY = 9.81

SOFT = Scene(particle=solid(1e7, 0.25, 2500.0)).with_interaction(
    restitution=0.3, static_friction=0.3
)
SOFT_STEP = 2e-5
"""A soft sphere and its time step, s: motions along a surface take seconds."""

REMOVAL_DEPTH = 10.0

CUTS = {
    "2 triangles": ((1, 1), False),
    "200 triangles": ((10, 10), False),
    "200 irregular triangles": ((10, 10), True),
}

ROUNDING = 1e-9
"""Tolerance of what differs by rounding alone, with a bounce that enlarges it a thousandfold."""

SLOW = 0.1
"""Speed of impacts on edges, m/s: the sphere hardly moves along the edge during the contact."""

ONE_STEP = 0.002
"""Tolerance if the start and the end of a contact are resolved to a step."""

FACETED = 0.02
"""Tolerance of motions on an arc or drum of facets of 2 deg, whose edges make the sphere bounce."""

LEVER_ARM = 2e-3
"""Tolerance of the torque on a bed: half of the mean overlap over the radius is less."""


class WallFilm(Film):
    """Film that also records the normal forces of the contacts with the surface."""

    def __init__(self, interval: float):
        super().__init__(interval)
        self.forces: list[np.ndarray] = []

    def record(self, time, problem, state):
        before = len(self.frames)
        super().record(time, problem, state)
        if len(self.frames) > before:
            walls = state.mesh.walls[: int(state.tally["live"][0])]
            self.forces.append(np.where(walls["plate_stiffness"] != 0.0, walls["plate_fn"], 0.0))


def filmed_on(scene: Scene, surface: Surface, releases, duration, step, every, gravity=GRAVITY):
    """Simulate given releases on a surface by conventional steps; return (result, film)."""
    from abradem.dem import simulate

    setup = scene.setup(
        surface=surface, removal_depth=REMOVAL_DEPTH, gravity=gravity, time_step=step,
        duration=duration, sample_interval=duration, stepping="synchronous",
    )  # fmt: skip
    film = WallFilm(every)
    result = simulate(scene.case(), setup, releases=releases, recorder=film)
    if result.status != "ok":
        raise RuntimeError(f"motion on a surface ended early: {result.status}")
    return result, film


def shower(scene: Scene, angle_deg: float, count: int = 40, seed: int = 1):
    """Return releases of spheres with spin above a plate of 0.2 x 0.2 m, far from each other."""
    rng = np.random.default_rng(seed)
    side = math.ceil(math.sqrt(count))
    spots = np.arange(side * side)[:count]
    along = (spots % side - 0.5 * (side - 1)) * 0.18 / side
    across = (spots // side - 0.5 * (side - 1)) * 0.18 / side
    height = 1.05 * scene.radius + rng.uniform(0.0, 2e-3, count)
    angle = math.radians(angle_deg)
    places = np.stack(
        [along * math.cos(angle) - height * math.sin(angle),
         along * math.sin(angle) + height * math.cos(angle), across], axis=1,
    )  # fmt: skip
    velocities = rng.uniform(-0.5, 0.5, (count, 3)) - [0.0, 2.0, 0.0]
    return np.zeros(count), places, velocities, rng.normal(0.0, 30.0, (count, 3))


def cut_plane_checks() -> list[Check]:
    """Return checks that a plane of triangles moves and wears as the plate does."""
    from abradem.dem import simulate

    scene, angle = Scene(radius=0.008), 30.0
    releases = shower(scene, angle)
    common = {"plate_length": 0.2, "plate_width": 0.2, "facet_size": 0.02, "duration": 0.01,
              "sample_interval": 0.01, "stepping": "synchronous"}  # fmt: skip
    case = scene.case(plate_angle=angle)
    film = Film(0.01)
    plate = simulate(case, scene.setup(**common), releases=releases, recorder=film)
    checks = []
    for words, (cells, irregular) in CUTS.items():
        surface = cut_plane(0.2, 0.2, angle, cells, irregular)
        track = WallFilm(0.001)
        found = simulate(
            case, scene.setup(surface=surface, **common), releases=releases, recorder=track
        )
        worst = max(
            np.abs(track.frames[-1][name] - film.frames[-1][name]).max()
            / np.abs(film.frames[-1][name]).max()
            for name in ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz")
        )
        wear = np.abs(found.worn[-1] / plate.worn[-1] - 1.0).max()
        cell_sum = np.abs(found.facet_wear_all.sum(axis=1) / found.worn[-1] - 1.0).max()
        most = max(np.count_nonzero(force, axis=1).max() for force in track.forces)
        checks += [
            Check(f"plane of {words} against the plate: motion", worst, 0.0, ROUNDING,
                  kind="absolute"),
            Check(f"plane of {words} against the plate: wear", wear, 0.0, ROUNDING,
                  kind="absolute"),
            Check(f"plane of {words}: sum over cells is the wear", cell_sum, 0.0, 1e-12,
                  kind="absolute"),
            Check(f"plane of {words}: most contacts of a particle at once", float(most), 1, 0.0),
            Check(f"plane of {words}: impacts", found.cell_sums_all[0].sum(), 40, 0.0),
        ]  # fmt: skip
    return checks


def seam_checks() -> list[Check]:
    """Return checks of a sphere that rolls across seams of a level plane."""
    surface = cut_plane(0.4, 0.06, 0.0, (20, 3), irregular=True)
    height = SOFT.radius * (1.0 + 1e-9)
    releases = ([0.0], [(-0.15, height, 0.0)], [(1.0, 0.0, 0.1)], [(10.0, 0.0, -100.0)])
    _, film = filmed_on(SOFT, surface, releases, 0.25, SOFT_STEP, SOFT_STEP * 10)
    late = np.array(film.time) > 0.1
    weight = SOFT.mass * GRAVITY
    force = np.array([force[0].sum() for force in film.forces])[late]
    speed = film.of("vx")[late]
    return [
        Check("rolling over seams: speed", speed[-1], 1.0, 1e-6, "m/s"),
        Check("rolling over seams: least normal force over the weight", force.min() / weight, 1.0,
              1e-3),
        Check("rolling over seams: largest normal force over the weight", force.max() / weight,
              1.0, 1e-3),
    ]  # fmt: skip


def edge_checks() -> list[Check]:
    """Return checks of impacts on edges and vertices without friction: v' = v - (1 + e) v_n n."""
    scene = Scene().with_interaction(restitution=0.5, static_friction=0.0)
    half = 0.5 / math.sqrt(2.0)
    level = cut_plane(0.1, 0.1, 0.0, (1, 1))
    roof = extruded([(-0.05, -0.03), (0.0, 0.0), (0.05, -0.03)], 0.1)
    upright = math.sqrt(0.75)
    pyramid = standing_surface(
        [(-0.05, -0.04, -0.05), (0.05, -0.04, -0.05), (0.05, -0.04, 0.05), (-0.05, -0.04, 0.05),
         (0.0, 0.0, 0.0)],
        [(0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)],
    )  # fmt: skip
    impacts = {
        "a free edge": (level, (0.05, 0.0, 0.0), (0.5, upright, 0.0)),
        "a corner": (level, (0.05, 0.0, 0.05), (half, upright, half)),
        "a ridge": (roof, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        "an apex": (pyramid, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    }
    checks = []
    for words, (surface, point, normal) in impacts.items():
        n = np.array(normal)
        velocity = np.array([0.0, -SLOW, 0.0])
        place = np.array(point) + n * scene.radius * (1.0 + 1e-6)
        _, film = filmed_on(
            scene, surface, ([0.0], [place], [velocity]), 6e-4, 4e-7, 4e-7, gravity=0.0
        )
        after = velocity - 1.5 * (velocity @ n) * n
        found = np.array([film.of(name)[-1] for name in ("vx", "vy", "vz")])
        most = max(np.count_nonzero(force) for force in film.forces)
        checks += [
            Check(f"impact on {words}: velocity, largest difference",
                  np.abs(found - after).max(), 0.0, ONE_STEP * SLOW, "m/s", "absolute"),
            Check(f"impact on {words}: most contacts at once", float(most), 1, 0.0),
        ]  # fmt: skip
    return checks


def corner_checks() -> list[Check]:
    """Return checks of a sphere at rest between two walls, and of a bounce off three."""
    checks = []
    scene = SOFT.with_interaction(restitution=1.0, static_friction=0.0)
    towards = np.array([-1.0, -0.8, -0.6])
    place = scene.radius - 0.005 * towards
    _, film = filmed_on(scene, room_corner(0.1), ([0.0], [place], [towards]), 0.015, SOFT_STEP,
                        SOFT_STEP, gravity=0.0)  # fmt: skip
    after = np.array([film.of(name)[-1] for name in ("vx", "vy", "vz")])
    most = max(np.count_nonzero(force) for force in film.forces)
    checks += [
        Check("bounce off three walls at once: velocity, largest difference",
              np.abs(after + towards).max(), 0.0, ONE_STEP, "m/s", "absolute"),
        Check("bounce off three walls at once: most contacts at once", float(most), 3, 0.0),
    ]  # fmt: skip
    for slope in (30.0, 45.0, 60.0):
        rise = math.tan(math.radians(slope))
        surface = extruded([(-0.05, 0.05 * rise), (0.0, 0.0), (0.05, 0.05 * rise)], 0.1, 3)
        scene = SOFT.with_interaction(restitution=0.1, static_friction=0.0)
        height = scene.radius / math.cos(math.radians(slope))
        releases = ([0.0], [(0.0, height * (1.0 + 1e-6), 0.001)], [(0.0, 0.0, 0.0)])
        _, film = filmed_on(scene, surface, releases, 0.3, SOFT_STEP, 0.01)
        force = np.sort(film.forces[-1][0])[::-1]
        expected = exact.corner_force(scene.mass, slope, GRAVITY)
        words = f"corner of two walls at {slope:g} deg"
        checks += [
            Check(f"{words}: force of the first", force[0], expected, 1e-4, "N"),
            Check(f"{words}: force of the second", force[1], expected, 1e-4, "N"),
            Check(f"{words}: contacts", float(np.count_nonzero(force)), 2, 0.0),
        ]
    return checks


def arc_checks() -> list[Check]:
    """Return checks of spheres that slide or roll down an arc of facets."""
    radius, begin = 0.2, 60.0
    surface = arc(radius, -70.0, 70.0, 70, 0.05)
    angle = math.radians(begin)
    reach = radius - SOFT.radius * (1.0 + 1e-9)
    releases = ([0.0], [(-reach * math.sin(angle), -reach * math.cos(angle), 0.0)], [(0, 0, 0)])
    checks = []
    for words, mu in (("slides", 0.0), ("rolls", 1.0)):
        scene = SOFT.with_interaction(restitution=1.0, static_friction=mu)
        _, film = filmed_on(scene, surface, releases, 0.35, SOFT_STEP, 5 * SOFT_STEP)
        lowest = int(np.argmax(film.of("x") >= 0.0))
        found = float(np.hypot(film.of("vx")[lowest], film.of("vy")[lowest]))
        form = exact.arc_speed(radius, scene.radius, begin, GRAVITY, words == "rolls")
        checks.append(Check(f"a sphere {words} down an arc: speed", found, form, FACETED, "m/s"))
    return checks


def belt_checks() -> list[Check]:
    """Return checks of a level belt that carries a sphere up to its speed."""
    speed, mu_r = 1.0, 0.05
    surface = belt(1.0, 0.1, 0.0, speed)
    releases = ([0.0], [(-0.3, SOFT.radius * (1.0 + 1e-9), 0.0)], [(0.0, 0.0, 0.0)])
    mu = SOFT.interaction.static_friction
    result, film = filmed_on(SOFT, surface, releases, 0.3, SOFT_STEP, 5 * SOFT_STEP)
    velocity, end = exact.belt_start(speed, mu, GRAVITY)
    slip = speed - film.of("vx") - SOFT.radius * film.of("wz")
    stop = int(np.argmax(np.abs(slip) < 1e-3 * speed))
    # Of the work 2/7 m V^2 of the belt one half is heat, the other moves the sphere.
    heat = exact.friction_work(SOFT.mass, speed, 0.0)
    lifted = SOFT.mass * GRAVITY * (SOFT.radius + REMOVAL_DEPTH)
    checks = [
        Check("belt: speed at which a sphere rolls", film.of("vx")[-1], velocity, 1e-4, "m/s"),
        Check("belt: time until it rolls", film.time[stop], end, 0.005, "s"),
        Check("belt: dissipated energy", result.energy["dissipated"], heat, 0.005, "J"),
        Check("belt: its work", result.energy["inserted"] - lifted, 2.0 * heat, 0.005, "J"),
    ]
    scene = SOFT.with_interaction(rolling_friction=mu_r)
    _, film = filmed_on(scene, surface, releases, 0.4, SOFT_STEP, 0.01)
    late = np.array(film.time) > 0.2
    found = float(np.polyfit(np.array(film.time)[late], film.of("vx")[late], 1)[0])
    form = exact.belt_acceleration(mu_r, GRAVITY)
    checks.append(Check("belt: acceleration of a rolling sphere", found, form, 2e-3, "m/s2"))
    return checks


def drum_checks() -> list[Check]:
    """Return checks of a sphere at rest in a drum that turns slowly."""
    radius, spin, mu_r = 0.1, 2.0, 0.2
    scene = SOFT.with_interaction(static_friction=0.6, rolling_friction=mu_r)
    surface = drum(radius, 180, 0.05, spin)
    form = exact.drum_angle_deg(mu_r)
    # Released anywhere else it would swing like a pendulum.
    reach = radius - scene.radius * (1.0 + 1e-9)
    place = reach * np.array([math.sin(math.radians(form)), -math.cos(math.radians(form)), 0.0])
    turn = (0.0, 0.0, spin * radius / scene.radius)
    releases = ([0.0], [place], [(0.0, 0.0, 0.0)], [turn])
    _, film = filmed_on(scene, surface, releases, 3.0, SOFT_STEP, 0.01)
    late = np.array(film.time) > 1.0
    angle = np.degrees(np.arctan2(film.of("x"), -film.of("y")))[late]
    turning = film.of("wz")[late].mean() * scene.radius
    return [
        Check("drum: angle at which a sphere rests, mean", float(angle.mean()), form, 0.3, "deg",
              "absolute"),
        Check("drum: speed of the sphere's surface", float(turning), spin * radius, FACETED,
              "m/s"),
    ]  # fmt: skip


class BedFilm(Film):
    """Film that also records the energy balance, see `abradem.dem.energy.energy_balance`."""

    def __init__(self, interval: float):
        super().__init__(interval)
        self.energy: list[dict[str, float]] = []

    def record(self, time, problem, state):
        from abradem.dem.energy import energy_balance

        before = len(self.frames)
        super().record(time, problem, state)
        if len(self.frames) > before:
            self.energy.append(energy_balance(problem, state))


def bed_in_drum_checks() -> list[Check]:
    """Return checks of a bed of particles in a closed drum that turns.

    The torque of the wall about the axis is the rate of the angular momentum of the particles and
    the torque of gravity on them, whatever they do to each other. So its work follows from their
    motion alone; in steady motion it is dissipated, see `closed_forms.drum_power`.

    Without rolling friction, whose torque opposes the spin of a particle itself and has no
    reaction on the wall.
    """
    from abradem.dem import simulate

    radius, width, spin = 0.1, 0.05, 3.0
    scene = Scene(particle=SOFT.particle, radius=0.008).with_interaction(
        restitution=0.3, static_friction=0.6, rolling_friction=0.0
    )
    steps = 2.05 * scene.radius * np.arange(-6, 7)
    places = np.array(
        [
            (x, y, z)
            for y in steps[steps < 0.1 * radius]
            for x in steps[np.hypot(steps, y) < radius - 1.05 * scene.radius]
            for z in steps[np.abs(steps) < 0.5 * width - scene.radius]
        ]
    )
    at_rest = np.zeros(places.shape)
    setup = scene.setup(
        surface=drum(radius, 60, width, spin, ends=True), pair_interaction=scene.interaction,
        removal_depth=REMOVAL_DEPTH, gravity=GRAVITY, time_step=0.8 * SOFT_STEP, duration=4.0,
        sample_interval=4.0, stepping="synchronous",
    )  # fmt: skip
    film = BedFilm(0.005)
    releases = (np.zeros(len(places)), places, at_rest, at_rest)
    result = simulate(scene.case(), setup, releases=releases, recorder=film)
    late = slice(int(np.searchsorted(film.time, 1.0)), None)
    time = np.array(film.time)[late]
    at = {
        name: np.array([frame[name] for frame in film.frames[late]])
        for name in ("x", "y", "vx", "vy", "vz", "wx", "wy", "wz")
    }
    mass, inertia = scene.mass, 0.4 * scene.mass * scene.radius**2
    about_axis = mass * (at["x"] * at["vy"] - at["y"] * at["vx"]) + inertia * at["wz"]
    moving = mass * (at["vx"] ** 2 + at["vy"] ** 2 + at["vz"] ** 2) + inertia * (
        at["wx"] ** 2 + at["wy"] ** 2 + at["wz"] ** 2
    )
    mechanical = (0.5 * moving + mass * GRAVITY * at["y"]).sum(axis=1)
    took = time[-1] - time[0]
    lever = np.trapezoid(at["x"].mean(axis=1), time) / took
    power = exact.drum_power(spin, len(places) * mass, GRAVITY, lever)
    needed = power * took + spin * (about_axis[-1] - about_axis[0]).sum()
    lost = needed - (mechanical[-1] - mechanical[0])
    energy = film.energy[late]
    work, heat = (energy[-1][name] - energy[0][name] for name in ("inserted", "dissipated"))
    turns = f"{len(places)} particles over {spin * took / (2.0 * math.pi):.2g} revolutions"
    return [
        Check("bed in a drum: work of the wall from torque of gravity and angular momentum",
              work, needed, LEVER_ARM, "J",
              note=f"{turns}; the lever arm of a contact is R, not R less the overlap"),
        Check("bed in a drum: dissipated energy, that work less the gain of mechanical energy",
              heat, lost, LEVER_ARM, "J",
              note=f"{turns}; omega M g x alone, of a steady bed, is {power * took:.3g} J"),
        Check("bed in a drum: particles lost", float(result.removed), 0.0, 0.0, kind="absolute"),
    ]  # fmt: skip


def motion_checks() -> list[Check]:
    """Return all checks but those against other codes."""
    return (
        cut_plane_checks() + seam_checks() + edge_checks() + corner_checks() + arc_checks()
        + belt_checks() + drum_checks() + bed_in_drum_checks()
    )  # fmt: skip


def study(chutes: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the tables of this part.

    Parameters
    ----------
    chutes : pandas.DataFrame
        The chute of other codes, see `chutes.compare_chutes`.
    """
    compared = compare_chutes(chutes)
    found = motion_checks() + chute_checks(compared)
    return {"checks": checks_table(PART, found), "chutes": compared}
