"""Simulated experiments with one or two spheres and a known outcome.

Each function returns the simulated values; `closed_forms` contains the expected ones.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from abradem.elastic import hertz_duration
from abradem.verification.closed_forms import Hertz, Roll
from abradem.verification.scenes import Film, Scene, filmed

STEPS_PER_CONTACT = 500
"""Time steps per contact in the experiments with impacts."""

_TOUCHING = 1.0 + 1e-9
"""Height of a resting sphere above the plane, in radii, just without overlap."""


def head_on(scene: Scene, speed: float, duration: float, spins=None, offset: float = 0.0):
    """Simulate an impact of two spheres at +-``speed`` along x; return (film, time step).

    Parameters
    ----------
    scene : Scene
    speed : float
        Speed of each sphere, m/s.
    duration : float
        Approximate duration of the contact, s; it is divided into 500 steps.
    spins : array_like, shape (2, 3), optional
        Spins before the impact, rad/s.
    offset : float
        Half the distance between the lines of flight, m.
    """
    dt = duration / STEPS_PER_CONTACT
    apart = 2.0 * math.sqrt(scene.radius**2 - offset**2) + 2.5 * speed * dt
    releases = (
        [0.0, 0.0],
        [(-0.5 * apart, 1.0 - offset, 0.0), (0.5 * apart, 1.0 + offset, 0.0)],
        [(speed, 0.0, 0.0), (-speed, 0.0, 0.0)],
        np.zeros((2, 3)) if spins is None else spins,
    )
    time = 3.0 * duration
    setup = scene.empty_space(time_step=dt, duration=time, sample_interval=time)
    result, film = filmed(scene.case(), setup, releases)
    if result.status != "ok":
        raise RuntimeError(f"head-on impact ended early: {result.status}")
    return film, dt


def hertz_pair(scene: Scene, speed: float, duration: float) -> Hertz:
    """Return the largest force, the largest overlap and the duration of a head-on impact."""
    film, dt = head_on(scene, speed, duration)
    overlap = 2.0 * scene.radius - np.hypot(
        film.of("x", 1) - film.of("x", 0), film.of("y", 1) - film.of("y", 0)
    )
    return Hertz(
        max(film.pair_force), float(overlap.max()), dt * float(np.count_nonzero(overlap > 0.0))
    )


def _settled(scene: Scene, gravity: float) -> float:
    """Return the time in which the normal vibration of a sphere on the plane decays, s."""
    from abradem.dem.contact import effective_moduli

    load = scene.mass * gravity
    star = effective_moduli(scene.particle, scene.plate)[0]
    sag = (0.75 * load / (star * math.sqrt(scene.radius))) ** (2.0 / 3.0)
    return 30.0 * math.sqrt(sag / gravity)


def simulated_slide_to_roll(scene: Scene, speed: float, gravity: float = 9.81) -> Roll:
    """Simulate a sliding sphere without spin on a level plane until it rolls.

    Returns
    -------
    Roll
        Final velocity, time at which slip ends, and ``total`` until then.
    """
    mu = scene.interaction.static_friction
    expected = 2.0 * speed / (7.0 * mu * gravity)
    dt = _settled(scene, gravity) / 30.0 / 50.0
    duration = 1.5 * expected
    setup = scene.plane(gravity=gravity, time_step=dt, duration=duration, sample_interval=duration)
    release = ([0.0], [(0.0, _TOUCHING * scene.radius, 0.0)], [(speed, 0.0, 0.0)])
    result, film = filmed(scene.case(), setup, release, every=5.0 * dt)
    slip = film.of("vx") + scene.radius * film.of("wz")
    end = int(np.argmax(slip < 1e-3 * speed))
    # The slip velocity decreases linearly, so the time of its last thousandth is added.
    time = film.time[end] / (1.0 - 1e-3)
    return Roll(float(film.of("vx")[-1]), time, float(result.worn[-1, 0]))


def incline(scene: Scene, angle_deg: float, gravity: float = 9.81) -> float:
    """Release a sphere at rest on an inclined plane; return its acceleration downhill, m/s2."""
    settling = _settled(scene, gravity)
    dt = settling / 30.0 / 50.0
    duration = 5.0 * settling
    angle = math.radians(angle_deg)
    height = _TOUCHING * scene.radius
    release = ([0.0], [(-height * math.sin(angle), height * math.cos(angle), 0.0)], [(0, 0, 0)])
    setup = scene.plane(gravity=gravity, time_step=dt, duration=duration, sample_interval=duration)
    _, film = filmed(scene.case(plate_angle=angle_deg), setup, release, every=5.0 * dt)
    time = np.array(film.time)
    along = film.of("vx") * math.cos(angle) + film.of("vy") * math.sin(angle)
    late = time > settling
    slope = np.polyfit(time[late], -along[late], 1)[0]
    return float(slope)


def with_law(problem, pairs: bool = False, **factors: float):
    """Return the problem with scaled constants of the contact laws, which a study cannot choose.

    Parameters
    ----------
    problem : Problem
    pairs : bool
        Whether the law between particles is changed too.
    **factors : float
        Factors on constants of `abradem.dem.contact.Law`, such as ``ct=1.2``.
    """
    changed = {}
    for name in ("plate_law", "pair_law") if pairs else ("plate_law",):
        law = getattr(problem, name)
        changed[name] = law._replace(
            **{key: getattr(law, key) * factor for key, factor in factors.items()}
        )
    return problem._replace(**changed)


def impact_with(scene: Scene, speed: float, angle_deg: float, steps: int = 2000, **law: Any):
    """Simulate an impact with scaled constants of the contact law.

    Parameters
    ----------
    scene : Scene
    speed, angle_deg : float
        m/s, and degrees from the normal.
    steps : int
        Time steps per contact.
    **law : float
        Factors as in `with_law`.

    Returns
    -------
    dict
        normal_velocity, tangential_velocity (m/s), spin (rad/s, forward), tangential_impulse
        (N s), total, friction_work and wear (J), as in `plain_impact.plain_impact`.
    ndarray, shape (n, 3)
        Time since the start of the contact (s), normal and tangential force (N) at every step.
    """
    from abradem.dem.state import DONE, FLYING, make_problem, make_state
    from abradem.dem.synchronous import advance

    angle = math.radians(angle_deg)
    v_n, v_t = speed * math.cos(angle), speed * math.sin(angle)
    probe = make_problem(scene.case(), scene.plane(time_step=1.0))[0]
    dt = hertz_duration(with_law(probe, **law).plate_law.kn, probe.mass, v_n) / steps
    release = ([0.0], [(0.0, scene.radius + 0.5 * v_n * dt, 0.0)], [(v_t, -v_n, 0.0)])
    problem, schedule = make_problem(scene.case(), scene.plane(time_step=dt, gravity=0.0), release)
    problem = with_law(problem, **law)
    state = make_state(problem, 1)
    track, wear = [], 0.0
    for step in range(1, 50 * steps):
        if advance(problem, schedule, state, step) != DONE:
            raise RuntimeError("impact ended early")
        sphere = state.particles[0]
        overlap = max(scene.radius - float(sphere["y"]), 0.0)
        if overlap > 0.0:
            normal, tangential = float(sphere["plate_fn"]), float(sphere["plate_tx"])
            # The surfaces meet in the middle of the first step.
            track.append(((step - 0.5) * dt, normal, tangential))
            if sphere["plate_slip"] > 0.0:
                way = abs(float(sphere["vx"]) + scene.radius * float(sphere["wz"])) * dt
                wear += problem.plate_law.kn * overlap**1.5 * way
        elif track and sphere["motion"] == FLYING:
            break
    sphere, tally = state.particles[0], state.tally[0]
    return {
        "normal_velocity": float(sphere["vy"]),
        "tangential_velocity": float(sphere["vx"]),
        "spin": -float(sphere["wz"]),
        "tangential_impulse": scene.mass * (float(sphere["vx"]) - v_t),
        "friction_work": float(tally["worn_friction"]) * scene.interaction.static_friction,
        "total": float(tally["worn_total"]),
        "wear": wear,
    }, np.array(track)


def poured_with(case, setup, releases, **law: float) -> np.ndarray:
    """Return the velocities of particles from given releases at ``setup.duration``, m/s.

    All particles must be in flight then. The constants of all contacts are scaled as in `with_law`.
    """
    from abradem.dem.state import DONE, make_problem, make_state
    from abradem.dem.synchronous import advance

    problem, schedule = make_problem(case, setup, releases)
    problem = with_law(problem, pairs=True, **law)
    state = make_state(problem, len(releases[0]))
    if advance(problem, schedule, state, round(setup.duration / problem.dt)) != DONE:
        raise RuntimeError("jet ended early")
    film = Film(problem.dt)
    film.record(setup.duration, problem, state)
    frame = film.frames[-1]
    return np.column_stack([frame[name] for name in ("vx", "vy", "vz")])
