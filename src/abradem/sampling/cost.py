"""Which simulations take long, guessed from their parameters, for the order of jobs.

Half of a study's computing time is spent in a few of its cases. If such a case starts last, all
cores but one wait for it. A guess suffices to start it first. Nothing but the order depends on
it: no result does, and no step reruns when it changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from abradem.elastic import sphere_mass

SECONDS_PER_PARTICLE = 3.6e-5
"""Computing time of a particle that bounces off the plate."""

SECONDS_IN_A_BED = 0.07
"""Computing time of a particle of 10 mm that comes to lie in a bed, where it is in contact in every
step until it is pushed over an edge."""

BED_RADIUS = 0.01
BED_RADIUS_EXPONENT = 1.55
BED_ANGLE = 8.0
BED_SPEED = 1.56
"""How the chance and the cost of a bed fall: as a power of the radius over `BED_RADIUS`, m, and
exponentially in the plate's angle, deg, and in the speed of impact, m/s. These and the two times
were fitted, by logarithms, to the 200 cases of the paper's study. benchmarks/order.py compares the
guess with the times of a finished study and fits the constants to it."""

FEWEST_PARTICLES = 0.25
"""Particles times target_stderr squared that a steady window takes: the spread, squared, of the wear
of single particles."""

TRANSIENT_TIME = 1.0
"""Simulated time before the steady window, s."""


def case_seconds(cases: pd.DataFrame, setup: Mapping) -> np.ndarray:
    """Guess the computing time of cases, in seconds of one core.

    Particles released times the time for each, which bounces off or comes to lie in a bed: on flat
    plates, under slow jets. Over the paper's study it correlates with the measured times by 0.98
    (logarithms: 0.90, ranks: 0.82), over the large study by 0.75 (0.86, 0.77).

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
    fall = 2.0 * setup["gravity"] * setup["fall_height"]
    speed = np.sqrt(cases["particle_velocity_y"].to_numpy() ** 2 + fall)
    rest = np.exp(-np.abs(cases["plate_angle"].to_numpy()) / BED_ANGLE - speed / BED_SPEED)
    in_a_bed = SECONDS_IN_A_BED * (BED_RADIUS / radius) ** BED_RADIUS_EXPONENT * rest
    return rate * time * (SECONDS_PER_PARTICLE + in_a_bed)


def batch_seconds(
    cases: pd.DataFrame, setup: Mapping, batches: Sequence[tuple[int, int]]
) -> list[float]:
    """Guess the computing time of each batch of a block.

    Parameters
    ----------
    cases : pandas.DataFrame
        The block's cases.
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
