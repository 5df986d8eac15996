"""Estimate of the computing time of simulations from their parameters, for the order of jobs.

Half of the computing time of a study is spent in a few of its cases. If such a case starts last,
all cores but one wait for it. An estimate is enough to start the most expensive cases first. Only
the order of the jobs depends on it: no result depends on it, and no step reruns if it changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from abradem.elastic import sphere_mass

SECONDS_PER_PARTICLE = 3.6e-5
"""Computing time of a particle that bounces off the plate, s."""

SECONDS_IN_A_BED = 0.07
"""Computing time of a particle of radius 10 mm in a bed, s. It is in contact in every step until it
is pushed over an edge."""

BED_RADIUS = 0.01
BED_RADIUS_EXPONENT = 1.55
BED_ANGLE = 8.0
BED_SPEED = 1.56
"""Decrease of the probability and cost of a bed: a power of the radius over `BED_RADIUS`, m, and
exponential in the plate angle, deg, and in the impact speed, m/s. These constants and the two times
were fitted, in logarithms, to the 200 cases of the paper's study. benchmarks/order.py compares the
estimate with the times of a finished study and fits the constants to them."""

FEWEST_PARTICLES = 0.25
"""Particles in a steady window times target_stderr squared: the squared relative spread of the wear
of single particles."""

TRANSIENT_TIME = 1.0
"""Simulated time before the steady window, s."""


def case_seconds(cases: pd.DataFrame, setup: Mapping) -> np.ndarray:
    """Estimate the computing time of cases, in seconds of one core.

    The estimate is the number of particles released times the time per particle. A particle
    bounces off or stays in a bed; beds form on flat plates under slow jets. The correlation with
    the measured times is 0.98 in the paper's study (logarithms 0.90, ranks 0.82) and 0.75 in the
    large study (0.86, 0.77).

    Parameters
    ----------
    cases : pandas.DataFrame
        Table of cases, n rows.
    setup : mapping
        Plain values of the `Setup`.

    Returns
    -------
    ndarray, shape (n,)
        Seconds.
    """
    radius = cases["particle_radius"].to_numpy()
    mass = sphere_mass(radius, cases["particle_density"].to_numpy())
    rate = setup["number_rate"] or setup["mass_rate"] / mass
    window = np.maximum(setup["window"], FEWEST_PARTICLES / setup["target_stderr"] ** 2 / rate)
    time = np.minimum(TRANSIENT_TIME + window, setup["max_time"])
    # The height at a factory angle of 0 is enough for an estimate.
    fall = 2.0 * setup["gravity"] * setup["fall_height"]
    speed = np.sqrt(cases["particle_velocity_y"].to_numpy() ** 2 + fall)
    rest = np.exp(-np.abs(cases["plate_angle"].to_numpy()) / BED_ANGLE - speed / BED_SPEED)
    in_a_bed = SECONDS_IN_A_BED * (BED_RADIUS / radius) ** BED_RADIUS_EXPONENT * rest
    return rate * time * (SECONDS_PER_PARTICLE + in_a_bed)


def batch_seconds(
    cases: pd.DataFrame, setup: Mapping, batches: Sequence[tuple[int, int]]
) -> list[float]:
    """Estimate the computing time of each batch of a block.

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
    list of float
        Seconds.
    """
    seconds = case_seconds(cases, setup)
    return [float(seconds[start:stop].sum()) for start, stop in batches]
