"""Part 11: intervals of cases that the stop rule ended, with the default set-up.

A rule that ends a case at the first small standard error prefers records that are low by chance.
The corners are large and small particles on flat and steep plates. The reference of each is the
mean of long runs with other seeds.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from abradem.dem.model import SimulationResult
from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import JET, jet_case, rate_of, run_jet, spread

PART = 11
CORNERS = {
    "R 40 mm, 8 deg": (0.04, 8.0, 200, 60.0, 200),
    "R 40 mm, 60 deg": (0.04, 60.0, 200, 60.0, 200),
    "R 15 mm, 8 deg": (0.015, 8.0, 60, 15.0, 30),
    "R 10 mm, 60 deg": (0.01, 60.0, 200, 15.0, 80),
}
"""Radius, m; plate angle, deg; cases ended by the rule; length, s, and number of the long runs."""

LARGEST_BIAS = 0.003
_TRANSIENT = 2.0
_OTHER_SEEDS = 10**6


def long_rate(result: SimulationResult) -> float:
    """Return the rate of ``total`` of a long run after `_TRANSIENT`, over whole release intervals.

    Particles are released evenly, so the mean over seeds is periodic in the release interval.
    """
    time, worn = result.time, result.worn[:, 0]
    length = int((time[-1] - _TRANSIENT) / result.release_interval) * result.release_interval
    return float(worn[-1] - np.interp(time[-1] - length, time, worn)) / length


def ended_cases() -> pd.DataFrame:
    """Return the cases ended by the rule over the reference of their corner."""
    frames = []
    for corner, (radius, angle, number, duration, long) in CORNERS.items():
        case = {"particle_radius": radius, "plate_angle": angle}
        truth, truth_error = spread(
            [
                long_rate(run_jet(jet_case(seed=seed, **case), JET.setup(duration=duration)))
                for seed in range(_OTHER_SEEDS, _OTHER_SEEDS + long)
            ]
        )
        rows = []
        for seed in range(number):
            result = run_jet(jet_case(seed=seed, **case), JET.setup())
            rate = rate_of(result, start=result.steady_from)
            reach = stats.t.ppf(0.975, rate.freedom) * rate.stderr
            rows.append(
                {"replicate": seed, "time": result.simulated_time, "value": rate.value / truth,
                 "relative_stderr": rate.stderr / truth,
                 "covered": float(abs(rate.value - truth) <= reach)}
            )  # fmt: skip
        frames.append(
            pd.DataFrame(rows).assign(corner=corner, reference_stderr=truth_error / truth)
        )
    return pd.concat(frames, ignore_index=True)


def checks(ended: pd.DataFrame) -> list[Check]:
    """Return checks of coverage and bias in each corner, and of the coverage of all."""
    found = []
    for corner, rows in ended.groupby("corner", sort=False):
        mean, mean_error = spread(rows["value"])
        error = float(np.hypot(mean_error, rows["reference_stderr"].iloc[0]))
        found += [
            _coverage(f"{corner}: 95 % intervals that hold the rate, of", rows["covered"]),
            Check(f"{corner}: mean over the reference", mean, 1.0, LARGEST_BIAS + 2.0 * error,
                  kind="absolute",
                  note="0.3 %, and two standard errors of the difference"),
        ]  # fmt: skip
    found.append(_coverage("95 % intervals that hold the rate, of all", ended["covered"]))
    return found


def _coverage(law: str, covered: pd.Series) -> Check:
    """Check that a share of intervals is in the binomial band of 95 %, too high ones included."""
    count = len(covered)
    low, high = stats.binom.ppf([0.025, 0.975], count, 0.95) / count
    return Check(
        f"{law} {count} ended by the rule", covered.mean(), 0.5 * (low + high),
        0.5 * (high - low) + 1e-12, kind="absolute",
        note=f"binomial band {low:.3f} to {high:.3f}",
    )  # fmt: skip


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    ended = ended_cases()
    return {"checks": checks_table(PART, checks(ended)), "ended": ended}
