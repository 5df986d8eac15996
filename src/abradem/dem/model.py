"""What a simulation is given and what it returns: plain data, SI units, no numba.

Axes are right-handed with y up; gravity acts along -y. Angles are right-hand rotations
about +z (positive lifts the +x side), in degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np

from abradem.elastic import rayleigh_time, youngs_modulus

NORMAL_LAWS = ("exact_e", "nominal_clipped", "nominal_attractive")
TANGENTIAL_LAWS = ("incremental", "displacement")
TANGENTIAL_DAMPINGS = ("capped", "none", "uncapped")
STEPPINGS = ("islands", "synchronous")


@dataclass(frozen=True)
class Material:
    """Isotropic elastic solid.

    Parameters
    ----------
    shear_modulus : float
        G, Pa.
    poisson_ratio : float
    density : float
        kg/m3.
    """

    shear_modulus: float
    poisson_ratio: float
    density: float

    def __post_init__(self):
        _check_number("shear_modulus", self.shear_modulus, above=0.0)
        _check_number("poisson_ratio", self.poisson_ratio, above=-1.0, most=0.5)
        _check_number("density", self.density, above=0.0)

    @property
    def youngs_modulus(self) -> float:
        """E = 2 G (1 + nu), Pa."""
        return youngs_modulus(self.shear_modulus, self.poisson_ratio)

    def rayleigh_time(self, radius: float) -> float:
        """Rayleigh time of a sphere of this material, s, see `abradem.elastic.rayleigh_time`."""
        return float(rayleigh_time(radius, self.density, self.shear_modulus, self.poisson_ratio))


@dataclass(frozen=True)
class Interaction:
    """What belongs to a pair of surfaces: restitution, static and rolling friction (all 1)."""

    restitution: float
    static_friction: float
    rolling_friction: float = 0.0

    def __post_init__(self):
        _check_number("restitution", self.restitution, above=0.0, most=1.0)
        _check_number("static_friction", self.static_friction, least=0.0)
        # The friction wear measure divides by it.
        if 0.0 < self.static_friction < 1e-9:
            raise ValueError(
                f"static_friction = {self.static_friction!r} must be 0 or from 1e-9 on"
            )
        _check_number("rolling_friction", self.rolling_friction, least=0.0)


@dataclass(frozen=True)
class ContactModel:
    """Options of the contact law that documented codes leave open.

    Parameters
    ----------
    normal : {"exact_e", "nominal_clipped", "nominal_attractive"}
        ``exact_e``: normal force never attractive, damping such that an isolated impact
        rebounds at exactly e. ``nominal_clipped``: the textbook damping, never attractive.
        ``nominal_attractive``: the textbook damping, no clip.
    tangential : {"incremental", "displacement"}
        Spring force accumulated increment by increment, or stiffness times accumulated
        displacement.
    tangential_damping : {"capped", "none", "uncapped"}
        ``capped``: spring plus damping is limited by Coulomb's law. ``uncapped``: only the
        spring is; the damping acts in stick without limit.
    """

    normal: str = "exact_e"
    tangential: str = "incremental"
    tangential_damping: str = "capped"

    def __post_init__(self):
        _check_choice("normal", self.normal, NORMAL_LAWS)
        _check_choice("tangential", self.tangential, TANGENTIAL_LAWS)
        _check_choice("tangential_damping", self.tangential_damping, TANGENTIAL_DAMPINGS)


@dataclass(frozen=True)
class Case:
    """The sampled quantities of one simulation; names, units and limits as in `parameters`.

    ``seed`` selects the random positions of the released particles.
    """

    particle_shear_modulus: float
    particle_poisson_ratio: float
    particle_density: float
    equipment_shear_modulus: float
    equipment_poisson_ratio: float
    equipment_density: float
    restitution: float
    rolling_friction: float
    static_friction: float
    archard_constant: float
    plate_angle: float
    factory_angle: float
    particle_radius: float
    particle_velocity_y: float
    seed: int = 0

    def __post_init__(self):
        # The materials and the interaction check what is theirs.
        _ = self.particle, self.plate, self.interaction
        _check_number("archard_constant", self.archard_constant, above=0.0)
        _check_number("plate_angle", self.plate_angle, least=-90.0, most=90.0)
        _check_number("factory_angle", self.factory_angle, least=-180.0, most=180.0)
        _check_number("particle_radius", self.particle_radius, above=0.0)
        _check_number("particle_velocity_y", self.particle_velocity_y, least=-1e6, most=1e6)
        if not 0 <= self.seed < 2**63:
            raise ValueError(f"seed = {self.seed!r} is outside [0, 2^63)")

    @classmethod
    def from_row(cls, row: Mapping) -> Case:
        """Return the case of a row of a table of cases, which may hold further columns."""
        names = (field.name for field in fields(cls) if field.name != "seed")
        return cls(**{name: float(row[name]) for name in names}, seed=int(row["seed"]))

    @property
    def particle(self) -> Material:
        """Material of the particles."""
        return Material(
            self.particle_shear_modulus, self.particle_poisson_ratio, self.particle_density
        )

    @property
    def plate(self) -> Material:
        """Material of the plate."""
        return Material(
            self.equipment_shear_modulus, self.equipment_poisson_ratio, self.equipment_density
        )

    @property
    def interaction(self) -> Interaction:
        """Interaction of particle and plate."""
        return Interaction(self.restitution, self.static_friction, self.rolling_friction)


@dataclass(frozen=True)
class Setup:
    """Everything about a simulation that is not sampled.

    Parameters
    ----------
    plate_length, plate_width : float
        Extent of the plate along its slope (x when level) and along z, m.
    facet_size : float
        Largest edge of a wear facet, m; the plate is divided evenly.
    patch_length, patch_width : float
        Extent of the factory patch (of particle centres) along its slope and along z, m.
    fall_height : float
        Height of the patch's centre above the plate's centre, m.
    mass_rate, number_rate : float or None
        Feed in kg/s or in particles per second; exactly one of them.
    removal_depth : float
        Particles are removed this far below the plate's lowest point, m.
    gravity : float
        m/s2, along -y.
    contact : ContactModel
    pair_interaction : Interaction or None
        Between particles; None takes the particle-plate interaction.
    time_step_fraction : float
        Step as a share of the Rayleigh time of the particle.
    time_step : float or None
        Step in s; overrides the fraction.
    stepping : {"islands", "synchronous"}
        ``islands`` skips the time in which nothing touches; both give the same bits.
    window : float
        Length of the window after the transient over which facets are compared, and the least
        steady time simulated, s.
    max_time : float
        Longest simulated time, s.
    target_stderr : float
        Simulate on until the relative standard error of the plate-mean wear rate is at most this.
    sample_interval : float
        Time between samples of the worn volume, s.
    duration : float or None
        If given, simulate this long (to the nearest sample), s, whatever the standard error.
    """

    plate_length: float = 0.3
    plate_width: float = 0.3
    facet_size: float = 0.01
    patch_length: float = 0.1
    patch_width: float = 0.1
    fall_height: float = 0.25
    mass_rate: float | None = 4.0
    number_rate: float | None = None
    removal_depth: float = 0.1
    gravity: float = 9.81
    contact: ContactModel = field(default_factory=ContactModel)
    pair_interaction: Interaction | None = None
    time_step_fraction: float = 0.15
    time_step: float | None = None
    stepping: str = "islands"
    window: float = 5.0
    max_time: float = 60.0
    target_stderr: float = 0.02
    sample_interval: float = 0.02
    duration: float | None = None

    def __post_init__(self):
        _check_choice("stepping", self.stepping, STEPPINGS)
        if (self.mass_rate is None) == (self.number_rate is None):
            raise ValueError("give exactly one of mass_rate and number_rate")
        _check_number("gravity", self.gravity, least=0.0)
        _check_number("fall_height", self.fall_height, least=0.0)
        for name in (
            "plate_length", "plate_width", "facet_size", "patch_length", "patch_width",
            "removal_depth", "time_step_fraction", "window", "max_time", "target_stderr",
            "sample_interval",
        ):  # fmt: skip
            _check_number(name, getattr(self, name), above=0.0)
        _check_number("time_step_fraction", self.time_step_fraction, least=1e-9)
        for name in ("mass_rate", "number_rate", "time_step", "duration"):
            if getattr(self, name) is not None:
                _check_number(name, getattr(self, name), above=0.0)
        if self.max_time <= self.window:
            raise ValueError(f"max_time = {self.max_time!r} must exceed window = {self.window!r}")

    @classmethod
    def from_dict(cls, values: Mapping) -> Setup:
        """Return the set-up of plain values (a mapping of its fields), such as JSON holds."""
        values = dict(values)
        for name, kind in (("contact", ContactModel), ("pair_interaction", Interaction)):
            if isinstance(values.get(name), Mapping):
                values[name] = kind(**values[name])
        return cls(**values)

    @property
    def facets(self) -> tuple[int, int]:
        """Number of facets along the plate's length and width."""
        tiny = 1e-9
        return (
            int(np.ceil(self.plate_length / self.facet_size - tiny)),
            int(np.ceil(self.plate_width / self.facet_size - tiny)),
        )

    @property
    def plate_area(self) -> float:
        """m2."""
        return self.plate_length * self.plate_width


@dataclass(frozen=True)
class SimulationResult:
    """What one simulation gives; wear is for an Archard constant of 1, in J = N m.

    Multiplying by W (1/Pa) gives a volume in m3. The last axis of ``worn`` and the first of
    the maps follow `abradem.quantities.WEAR_MEASURES`.

    Attributes
    ----------
    status : str
        "ok", or the named reason why the case ended early.
    time : ndarray, shape (n,)
        Sample times from 0, s.
    worn : ndarray, shape (n, 3)
        Cumulative F_n ds on the whole plate, J.
    delivered_mass : ndarray, shape (n,)
        Cumulative mass released, kg.
    present : ndarray of int, shape (n,)
        Particles present.
    facet_wear : ndarray, shape (3, nx, nz)
        F_n ds per facet within ``window``, J.
    facet_wear_all : ndarray, shape (3, nx, nz)
        The same from the start to the end, J.
    window : tuple of float
        Start and end of the window, s; (nan, nan) if it was not completed.
    steady_from : float
        End of the transient, s; nan if the window after it was not completed.
    settled : bool
        Whether the transient rule found wear and particles present steady.
    stderr : float
        Relative standard error of the plate-mean ``total`` rate at the stop; nan if unknown.
    time_step : float
        s.
    simulated_time : float
        s.
    requested_rate, delivered_rate : float
        Feed asked for and achieved, kg/s.
    face_share, edge_share, missed_share : float
        Of the particles that met the plate or left without: first contact on its face, on an
        edge or corner, none.
    max_overlap : float
        Largest overlap of the run as a share of the radius.
    released, removed : int
        Particles put in and taken out.
    energy : dict
        Book of mechanical energy, J: ``inserted``, ``removed``, ``resident``, ``dissipated``.
    """

    case: Case
    setup: Setup
    status: str
    time: np.ndarray
    worn: np.ndarray
    delivered_mass: np.ndarray
    present: np.ndarray
    facet_wear: np.ndarray
    facet_wear_all: np.ndarray
    window: tuple[float, float]
    steady_from: float
    settled: bool
    stderr: float
    time_step: float
    simulated_time: float
    requested_rate: float
    delivered_rate: float
    face_share: float
    edge_share: float
    missed_share: float
    max_overlap: float
    released: int
    removed: int
    energy: dict


@dataclass(frozen=True)
class Impact:
    """Outcome of a single impact on a plane; wear measures for an Archard constant of 1.

    The plane's normal is +y; the sphere comes in along (sin a, -cos a, 0).

    Attributes
    ----------
    normal_velocity, tangential_velocity : float
        Of the centre after the impact, along +y and +x, m/s.
    spin : ndarray, shape (3,)
        rad/s; rolling forward is negative about z.
    contact_time : float
        Time with overlap, s.
    max_overlap : float
        m.
    max_normal_force : float
        N.
    total, sliding, friction_work : float
        J; ``friction_work`` is not divided by the friction coefficient.
    time_step : float
        s.
    """

    normal_velocity: float
    tangential_velocity: float
    spin: np.ndarray
    contact_time: float
    max_overlap: float
    max_normal_force: float
    total: float
    sliding: float
    friction_work: float
    time_step: float


def _check_choice(name: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ValueError(f"{name} = {value!r} is unknown; allowed: {', '.join(allowed)}")


def _check_number(name: str, value, least=-np.inf, most=np.inf, above=-np.inf) -> None:
    """Refuse what is no finite number within [least, most] and above ``above``."""
    try:
        fine = np.isfinite(value) and least <= value <= most and value > above
    except TypeError:
        fine = False
    if not fine:
        low = f"above {above:g}" if above > -np.inf else f"at least {least:g}"
        limits = [low] if max(above, least) > -np.inf else []
        limits += [f"at most {most:g}"] if most < np.inf else []
        allowed = f" ({', '.join(limits)})" if limits else ""
        raise ValueError(f"{name} = {value!r} must be a finite number{allowed}")
