"""Jets of the verification study: an inexpensive jet, and its wear rates with standard errors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dem.model import Case, Interaction, Setup, SimulationResult
from abradem.dem.steady import batch_means, steady_start
from abradem.quantities import WEAR_MEASURES
from abradem.verification.scenes import Scene, solid

JET = Scene(
    particle=solid(10e9, 0.25, 2800.0),
    plate=solid(130e9, 0.28, 7000.0),
    radius=0.02,
    interaction=Interaction(0.5, 0.475, 0.05),
)
"""The middle of the sampled ranges, with large and therefore few particles."""


class Rate(NamedTuple):
    """Rate of F_n ds of the whole plate (W = 1) and its standard error, W; start, s; freedom."""

    value: float
    stderr: float
    start: float
    freedom: float


def jet_case(**changes) -> Case:
    """Return a case of the jet: plate at 45 deg, level factory, 3 m/s downwards, or ``changes``."""
    values = {"plate_angle": 45.0, "factory_angle": 0.0, "particle_velocity_y": -3.0}
    return JET.case(**(values | changes))


def run_jet(case: Case, setup: Setup, **options) -> SimulationResult:
    """Simulate a case; raise RuntimeError if it ends early, because its rate would be invalid."""
    from abradem.dem import simulate

    result = simulate(case, setup, **options)
    if result.status != "ok":
        raise RuntimeError(f"verification case ended early: {result.status} ({case})")
    return result


def rate_of(result: SimulationResult, measure: str = "total", start: float | None = None) -> Rate:
    """Return the steady rate of a wear measure and its standard error from batch means.

    Parameters
    ----------
    result : SimulationResult
    measure : str
    start : float, optional
        End of the transient, s; the default is that of ``total`` (`steady_start`).
    """
    if start is None:
        start = steady_start(result.time, result.worn[:, 0]).time
    means = batch_means(
        result.time, result.worn[:, WEAR_MEASURES.index(measure)], start,
        release_interval=result.release_interval,
    )  # fmt: skip
    return Rate(means.rate, means.stderr, start, means.freedom)


def spread(values) -> tuple[float, float]:
    """Return the mean of replicates and its standard error."""
    values = np.asarray(values, dtype=float)
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))
