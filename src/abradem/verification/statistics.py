"""Part 5: checks that the standard error is correct and that the stop rule does not bias the mean.

The replicates are inexpensive jets that differ only in the seed. The reference is the mean over all
replicates of a case.
"""

from __future__ import annotations

import itertools

import numpy as np
import pandas as pd
from scipy import stats

from abradem.quantities import STATISTICS
from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import JET, jet_case, rate_of, run_jet, spread
from abradem.wear.rates import element_rates

PART = 5
REPLICATES = 240
_FIXED = 10.0
_CASE = {"plate_angle": 30.0, "particle_radius": 0.015}
_FEW = {"plate_angle": 50.0, "particle_radius": 0.03}
"""A case with so few particles (6 per batch) that one more or less in a batch has an effect."""

_PLATES, _RADII, _EACH = (25.0, 35.0, 45.0, 55.0), (0.012, 0.015, 0.018), 40
"""Cases for the coverage of the intervals, and number of replicates of each."""


def fixed_runs(replicates: int = REPLICATES, case: dict = _CASE, first: int = 0) -> pd.DataFrame:
    """Return rate, standard error and reach of the 95 % interval of runs of fixed length."""
    rows = []
    for seed in range(first, first + replicates):
        result = run_jet(
            jet_case(seed=seed, **case), JET.setup(duration=_FIXED, sample_interval=0.05)
        )
        rate = rate_of(result)
        rows.append(
            {"replicate": seed, "rate": rate.value, "rate_stderr": rate.stderr,
             "reach": stats.t.ppf(0.975, rate.freedom) * rate.stderr}
        )  # fmt: skip
    return pd.DataFrame(rows)


def interval_runs(each: int = _EACH) -> pd.DataFrame:
    """Return runs of all cases over the mean of the case, and whether the interval contains it."""
    frames = []
    for number, (angle, radius) in enumerate(itertools.product(_PLATES, _RADII)):
        case = {"plate_angle": angle, "particle_radius": radius}
        frame = fixed_runs(each, case, first=1000 * number)
        mean = frame["rate"].mean()
        # The mean is that of the same runs, which reduces the variance of the difference.
        reach = frame["reach"] * np.sqrt(1.0 - 1.0 / each)
        frames.append(
            pd.DataFrame(
                {"plate_angle": angle, "particle_radius": radius, "replicate": frame["replicate"],
                 "value": frame["rate"] / mean, "relative_stderr": frame["rate_stderr"] / mean,
                 "covered": ((frame["rate"] - mean).abs() <= reach).astype(float)}
            )
        )  # fmt: skip
    return pd.concat(frames, ignore_index=True)


def stopped_runs(replicates: int = REPLICATES) -> pd.DataFrame:
    """Return the rates of runs ended by the stop rule, and facet statistics of their windows."""
    rows = []
    for seed in range(replicates):
        setup = JET.setup(window=3.0, max_time=20.0, target_stderr=0.03, sample_interval=0.05)
        result = run_jet(jet_case(seed=seed, **_CASE), setup)
        rate = rate_of(result, start=result.steady_from)
        rows.append(
            {"replicate": seed, "rate": rate.value, "rate_stderr": rate.stderr,
             "time": result.simulated_time, **_facets(result, setup)}
        )  # fmt: skip
    return pd.DataFrame(rows)


def _facets(result, setup) -> dict:
    """Return statistics over the facets of ``total`` in the window, W/m2 for W = 1."""
    wear = result.facet_wear[0]
    seconds = result.window[1] - result.window[0]
    mean = float(wear.sum()) / (setup.plate_area * seconds)
    return {"mean": mean, **element_rates(wear, setup.plate_area / wear.size, seconds)}


def _size(errors, values) -> float:
    """Return the root mean square standard error over the spread of the values."""
    return float(np.sqrt((errors**2).mean()) / values.std(ddof=1))


def checks(
    intervals: pd.DataFrame, fixed: pd.DataFrame, stopped: pd.DataFrame, few: pd.DataFrame
) -> list[Check]:
    """Return checks of coverage, size of the standard error, and bias of the stop rule."""
    count = len(intervals)
    low, high = stats.binom.ppf([0.025, 0.975], count, 0.95) / count
    cases = intervals.groupby(["plate_angle", "particle_radius"])
    sizes = np.array([_size(one["relative_stderr"], one["value"]) for _, one in cases])
    freedom = count - len(sizes)
    truth, truth_error = spread(fixed["rate"])
    mean, mean_error = spread(stopped["rate"])
    return [
        Check(f"95 % intervals that hold the mean, of {count} replicates of {len(sizes)} cases",
              intervals["covered"].mean(), 0.5 * (low + high), 0.5 * (high - low),
              kind="absolute", note=f"binomial band {low:.3f} to {high:.3f}"),
        Check("standard error over the spread between replicates",
              float(np.sqrt((sizes**2).mean())), 1.0, _spread_error(freedom),
              note="three standard errors of a spread from so many values"),
        Check("mean of runs ended by the stop rule", mean, truth,
              2.0 * float(np.hypot(mean_error, truth_error)), "W", "absolute",
              note="two standard errors of the difference"),
        Check("few particles: standard error over the spread between replicates",
              _size(few["rate_stderr"], few["rate"]), 1.0 - _spread_error(len(few) - 1),
              kind="at least",
              note="particles are released evenly; with fewer than four samples in a release "
                   "interval batches hold one more or one less, and the error is an upper bound"),
    ]  # fmt: skip


def _spread_error(freedom: int) -> float:
    """Three relative standard errors of a standard deviation."""
    return 3.0 / np.sqrt(2.0 * freedom)


def extremes(stopped: pd.DataFrame) -> pd.DataFrame:
    """Mean of the facet statistics over replicates and the spread of a single run."""
    rows = []
    for name in ("mean", "footprint", "p99", "max"):
        values = stopped[name]
        rows.append(
            {"quantity": name, "value": values.mean() / stopped["mean"].mean(),
             "relative_stderr": values.std(ddof=1) / values.mean()}
        )  # fmt: skip
    return pd.DataFrame(rows)


def extreme_checks(stopped: pd.DataFrame, table: pd.DataFrame) -> list[Check]:
    """Return checks that extremes over the fixed window do not depend on the length of the run."""
    found = []
    late = stopped["time"] > stopped["time"].median()
    for name in ("footprint", "p99", "max"):
        one, two = stopped[name][late], stopped[name][~late]
        if min(len(one), len(two)) < 20:
            one, two = stopped[name][::2], stopped[name][1::2]
        difference = one.mean() / two.mean() - 1.0
        error = np.hypot(one.std(ddof=1) / np.sqrt(len(one)), two.std(ddof=1) / np.sqrt(len(two)))
        error /= stopped[name].mean()
        spread_of_one = table.set_index("quantity")["relative_stderr"][name]
        found.append(
            Check(f"{name} of facets over the fixed window: long runs against short ones",
                  difference, 0.0, 3.0 * float(error), kind="absolute",
                  note=f"a single run is known to {100 * spread_of_one:.1f} %")
        )  # fmt: skip
    return found


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    intervals, stopped = interval_runs(), stopped_runs()
    table = extremes(stopped)
    found = checks(intervals, fixed_runs(), stopped, fixed_runs(case=_FEW))
    return {
        "checks": checks_table(PART, found + extreme_checks(stopped, table)),
        "replicates": intervals,
        "stopped": stopped.drop(columns=list(STATISTICS)),
        "extremes": table,
    }
