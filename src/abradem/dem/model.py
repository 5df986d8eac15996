"""Inputs and outputs of a simulation: plain data, SI units, no numba.

Axes are right-handed with y up; gravity acts along -y. Angles are right-hand rotations
about +z (positive lifts the +x side), in degrees.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np

from abradem.dem.surface import Feed, Surface, check_feed, check_surface
from abradem.elastic import rayleigh_time, youngs_modulus

NORMAL_LAWS = ("exact_e", "nominal_clipped", "nominal_attractive")
TANGENTIAL_LAWS = ("incremental", "displacement")
TANGENTIAL_DAMPINGS = ("capped", "none", "uncapped")
STEPPINGS = ("islands", "synchronous")
MOST_THREADS = 64
"""Largest number of threads of one simulation."""

ANGLE_ACTS = ("tilt", "level", "arc")
UNPLACED = ("wait", "skip")
MOST_ATTEMPTS = 10_000


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
    """Properties of a pair of surfaces: restitution, static and rolling friction (all 1)."""

    restitution: float
    static_friction: float
    rolling_friction: float = 0.0

    def __post_init__(self):
        _check_number("restitution", self.restitution, above=0.0, most=1.0)
        _check_number("static_friction", self.static_friction, least=0.0)
        # The friction wear measure is divided by it.
        if 0.0 < self.static_friction < 1e-9:
            raise ValueError(
                f"static_friction = {self.static_friction!r} must be 0 or at least 1e-9"
            )
        _check_number("rolling_friction", self.rolling_friction, least=0.0)


@dataclass(frozen=True)
class ContactModel:
    """Options of the contact law in which documented codes differ.

    Parameters
    ----------
    normal : {"exact_e", "nominal_clipped", "nominal_attractive"}
        ``exact_e``: the normal force is never attractive, and an isolated impact rebounds at
        exactly e. ``nominal_clipped``: the textbook damping (Tsuji et al. 1992), clipped so that
        it is never attractive. ``nominal_attractive``: the textbook damping without a clip.
    tangential : {"incremental", "displacement"}
        The spring force is accumulated in increments, or is the stiffness times the accumulated
        displacement.
    tangential_damping : {"capped", "none", "uncapped"}
        ``capped``: Coulomb's law limits the sum of spring and damping force. ``uncapped``: it
        limits only the spring force; the damping force acts during stick without a limit.
        ``none``: no tangential damping.
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
    """The sampled quantities of one simulation, by default the middle of the paper's ranges.

    Names, units, ranges and limits are those of `abradem.quantities`. `abradem.simulate` refuses
    values outside the limits given here in square brackets.

    Parameters
    ----------
    particle_shear_modulus : float
        Pa [1e6, 1e12].
    particle_poisson_ratio : float
        [0, 0.499].
    particle_density : float
        kg/m3 [10, 25000].
    equipment_shear_modulus : float
        Of the plate, Pa [1e6, 1e12].
    equipment_poisson_ratio : float
        Of the plate [0, 0.499].
    equipment_density : float
        Of the plate, kg/m3 [10, 25000].
    restitution : float
        Coefficient of restitution [0.05, 1].
    rolling_friction : float
        Coefficient of rolling friction [0, 1].
    static_friction : float
        Coefficient of static friction [0, 2].
    archard_constant : float
        W of Archard's law, 1/Pa [1e-16, 0.0001]; scales the wear, not the motion.
    plate_angle : float
        deg [-90, 90], 0 is level.
    factory_angle : float
        deg [-90, 90], see `Setup.patch_place`.
    particle_radius : float
        m [0.0001, 0.1].
    particle_velocity_y : float
        Vertical velocity at the release, m/s [-30, 0], negative is down.
    seed : int
        Determines the random positions of the released particles, [0, 2^63).
    """

    particle_shear_modulus: float = 6e9
    particle_poisson_ratio: float = 0.275
    particle_density: float = 3000.0
    equipment_shear_modulus: float = 55e9
    equipment_poisson_ratio: float = 0.275
    equipment_density: float = 7000.0
    restitution: float = 0.5
    rolling_friction: float = 0.055
    static_friction: float = 0.475
    archard_constant: float = 5.05e-9
    plate_angle: float = 35.0
    factory_angle: float = -45.0
    particle_radius: float = 0.0225
    particle_velocity_y: float = -5.0
    seed: int = 0

    def __post_init__(self):
        # The materials and the interaction check their own fields.
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
        """Return the case of a row of a table of cases; further columns are ignored."""
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
    """All settings of a simulation that are not sampled.

    Parameters
    ----------
    plate_length, plate_width : float
        Extent of the plate along its slope (x when level) and along z, m.
    facet_size : float
        Largest edge of a wear facet, m; the plate is divided into equal facets.
    patch_length, patch_width : float
        Extent of the factory patch (of particle centres) along its slope and along z, m.
    fall_height : float
        Height of the centre of the patch above the centre of the plate, m, at a factory angle of
        0; `patch_place` gives that of a case.
    angle_acts : {"tilt", "level", "arc"}
        How the factory angle acts, see `patch_place`.
    arc_radius : float
        Radius r of the arc, m; used by ``arc`` alone.
    mass_rate, number_rate : float or None
        Feed in kg/s or in particles per second; exactly one of them.
    attempts : int
        Number of random places on the patch that are tried for a particle.
    unplaced : {"wait", "skip"}
        What becomes of a particle that overlaps others at all of them. ``wait``: it is tried
        again a little later, before those that follow, so the feed is made up for as soon as there
        is room. ``skip``: it is left out, and its share of the feed is lost.
    removal_depth : float
        Depth below the lowest point of the plate at which particles are removed, m.
    gravity : float
        m/s2, along -y.
    contact : ContactModel
    pair_interaction : Interaction or None
        Interaction between particles; None means the same as between particle and plate.
    time_step_fraction : float
        Time step as a fraction of the Rayleigh time of the particle.
    time_step : float or None
        Time step, s; overrides ``time_step_fraction``.
    stepping : {"islands", "synchronous"}
        ``islands`` skips the time in which nothing touches. Both give bitwise equal results.
    window : float
        Length of the window after the transient over which the wear of the facets is recorded,
        s. It is also the shortest steady time that is simulated.
    max_time : float
        Longest simulated time, s.
    target_stderr : float
        The simulation continues until the relative standard error of the plate-mean wear rate
        is at most this value.
    sample_interval : float
        Time between samples of the worn volume, s.
    duration : float or None
        If given, the simulated time (to the nearest sample), s, whatever the standard error.
    geometry : object or None
        Description of a geometry in place of the plate, of `abradem.geometry.kinds` or as plain
        values. `abradem.geometry.build.prepared` makes ``surface`` and ``feed`` from it, which
        the engine needs; `abradem.simulate` does so.
    surface : Surface or None
        Triangulated surface in place of the plate, in the coordinates of the simulation. The
        material of the plate is that of the surface; the angle of the plate has no effect.
    feed : Feed or None
        Factory patch anywhere, in place of the one above the origin; needs a surface.
    removal_box : tuple of tuple of float or None
        Lowest and highest corner of the box outside which particles are removed, m; needs a
        surface. None means the level ``removal_depth`` below the lowest point of the surface.
    """

    plate_length: float = 0.3
    plate_width: float = 0.3
    facet_size: float = 0.01
    patch_length: float = 0.1
    patch_width: float = 0.1
    fall_height: float = 0.25
    angle_acts: str = "tilt"
    arc_radius: float = 0.0
    mass_rate: float | None = 4.0
    number_rate: float | None = None
    attempts: int = 100
    unplaced: str = "wait"
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
    geometry: object | None = None
    surface: Surface | None = None
    feed: Feed | None = None
    removal_box: tuple | None = None

    def __post_init__(self):
        _check_choice("stepping", self.stepping, STEPPINGS)
        _check_choice("angle_acts", self.angle_acts, ANGLE_ACTS)
        _check_choice("unplaced", self.unplaced, UNPLACED)
        if not (type(self.attempts) is int and 1 <= self.attempts <= MOST_ATTEMPTS):
            raise ValueError(
                f"attempts = {self.attempts!r} must be a whole number from 1 to {MOST_ATTEMPTS}"
            )
        _check_number("arc_radius", self.arc_radius, least=0.0)
        if self.angle_acts == "arc" and self.arc_radius >= self.fall_height:
            raise ValueError(
                f"arc_radius = {self.arc_radius!r} must be less than fall_height = "
                f"{self.fall_height!r}"
            )
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
        self._check_surface()

    def _check_surface(self):
        if self.surface is None:
            for name in ("feed", "removal_box"):
                if getattr(self, name) is not None:
                    raise ValueError(f"{name} is given, but no surface; allowed is both or neither")
            return
        check_surface(self.surface)
        if self.feed is not None:
            check_feed(self.feed)
        if self.removal_box is not None:
            box = np.asarray(self.removal_box, dtype=float)
            if box.shape != (2, 3) or not np.all(box[0] < box[1]):
                raise ValueError(
                    f"removal_box = {self.removal_box!r} must be the lowest and the highest corner"
                )

    @classmethod
    def from_dict(cls, values: Mapping) -> Setup:
        """Return the set-up for a mapping of its fields to plain values, for example from JSON."""
        values = dict(values)
        for name, kind in (("contact", ContactModel), ("pair_interaction", Interaction)):
            if isinstance(values.get(name), Mapping):
                values[name] = kind(**values[name])
        return cls(**values)

    def patch_place(self, factory_angle: float) -> tuple[float, float]:
        """Return height and tilt of the factory patch at a factory angle theta.

        ``tilt``: the patch is tilted by theta about its centre, so the jet narrows to the share
        cos theta of the length of the patch. ``level``: the patch stays level, and theta does
        nothing. ``arc``: the level patch moves on an arc of radius r about a point below it, so
        that it is lower by r (1 - cos theta); it stays above the centre of the plate.

        Parameters
        ----------
        factory_angle : float
            deg.

        Returns
        -------
        height : float
            Height of the centre of the patch above the centre of the plate, m.
        tilt : float
            deg.
        """
        if self.angle_acts == "tilt":
            return self.fall_height, factory_angle
        if self.angle_acts == "level":
            return self.fall_height, 0.0
        sagitta = self.arc_radius * (1.0 - math.cos(math.radians(factory_angle)))
        return self.fall_height - sagitta, 0.0

    @property
    def facets(self) -> tuple[int, int]:
        """Number of facets along the length and the width of the plate."""
        tiny = 1e-9
        return (
            int(np.ceil(self.plate_length / self.facet_size - tiny)),
            int(np.ceil(self.plate_width / self.facet_size - tiny)),
        )

    @property
    def plate_area(self) -> float:
        """Area of the plate, m2."""
        return self.plate_length * self.plate_width


@dataclass(frozen=True, repr=False)
class SimulationResult:
    """Result of one simulation; wear is for an Archard constant of 1, in J = N m.

    Wear times the Archard constant W (1/Pa) is the worn volume in m3 (Archard 1953). The last
    axis of ``worn`` and the first axis of the maps are in the order of
    `abradem.quantities.WEAR_MEASURES`.

    Attributes
    ----------
    status : str
        "ok", or the reason why the case ended early.
    time : ndarray, shape (n,)
        Sample times from 0, s.
    worn : ndarray, shape (n, 3)
        Cumulative F_n ds on the whole plate, J.
    delivered_mass : ndarray, shape (n,)
        Cumulative mass released, kg.
    present : ndarray of int, shape (n,)
        Number of particles present.
    facet_wear : ndarray, shape (3, nx, nz)
        F_n ds per facet in the time of ``window``, J. Here and in the next two arrays, the cells
        of a surface are one axis, (t,) in place of (nx, nz).
    facet_wear_parts : ndarray, shape (parts, 3, nx, nz)
        F_n ds per facet in each of the equal parts of the window, J; their sum is ``facet_wear``.
        No parts if the window was not completed.
    facet_wear_all : ndarray, shape (3, nx, nz)
        F_n ds per facet from the start to the end, J.
    window : tuple of float
        Start and end of the window, s; (nan, nan) if it was not completed.
    steady_from : float
        End of the transient, s; nan if the window after it was not completed.
    settled : bool
        Whether wear and number of particles present are steady by the transient rule.
    stderr : float
        Relative standard error of the plate-mean ``total`` rate at the end; nan if unknown.
    time_step : float
        s.
    simulated_time : float
        s.
    requested_rate, delivered_rate : float
        Requested and achieved feed, kg/s.
    face_share, edge_share, missed_share : float
        Shares of particles with first contact on the face of the plate, with first contact on
        an edge or corner, and without any contact. The shares refer to all particles that have
        touched the plate or were removed.
    max_overlap : float
        Largest overlap of the simulation as a share of the radius.
    released, removed : int
        Number of particles released and removed.
    energy : dict
        Balance of mechanical energy, J: ``inserted``, ``removed``, ``resident``, ``dissipated``.
        What moving parts of a surface do counts as inserted.
    cell_sums, cell_sums_all : ndarray, shape (6, t)
        Sums per cell of a surface, in the order of `abradem.dem.surface.CELL_SUMS`, in the time of
        ``window`` and from the start to the end; shape (0, nx, nz) for the plate.
    """

    case: Case
    setup: Setup
    status: str
    time: np.ndarray
    worn: np.ndarray
    delivered_mass: np.ndarray
    present: np.ndarray
    facet_wear: np.ndarray
    facet_wear_parts: np.ndarray
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
    cell_sums: np.ndarray
    cell_sums_all: np.ndarray

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__}: {self.status}, {self.simulated_time:g} s simulated, "
            f"{self.released} particles released; plate_angle={self.case.plate_angle:g}, "
            f"particle_radius={self.case.particle_radius:g}, "
            f"particle_velocity_y={self.case.particle_velocity_y:g}>"
        )

    @property
    def release_interval(self) -> float:
        """Time between two releases by the factory, s; 0 for given releases."""
        if not (self.requested_rate > 0.0 and self.released > 0):
            return 0.0
        return float(self.delivered_mass[-1]) / self.released / self.requested_rate


@dataclass(frozen=True)
class Impact:
    """Outcome of a single impact on a plane; wear measures for an Archard constant of 1.

    The normal of the plane is +y; the sphere approaches along (sin a, -cos a, 0).

    Attributes
    ----------
    normal_velocity, tangential_velocity : float
        Velocity of the centre after the impact, along +y and +x, m/s.
    spin : ndarray, shape (3,)
        Spin after the impact, rad/s; rolling forward is a negative spin about z.
    contact_time : float
        Time with overlap, s.
    max_overlap : float
        Largest overlap, m.
    max_normal_force : float
        Largest normal force, N.
    total, sliding, friction_work : float
        Wear measures, J; ``friction_work`` is not divided by the friction coefficient.
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
    """Raise if ``value`` is not a finite number in [least, most] and above ``above``."""
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
