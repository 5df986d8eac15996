"""Part 5: is the standard error honest, and does stopping on it bias the mean?

Replicates of one cheap jet that differ in the seed only. The truth is the mean of all of them.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from abradem.verification.jets import JET, jet_case, rate_of, run, spread
from abradem.verification.table import Check, checks_table
from abradem.wear_rate import facet_rates

PART = 5
REPLICATES = 480
STOPPED = 240
_FIXED = 20.0
"""s. Stones come evenly, which makes the error of a run too large by a share that falls with its
length: 4 % at 10 s, where 96.2 % of 1920 intervals hold the mean."""

_BATCHES = 20
_CASE = {"plate_angle": 30.0, "particle_radius": 0.015}
_FEW = {"plate_angle": 50.0, "particle_radius": 0.03}
"""So few stones (6 a batch) that their even spacing in time shows."""


def fixed_runs(replicates: int = REPLICATES, case: dict = _CASE) -> pd.DataFrame:
    """Rate and standard error of runs of one length, and whether the 95 % interval holds."""
    rows = []
    for seed in range(replicates):
        result = run(jet_case(seed=seed, **case), JET.setup(duration=_FIXED, sample_interval=0.05))
        rate = rate_of(result)
        rows.append({"replicate": seed, "rate": rate.value, "rate_stderr": rate.stderr})
    frame = pd.DataFrame(rows)
    reach = stats.t.ppf(0.975, _BATCHES - 1) * frame["rate_stderr"]
    frame["covered"] = ((frame["rate"] - frame["rate"].mean()).abs() <= reach).astype(float)
    return frame


def stopped_runs(replicates: int = STOPPED) -> pd.DataFrame:
    """Rate of runs that the stop rule ended, and the facet statistics of their windows."""
    rows = []
    for seed in range(replicates):
        setup = JET.setup(window=3.0, max_time=20.0, target_stderr=0.03, sample_interval=0.05)
        result = run(jet_case(seed=seed, **_CASE), setup)
        rate = rate_of(result, start=result.steady_from)
        rows.append(
            {"replicate": seed, "rate": rate.value, "rate_stderr": rate.stderr,
             "time": result.simulated_time, **_facets(result, setup)}
        )  # fmt: skip
    return pd.DataFrame(rows)


def _facets(result, setup) -> dict:
    """Statistics over the facets of ``total`` in the window, W/m2 for W = 1."""
    wear = result.facet_wear[0]
    seconds = result.window[1] - result.window[0]
    mean = float(wear.sum()) / (setup.plate_area * seconds)
    return {"mean": mean, **facet_rates(wear, setup.plate_area / wear.size, seconds)}


def _typical(fixed: pd.DataFrame) -> float:
    return float(np.sqrt((fixed["rate_stderr"] ** 2).mean()))


def checks(fixed: pd.DataFrame, stopped: pd.DataFrame, few: pd.DataFrame) -> list[Check]:
    """Coverage, size of the standard error, bias of the stop rule, spread of the extremes."""
    count = len(fixed)
    low, high = stats.binom.ppf([0.025, 0.975], count, 0.95) / count
    truth, truth_error = spread(fixed["rate"])
    mean, mean_error = spread(stopped["rate"])
    sd = fixed["rate"].std(ddof=1)
    # Relative standard error of a spread that is estimated from so many values.
    spread_error = 1.0 / np.sqrt(2.0 * (count - 1))
    found = [
        Check(f"95 % intervals that hold the mean, of {count} replicates", fixed["covered"].mean(),
              0.5 * (low + high), 0.5 * (high - low), kind="absolute",
              note=f"binomial band {low:.3f} to {high:.3f}"),
        Check("standard error over the spread between replicates", _typical(fixed) / sd, 1.0,
              3.0 * spread_error, note="three standard errors of the spread"),
        Check("mean of runs ended by the stop rule", mean, truth,
              2.0 * float(np.hypot(mean_error, truth_error)), "W", "absolute",
              note="two standard errors of the difference"),
        Check("few stones: standard error over the spread between replicates",
              _typical(few) / few["rate"].std(ddof=1), 1.0 - 3.0 * spread_error, kind="at least",
              note="stones are released evenly, batches hold one more or one less: the error is "
                   "an upper bound where a batch holds few"),
    ]  # fmt: skip
    return found


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
    """Extremes over one fixed window do not depend on when the run was ended."""
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
    fixed, stopped = fixed_runs(), stopped_runs()
    table = extremes(stopped)
    found = checks(fixed, stopped, fixed_runs(STOPPED, _FEW)) + extreme_checks(stopped, table)
    return {
        "checks": checks_table(PART, found),
        "replicates": fixed,
        "stopped": stopped.drop(columns=["mean", "footprint", "p99", "max"]),
        "extremes": table,
    }
