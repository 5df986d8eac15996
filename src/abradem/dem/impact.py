"""The impact of a single sphere on a plane, computed with the time step of the simulations."""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.cache import kernel
from abradem.dem.contact import make_law
from abradem.dem.model import Case, ContactModel, Impact, Interaction, Material, Setup
from abradem.dem.state import DONE, FLYING, make_problem, make_state
from abradem.dem.synchronous import advance
from abradem.elastic import hertz_duration, sphere_mass

CONVERGED_STEPS = 500
"""Steps per contact if no time step is given."""

SMALL_FRICTION = 0.05
"""Share of ``total`` below which ``friction`` is not large enough to be the base of its bias."""

_PHASES = (np.arange(16) + 0.5) / 16
_PLANE = 1e3
_MOST_STEPS = 10_000_000


# Outcome of an impact, SI; ``worn_friction`` is for a friction coefficient of 1.
OUTCOME = np.dtype(
    [("ended", np.bool_)]
    + [
        (name, np.float64)
        for name in (
            "contact_time", "overlap", "force", "vx", "vy", "wx", "wy", "wz",
            "worn_total", "worn_sliding", "worn_friction",
        )
    ]
)  # fmt: skip


@kernel
def _impact(problem, schedule, state, outcome):
    """Step the one particle of a schedule until its contact with the plate is over."""
    contact_time, largest_overlap, largest_force = 0.0, 0.0, 0.0
    before = -1.0
    tally, sphere = state.tally[0], state.particles[0]
    for _ in range(_MOST_STEPS):
        if advance(problem, schedule, state, tally.step + 1) != DONE:
            break
        overlap = problem.radius - sphere.y
        force = sphere.plate_fn
        largest_overlap = max(largest_overlap, overlap)
        largest_force = max(largest_force, force)
        if overlap > 0.0:
            # Only the part with overlap of the first and the last step counts.
            contact_time += problem.dt * (overlap / (overlap - before) if before < 0.0 else 1.0)
        elif before > 0.0:
            contact_time += problem.dt * before / (before - overlap)
        before = overlap
        if contact_time > 0.0 and sphere.motion == FLYING:
            outcome.ended = True
            break
    outcome.contact_time = contact_time
    outcome.overlap = largest_overlap
    outcome.force = largest_force
    outcome.vx, outcome.vy = sphere.vx, sphere.vy
    outcome.wx, outcome.wy, outcome.wz = sphere.wx, sphere.wy, sphere.wz
    outcome.worn_total = tally.worn_total
    outcome.worn_sliding = tally.worn_sliding
    outcome.worn_friction = tally.worn_friction


@kernel
def _impacts_from(problem, schedule, state, blank, heights, outcomes):
    """Impacts of the one particle of a schedule from several heights, each in a blank state.

    One call for all: a call from Python costs more than an impact.
    """
    for k in range(heights.size):
        state.tally[0] = blank.tally[0]
        state.particles[0] = blank.particles[0]
        schedule.position[0, 1] = heights[k]
        _impact(problem, schedule, state, outcomes[k])


def single_impact(
    particle: Material,
    radius: float,
    plate: Material,
    interaction: Interaction,
    speed: float,
    angle_deg: float,
    time_step: float | None = None,
    spin=(0.0, 0.0, 0.0),
    gravity: float = 0.0,
    contact: ContactModel | None = None,
    phase: float = 0.5,
) -> Impact:
    """Simulate the impact of a sphere on a plane and return its outcome.

    Parameters
    ----------
    particle, plate : Material
    radius : float
        m.
    interaction : Interaction
    speed : float
        m/s.
    angle_deg : float
        Angle between the velocity and the normal of the plane, in [0, 90), degrees.
    time_step : float, optional
        s; the default is 1/500 of the duration of the elastic impact (Hertz 1882).
    spin : tuple of float
        Spin before the impact, rad/s. The normal of the plane is +y and the sphere moves
        towards +x.
    gravity : float
        Acceleration of gravity along -y, m/s2.
    contact : ContactModel, optional
    phase : float
        Fraction of the step that remains when the surfaces meet, in [0, 1).

    Returns
    -------
    Impact

    Raises
    ------
    ValueError
        If an argument is out of range, or if the sphere does not leave the plane again.
    """
    if not 0.0 <= phase < 1.0:
        raise ValueError(f"phase = {phase!r} is outside [0, 1)")
    time_step, (found,) = _impacts(
        particle, radius, plate, interaction, speed, angle_deg, time_step, spin, gravity, contact,
        (phase,),
    )  # fmt: skip
    return Impact(
        normal_velocity=float(found["vy"]),
        tangential_velocity=float(found["vx"]),
        spin=np.array([found["wx"], found["wy"], found["wz"]]),
        contact_time=float(found["contact_time"]),
        max_overlap=float(found["overlap"]),
        max_normal_force=float(found["force"]),
        total=float(found["worn_total"]),
        sliding=float(found["worn_sliding"]),
        friction_work=float(found["worn_friction"]) * interaction.static_friction,
        time_step=time_step,
    )


def _impacts(
    particle,
    radius,
    plate,
    interaction,
    speed,
    angle_deg,
    time_step,
    spin,
    gravity,
    contact,
    phases,
) -> tuple[float, np.ndarray]:
    """Simulate impacts that differ in their phase alone; return time step and outcomes.

    The arguments are those of `single_impact`, the outcomes an array of `OUTCOME`.
    """
    if not 0.0 <= angle_deg < 90.0:
        raise ValueError(f"angle_deg = {angle_deg!r} is outside [0, 90)")
    for name, value in (("radius", radius), ("speed", speed)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be finite and positive, got {value!r}")
    angle = math.radians(angle_deg)
    approach = speed * math.cos(angle)
    contact = ContactModel() if contact is None else contact
    case = Case(
        particle.shear_modulus,
        particle.poisson_ratio,
        particle.density,
        plate.shear_modulus,
        plate.poisson_ratio,
        plate.density,
        interaction.restitution,
        interaction.rolling_friction,
        interaction.static_friction,
        archard_constant=1.0,
        plate_angle=0.0,
        factory_angle=0.0,
        particle_radius=radius,
        particle_velocity_y=-approach,
    )

    if time_step is None:
        mass = sphere_mass(radius, case.particle_density)
        law = make_law(case.particle, case.plate, case.interaction, contact, radius, mass)
        time_step = hertz_duration(law.kn, mass, approach) / CONVERGED_STEPS
    elif not (math.isfinite(time_step) and time_step > 0.0):
        raise ValueError(f"time_step must be finite and positive, got {time_step!r}")
    setup = Setup(
        plate_length=2 * _PLANE,
        plate_width=2 * _PLANE,
        facet_size=2 * _PLANE,
        removal_depth=_PLANE,
        gravity=gravity,
        contact=contact,
        time_step=time_step,
    )
    velocity = (speed * math.sin(angle), -approach, 0.0)
    releases = ([0.0], [(0.0, radius, 0.0)], [velocity], [tuple(spin)])
    problem, schedule = make_problem(case, setup, releases)
    # The surfaces meet after the fraction 1 - phase of the first step.
    heights = radius + (1.0 - np.array(phases)) * approach * time_step
    outcomes = np.zeros(heights.size, OUTCOME)
    _impacts_from(
        problem, schedule, make_state(problem, 1), make_state(problem, 1), heights, outcomes
    )
    if not outcomes["ended"].all():
        raise ValueError("the sphere did not leave the plane again")
    return time_step, outcomes


def step_bias(
    case: Case, contact: ContactModel, time_step: float, speed: float, angle_deg: float
) -> dict[str, float]:
    """Return the bias of the wear of a particle's impact on the plate that a time step causes.

    The reference has 500 steps per contact. The wear at ``time_step`` is averaged over the moment
    within the step at which the surfaces meet.

    Parameters
    ----------
    case : Case
    contact : ContactModel
    time_step : float
        s.
    speed : float
        m/s.
    angle_deg : float
        Angle between velocity and normal, degrees; not 0, where nothing is worn.

    Returns
    -------
    dict of str to float
        Bias of ``total`` and, with friction, of ``friction`` as a share of the measure; that of
        ``friction`` as a share of at least `SMALL_FRICTION` of ``total``.

    Raises
    ------
    ValueError
        If the particle overlaps the plate by more than 20 % of its radius.
    """

    def impacts(step, phases):
        return _impacts(
            case.particle, case.particle_radius, case.plate, case.interaction, speed, angle_deg,
            step, (0.0, 0.0, 0.0), 0.0, contact, phases,
        )[1]  # fmt: skip

    fine, coarse = impacts(None, (0.5,)), impacts(time_step, _PHASES)
    total = float(fine["worn_total"][0])
    bias = {"total": float(np.mean(coarse["worn_total"])) / total - 1.0}
    if case.static_friction > 0.0:
        # Of the friction coefficient, by which all are divided, the bias is independent.
        friction = float(fine["worn_friction"][0])
        error = float(np.mean(coarse["worn_friction"])) - friction
        bias["friction"] = error / max(friction, SMALL_FRICTION * total)
    return bias
