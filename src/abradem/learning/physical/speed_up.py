"""Computing times of engine and surrogate for the same cases, measured in turn on one core."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping

import numpy as np
import pandas as pd

from abradem.dem.model import Case, Setup
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.model import Surrogate

BATCH = 200_000
"""Number of cases predicted in one call."""

SINGLES = 200
"""Number of single-case predictions that are timed."""

WARM_UP = 0.1
"""Simulated time of the warm-up run, s."""

ROUNDS = 3
"""Timed repetitions, of which the fastest counts, as other processes can only slow them down."""


def time_both(
    dataset: pd.DataFrame, count: int, setup: Mapping, surrogate: Surrogate, seed: int = 0
) -> dict:
    """Computing time of a case, simulated and predicted.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Completed cases. ``count`` of them are taken at even ranks of the particle radius, which
        dominates the cost of a simulation.
    count : int
    setup : mapping
        Plain values of the `Setup`.
    surrogate : Surrogate
    seed : int
        Seed of the draw of the cases predicted in one call.

    Returns
    -------
    dict
        ``cases``; ``radii`` (m); ``simulated_seconds`` (mean, median and each case),
        ``predicted_seconds`` (median of single-case predictions), ``predictions_per_second`` (in
        a call with ``batch`` cases), ``speed_up`` (mean simulation time over the time of a
        single prediction) and ``speed_up_of_a_batch``.
    """
    from abradem.dem import simulate

    rows = dataset.sort_values("particle_radius", ignore_index=True)
    places = ((np.arange(count) + 0.5) / count * len(rows)).astype(int)
    cases = rows.iloc[places].to_dict("records")
    settings = Setup.from_dict(setup)
    # Load or compile the engine before the timing starts.
    simulate(Case.from_row(cases[0]), dataclasses.replace(settings, duration=WARM_UP))
    seconds = []
    for case in cases:
        begin = time.perf_counter()
        simulate(Case.from_row(case), settings)
        seconds.append(time.perf_counter() - begin)

    single = []
    for number in range(SINGLES):
        case = {name: cases[number % len(cases)][name] for name in SAMPLED_NAMES}
        begin = time.perf_counter()
        surrogate.predict(case)
        single.append(time.perf_counter() - begin)

    rng = np.random.default_rng(seed)
    drawn = rng.integers(0, len(rows), BATCH)
    batch = {name: rows[name].to_numpy(dtype=float)[drawn] for name in SAMPLED_NAMES}
    rounds = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        surrogate.predict(batch)
        rounds.append(time.perf_counter() - begin)
    mean, one, many = float(np.mean(seconds)), float(np.median(single)), min(rounds) / BATCH
    return {
        "cases": [int(case["case_id"]) for case in cases],
        "radii": [float(case["particle_radius"]) for case in cases],
        "simulated_seconds": {"mean": mean, "median": float(np.median(seconds)), "each": seconds},
        "predicted_seconds": one,
        "batch": BATCH,
        "predictions_per_second": 1.0 / many,
        "speed_up": mean / one,
        "speed_up_of_a_batch": mean / many,
    }
