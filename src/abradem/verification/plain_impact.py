"""Independent integration of an impact on a plane: no code of the engine, very small steps.

It implements the documented law and the choices in which other codes differ. The difference that
remains with the choices of the other code is not explained by them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from abradem.dem.contact import effective_moduli
from abradem.dem.damping import exact_beta, nominal_beta
from abradem.verification import closed_forms as exact
from abradem.verification.scenes import Scene

STEPS = 10_000
"""Steps in an elastic contact with the same approach speed. The integration is of first order, with
errors of a few 1e-4."""


@dataclass(frozen=True)
class Choices:
    """Choices in which codes differ; the defaults are those of this engine.

    Parameters
    ----------
    spring_keeps : {"cap", "cap less damping"}
        Spring force after Coulomb's law has limited the sum of spring and damping force.
    capped_in_stick : bool
        Whether the spring is limited to the cap while spring plus damping is below it.
    weakens : bool
        Whether the spring force decreases with the stiffness while the contact unloads.
    rolling_load : {"total", "elastic"}
        Part of F_n in the rolling resistance.
    arm : float
        The lever arm is the radius minus this share of the overlap.
    wall_radius : float
        Effective radius at a wall over the radius of the sphere.
    corrected_tangential : bool
        Whether the tangential damping uses the beta that is corrected for the clip.
    """

    spring_keeps: str = "cap"
    capped_in_stick: bool = True
    weakens: bool = True
    rolling_load: str = "total"
    arm: float = 0.0
    wall_radius: float = 1.0
    corrected_tangential: bool = False


def plain_impact(
    scene: Scene, speed: float, angle_deg: float, choices: Choices, steps: int = STEPS
) -> tuple[dict, np.ndarray]:
    """Integrate an impact of a sphere without spin.

    Parameters
    ----------
    scene : Scene
        Its contact model defines the law; ``choices`` are not part of a contact model.
    speed, angle_deg : float
        m/s, and degrees from the normal.
    choices : Choices
    steps : int
        Time steps in an elastic contact.

    Returns
    -------
    dict
        normal_velocity, tangential_velocity (m/s), spin (rad/s, forward), tangential_impulse
        (N s), total, friction_work (J) and wear: the elastic part of F_n times the sliding
        distance while the contact slips (J).
    ndarray, shape (n, 3)
        Time since the start of the contact (s), normal and tangential force (N) at every step.
    """
    model, interaction = scene.contact, scene.interaction
    mass, radius, mu = scene.mass, scene.radius, interaction.static_friction
    inertia = 0.4 * mass * radius**2
    young, shear = effective_moduli(scene.particle, scene.plate)
    contact_radius = choices.wall_radius * radius
    nominal = nominal_beta(interaction.restitution)
    beta_n = exact_beta(interaction.restitution) if model.normal == "exact_e" else nominal
    beta_t = beta_n if choices.corrected_tangential else nominal
    viscous = 2.0 * math.sqrt(5.0 / 6.0)

    angle = math.radians(angle_deg)
    closing, along, turning = speed * math.cos(angle), speed * math.sin(angle), 0.0
    dt = exact.hertz(young, contact_radius, mass, closing).duration / steps
    overlap, spring, stretch, stiffness_before = 0.0, 0.0, 0.0, 0.0
    total, work, wear = 0.0, 0.0, 0.0
    track: list[tuple[float, float, float]] = []
    while True:
        overlap += closing * dt
        if overlap <= 0.0:
            break
        root = math.sqrt(contact_radius * overlap)
        elastic = 4.0 / 3.0 * young * root * overlap
        normal = elastic + viscous * beta_n * math.sqrt(2.0 * young * root * mass) * closing
        if model.normal != "nominal_attractive":
            normal = max(normal, 0.0)
        arm = radius - choices.arm * overlap
        slip = along - arm * turning
        stiffness = 8.0 * shear * root
        if model.tangential == "incremental":
            if choices.weakens and stiffness < stiffness_before:
                spring *= stiffness / stiffness_before
            spring -= stiffness * slip * dt
        else:
            stretch += slip * dt
            spring = -stiffness * stretch
        damping = -viscous * beta_t * math.sqrt(stiffness * mass) * slip
        cap = mu * abs(normal)
        trial = spring + damping if model.tangential_damping == "capped" else spring
        slips = abs(trial) > cap
        force = math.copysign(min(abs(trial), cap), trial)
        if not slips and model.tangential_damping == "uncapped":
            force += damping
        if slips and choices.spring_keeps == "cap less damping":
            spring = force - damping
        elif slips or choices.capped_in_stick:
            spring = math.copysign(min(abs(spring), cap), spring)
        stretch, stiffness_before = -spring / stiffness, stiffness

        surface = along - radius * turning
        total += max(normal, 0.0) * abs(surface) * dt
        work -= force * surface * dt
        wear += elastic * abs(slip) * dt if slips else 0.0
        track.append((dt * len(track), normal, force))
        closing -= normal / mass * dt
        along += force / mass * dt
        turning -= force * arm / inertia * dt
        load = elastic if choices.rolling_load == "elastic" else max(normal, 0.0)
        slowing = interaction.rolling_friction * load * radius / inertia * dt
        turning = math.copysign(max(abs(turning) - slowing, 0.0), turning)
    return {
        "normal_velocity": -closing,
        "tangential_velocity": along,
        "spin": turning,
        "tangential_impulse": mass * (along - speed * math.sin(angle)),
        "friction_work": work,
        "total": total,
        "wear": wear,
    }, np.array(track)
