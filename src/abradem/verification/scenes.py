"""Small scenes for checks: materials by Young's modulus, one sphere or two, and what they do."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from abradem.dem.model import Case, ContactModel, Interaction, Material, Setup
from abradem.dem.state import FLYING, GONE, make_problem
from abradem.elastic import shear_modulus, sphere_mass

WIDE = 2e3
"""Edge of a plate that stands for a plane, m."""

NOMINAL_SPEED = 3.9
"""Speed of the impacts that are compared with other codes, m/s."""


def solid(youngs_modulus: float, poisson_ratio: float, density: float) -> Material:
    """Material by its Young's modulus (Pa), Poisson ratio (1) and density (kg/m3)."""
    return Material(shear_modulus(youngs_modulus, poisson_ratio), poisson_ratio, density)


PARTICLE = solid(15e9, 0.25, 2500.0)
STEEL = solid(200e9, 0.30, 7800.0)
PARTICLE_RADIUS = 0.01
"""The impact of the comparison with other codes: a 10 mm particle on steel, mu = 0.45."""

PARTICLE_ON_STEEL = Interaction(0.5, 0.45, 0.0)


@dataclass(frozen=True)
class Scene:
    """Spheres of one material and a plate, as single impacts and `simulate` take them.

    Parameters
    ----------
    particle, plate : Material
    radius : float
        m.
    interaction : Interaction
    contact : ContactModel
    """

    particle: Material = PARTICLE
    plate: Material = STEEL
    radius: float = PARTICLE_RADIUS
    interaction: Interaction = PARTICLE_ON_STEEL
    contact: ContactModel = field(default_factory=ContactModel)

    @property
    def mass(self) -> float:
        """kg."""
        return sphere_mass(self.radius, self.particle.density)

    def with_interaction(self, **changes) -> Scene:
        """The scene with another restitution, static or rolling friction."""
        return replace(self, interaction=replace(self.interaction, **changes))

    def impact(self, speed: float, angle_deg: float, **options):
        """`abradem.single_impact` of this scene."""
        from abradem.dem.impact import single_impact

        return single_impact(
            self.particle, self.radius, self.plate, self.interaction, speed, angle_deg,
            contact=self.contact, **options,
        )  # fmt: skip

    def case(self, **changes) -> Case:
        """A case of this scene; jet and plate angles are 0 unless changed."""
        values = {
            "particle_shear_modulus": self.particle.shear_modulus,
            "particle_poisson_ratio": self.particle.poisson_ratio,
            "particle_density": self.particle.density,
            "equipment_shear_modulus": self.plate.shear_modulus,
            "equipment_poisson_ratio": self.plate.poisson_ratio,
            "equipment_density": self.plate.density,
            "restitution": self.interaction.restitution,
            "rolling_friction": self.interaction.rolling_friction,
            "static_friction": self.interaction.static_friction,
            "archard_constant": 1.0,
            "plate_angle": 0.0,
            "factory_angle": 0.0,
            "particle_radius": self.radius,
            "particle_velocity_y": 0.0,
            "seed": 0,
        }
        return Case(**(values | changes))

    def setup(self, **changes) -> Setup:
        """A set-up with this contact model."""
        return Setup(**({"contact": self.contact} | changes))

    def plane(self, **changes) -> Setup:
        """A set-up whose plate is a plane of one facet; nothing is ever removed from it."""
        wide = {
            "plate_length": WIDE,
            "plate_width": WIDE,
            "facet_size": WIDE,
            "removal_depth": WIDE,
        }
        return self.setup(**(wide | changes))

    def empty_space(self, **changes) -> Setup:
        """A set-up without gravity whose plate is a speck that nothing meets near y = 1 m."""
        speck = {
            "plate_length": 1e-3,
            "plate_width": 1e-3,
            "facet_size": 1e-3,
            "gravity": 0.0,
            "removal_depth": 10.0,
        }
        return self.setup(**(speck | changes))


class Film:
    """Recorder of what every particle does, from the first release on, for `abradem.simulate`.

    Parameters
    ----------
    interval : float
        Time between frames, s; at most the time step records every step.
    """

    FIELDS = ("x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "plate_fn", "plate_energy")
    FORCES = ("plate_tx", "plate_ty", "plate_tz")

    def __init__(self, interval: float):
        self.interval = interval
        self.time: list[float] = []
        self.frames: list[dict[str, np.ndarray]] = []
        self.pair_force: list[float] = []
        self.worn: list[float] = []

    def record(self, time: float, problem, state) -> None:
        """Keep a frame; the engine calls it."""
        tally = state.tally[0]
        step, live = int(tally["step"]), int(tally["live"])
        if live == 0 and not self.frames:
            return
        particles = state.particles[:live]
        particles = np.sort(particles[particles["motion"] != GONE], order="identity")
        frame = {name: particles[name].copy() for name in (*self.FIELDS, *self.FORCES)}
        # The stored velocity of a flying particle is that of its anchor.
        flown = np.where(particles["motion"] == FLYING, step - particles["anchor_step"], 0)
        frame["vy"] -= problem.gravity * problem.dt * flown
        self.time.append(time)
        self.frames.append(frame)
        self.pair_force.append(float(state.pairs["fn"][: int(tally["pairs"])].max(initial=0.0)))
        self.worn.append(float(tally["worn_total"]))

    def of(self, name: str, particle: int = 0) -> np.ndarray:
        """A field of one particle against time; frames before its release are nan."""
        return np.array(
            [f[name][particle] if f[name].size > particle else math.nan for f in self.frames]
        )


def filmed(case: Case, setup: Setup, releases, every: float | None = None):
    """Simulate given releases and return (result, film).

    Parameters
    ----------
    case, setup : Case, Setup
        ``setup.duration`` must be given.
    releases : tuple
        As `abradem.simulate` takes them.
    every : float, optional
        Time between frames, s; by default every step.
    """
    from abradem.dem import simulate

    problem, _ = make_problem(case, setup, releases)
    film = Film(problem.dt if every is None else every)
    result = simulate(case, setup, releases=releases, recorder=film)
    return result, film
