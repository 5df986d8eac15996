"""Small scenes for checks: materials, set-ups with one or two spheres, and a recorder."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from abradem.dem.model import Case, ContactModel, Interaction, Material, Setup
from abradem.dem.state import FLYING, GONE, make_problem
from abradem.elastic import shear_modulus, sphere_mass

WIDE = 2e3
"""Edge length of a plate that represents a plane, m."""

NOMINAL_SPEED = 3.9
"""Speed of the impacts that are compared with other codes, m/s."""


def solid(youngs_modulus: float, poisson_ratio: float, density: float) -> Material:
    """Return a material from Young's modulus (Pa), Poisson ratio (1) and density (kg/m3)."""
    return Material(shear_modulus(youngs_modulus, poisson_ratio), poisson_ratio, density)


PARTICLE = solid(15e9, 0.25, 2500.0)
STEEL = solid(200e9, 0.30, 7800.0)
PARTICLE_RADIUS = 0.01
"""Impact for the comparison with other codes: a particle of radius 10 mm on steel, mu = 0.45."""

PARTICLE_ON_STEEL = Interaction(0.5, 0.45, 0.0)


@dataclass(frozen=True)
class Scene:
    """Spheres of one material and a plate, for single impacts and for `simulate`.

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
        """Mass of a sphere, kg."""
        return sphere_mass(self.radius, self.particle.density)

    def with_interaction(self, **changes) -> Scene:
        """Return the scene with another restitution, static or rolling friction."""
        return replace(self, interaction=replace(self.interaction, **changes))

    def impact(self, speed: float, angle_deg: float, **options):
        """Return `abradem.single_impact` for this scene."""
        from abradem.dem.impact import single_impact

        return single_impact(
            self.particle, self.radius, self.plate, self.interaction, speed, angle_deg,
            contact=self.contact, **options,
        )  # fmt: skip

    def case(self, **changes) -> Case:
        """Return a case of this scene; factory and plate angle are 0 unless changed."""
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
        """Return a set-up with this contact model."""
        return Setup(**({"contact": self.contact} | changes))

    def plane(self, **changes) -> Setup:
        """Return a set-up whose plate is a plane with one facet; no particle is ever removed."""
        wide = {
            "plate_length": WIDE,
            "plate_width": WIDE,
            "facet_size": WIDE,
            "removal_depth": WIDE,
        }
        return self.setup(**(wide | changes))

    def empty_space(self, **changes) -> Setup:
        """Return a set-up without gravity and with a tiny plate, for spheres near y = 1 m."""
        speck = {
            "plate_length": 1e-3,
            "plate_width": 1e-3,
            "facet_size": 1e-3,
            "gravity": 0.0,
            "removal_depth": 10.0,
        }
        return self.setup(**(speck | changes))


class Film:
    """Recorder for `abradem.simulate` of all particles, from the first release on.

    Parameters
    ----------
    interval : float
        Time between frames, s; with the time step or less, every step is recorded.
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
        """Record a frame; called by the engine."""
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
        """Return a field of one particle over time; nan in frames before its release."""
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
        Releases as in `abradem.simulate`.
    every : float, optional
        Time between frames, s; by default every step is recorded.
    """
    from abradem.dem import simulate

    problem, _ = make_problem(case, setup, releases)
    film = Film(problem.dt if every is None else every)
    result = simulate(case, setup, releases=releases, recorder=film)
    return result, film
