"""Estimate of the computing time of simulations from their parameters.

Half of the computing time of a study is spent in a few of its cases. If such a case starts last,
all cores but one wait for it, so the most expensive batches start first. The estimate also says
before a run how long it will take. No result depends on it, and no step reruns if it changes.

Time is spent on a case, on its samples, on each particle with its flights and impacts, and on each
step in which a particle touches something (docs/scaling.md). All but the last are counted; how long
a particle is in contact is described by powers, fitted to measured times of cases. It lies on the
plate after its bounces if it has not left by then, so the time falls with the tilt, the speed and
the restitution. In a crowded jet it meets others on its way out, and they take its speed whatever
the restitution. On a level plate it lies until others push it off, so the time grows with that in
which the feed covers the plate once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.elastic import rayleigh_time, sphere_mass
from abradem.sampling.surface_cost import presence

STEP = 4.0e-8
"""Computing time of one step of a particle that touches something, s (docs/scaling.md)."""

TRANSIENT = 0.5
"""Usual simulated time before the steady window, s."""

PARTICLES = 0.13
"""Particles in the steady window, times target_stderr squared, where particles do not lie on the
plate. The stop rule asks for 0.12 (`abradem.dem.stop.PARTICLES`) and looks at intervals."""

PARTICLES_IN_A_BED = 8.0
BED_ANGLE = 5.0
"""On a level plate the window needs so many times more, as the wear of a bed varies for longer; the
number falls by e for this angle, deg."""

LEVEL = 0.1
"""Sine of the plate angle at which being pushed off has lost most of its influence."""

LEAST_LOSS = 0.05
LEAST_ROLLING_FRICTION = 0.005
LEAST_SPEED = 0.5
"""Values of 1 - e, of the rolling friction and of the speed, m/s, below which the powers are not
continued."""


class Costs(NamedTuple):
    """Constants of the estimate, fitted by ``benchmarks/order.py`` to finished studies.

    Attributes
    ----------
    case, second, particle : float
        Computing time of a case, of a simulated second, and of a particle with its flights and
        impacts, s.
    contact : float
        Time in contact of a particle, s, where all factors below are 1: radius 10 mm, level plate,
        impact at 4 m/s, e = 0.5, rolling friction 0.05, one particle met on a way through the jet,
        the plate covered once a second.
    radius, tilt, speed, restitution, rolling : float
        Exponents of the radius, of exp(sine of the plate angle), of the speed, of 1 - e, and of
        the rolling friction.
    meeting : float
        Exponent of the number of particles that one meets on a way as long as the patch.
    cooling : float
        Decrease of the exponent of 1 - e with the logarithm of that number.
    cover : float
        Exponent, on a level plate, of the time in which the feed covers the plate once.
    """

    case: float = 9.5e-3
    second: float = 1.1e-4
    particle: float = 1.2e-5
    contact: float = 0.207
    radius: float = -0.40
    tilt: float = -7.1
    speed: float = -1.24
    restitution: float = 2.7
    rolling: float = 0.37
    meeting: float = 1.08
    cooling: float = 1.09
    cover: float = 1.14


COSTS = Costs()


def simulated_time(cases: pd.DataFrame, setup: Mapping) -> np.ndarray:
    """Estimate the simulated time of cases, s: the transient and the window of the stop rule.

    Parameters
    ----------
    cases : pandas.DataFrame
        Table of cases, n rows.
    setup : mapping
        Plain values of the `Setup`.

    Returns
    -------
    ndarray, shape (n,)
    """
    level = np.exp(-np.abs(cases["plate_angle"].to_numpy()) / BED_ANGLE)
    asked = PARTICLES / setup["target_stderr"] ** 2 * (1.0 + PARTICLES_IN_A_BED * level)
    window = np.maximum(setup["window"], asked / rates_of_particles(cases, setup))
    return np.minimum(TRANSIENT + window, setup["max_time"])


def contact_time(cases: pd.DataFrame, setup: Mapping, costs: Costs = COSTS) -> np.ndarray:
    """Estimate for how long a particle of each case is in contact, s.

    It is at most half of the simulated time: so long are particles present on average if none
    leaves.

    Parameters
    ----------
    cases, setup
        See `case_seconds`.
    costs : Costs

    Returns
    -------
    ndarray, shape (n,)
    """
    radius = cases["particle_radius"].to_numpy()
    size = np.log(radius / 0.01)
    tilt = np.sin(np.radians(np.abs(cases["plate_angle"].to_numpy())))
    loss = np.log(np.maximum(1.0 - cases["restitution"].to_numpy(), LEAST_LOSS) / 0.5)
    rolling = np.maximum(cases["rolling_friction"].to_numpy(), LEAST_ROLLING_FRICTION)
    plate = setup["plate_length"] * setup["plate_width"]
    patch = setup["patch_length"] * setup["patch_width"]
    cover = plate / (math.pi * radius**2) / rates_of_particles(cases, setup)
    speed = _impact_speed(cases, setup)
    # Particles met on a way as long as the patch: their number there times the cross-section.
    met = np.log(
        rates_of_particles(cases, setup) / (speed * math.sqrt(patch)) * (4.0 * math.pi * radius**2)
    )
    time = costs.contact * np.exp(
        costs.radius * size
        + costs.tilt * tilt
        + costs.speed * np.log(speed / 4.0)
        + np.maximum(costs.restitution - costs.cooling * met, 0.0) * loss
        + costs.rolling * np.log(rolling / 0.05)
        + costs.meeting * met
        + costs.cover * np.exp(-tilt / LEVEL) * np.log(cover)
    )
    return 1.0 / (1.0 / time + 2.0 / simulated_time(cases, setup))


def case_seconds(cases: pd.DataFrame, setup: Mapping, costs: Costs = COSTS) -> np.ndarray:
    """Estimate the computing time of cases with the stepping ``islands``, s of one core.

    Parameters
    ----------
    cases : pandas.DataFrame
        Table of cases, n rows.
    setup : mapping
        Plain values of the `Setup`.
    costs : Costs

    Returns
    -------
    ndarray, shape (n,)
        Seconds.
    """
    step = setup["time_step_fraction"] * rayleigh_time(
        cases["particle_radius"].to_numpy(),
        cases["particle_density"].to_numpy(),
        cases["particle_shear_modulus"].to_numpy(),
        cases["particle_poisson_ratio"].to_numpy(),
    )
    if setup.get("geometry"):
        return _surface_seconds(cases, setup, step, costs)
    time = simulated_time(cases, setup)
    particles = rates_of_particles(cases, setup) * time
    each = costs.particle + contact_time(cases, setup, costs) / step * STEP
    return costs.case + costs.second * time + particles * each


def _surface_seconds(cases, setup, step: np.ndarray, costs: Costs) -> np.ndarray:
    """Estimate as `case_seconds` for a geometry; ``step`` (n,) is the time step, s."""
    dwell, share = presence(cases, setup)
    time = np.minimum(np.maximum(TRANSIENT, dwell) + setup["window"], setup["max_time"])
    rate = rates_of_particles(cases, setup)
    # Their number grows until as many leave.
    stay = np.minimum(dwell, time)
    present = rate * stay * (time - 0.5 * stay)
    return (
        costs.case + costs.second * time + rate * time * costs.particle
        + share * present / step * STEP
    )  # fmt: skip


def batch_seconds(
    cases: pd.DataFrame, setup: Mapping, batches: Sequence[tuple[int, int]]
) -> list[list[float]]:
    """Estimate the computing times of the cases of each batch of a block.

    Parameters
    ----------
    cases : pandas.DataFrame
        Cases of the block.
    setup : mapping
        Plain values of the `Setup`.
    batches : sequence of (int, int)
        See `abradem.config.batches.batches_of_block`.

    Returns
    -------
    list of list of float
        Seconds of each case, for each batch.
    """
    seconds = case_seconds(cases, setup)
    return [seconds[start:stop].tolist() for start, stop in batches]


def _impact_speed(cases, setup):
    """Speed at the centre of the plate after the fall from the patch, m/s."""
    place = Setup.from_dict(setup).patch_place
    height = np.array([place(angle)[0] for angle in cases["factory_angle"]])
    speed2 = cases["particle_velocity_y"].to_numpy() ** 2 + 2.0 * setup["gravity"] * height
    return np.maximum(np.sqrt(speed2), LEAST_SPEED)


def rates_of_particles(cases: pd.DataFrame, setup: Mapping[str, Any]) -> np.ndarray:
    """Return the particles per second of each case, shape (n,)."""
    mass = sphere_mass(cases["particle_radius"].to_numpy(), cases["particle_density"].to_numpy())
    return (setup["number_rate"] or setup["mass_rate"] / mass) * np.ones(len(cases))
