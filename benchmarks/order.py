"""How well a guess of the computing times orders the simulations, and the fit behind it.

    python benchmarks/order.py results/paper

reads the processor time of every case of a finished study, fits the constants of `abradem.cost`
to them, and prints how long two cores would need for its jobs in the order of their numbers, of
the guess and of the times themselves.
"""

from __future__ import annotations

import argparse
import heapq
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from abradem import cost
from abradem.config import read_config, setup_dict
from abradem.dataset import read_table
from abradem.shards import shards_of_block

CONSTANTS = (
    "SECONDS_PER_STONE", "SECONDS_IN_A_BED", "BED_RADIUS_EXPONENT", "BED_ANGLE", "BED_SPEED",
)  # fmt: skip


def fitted(cases: pd.DataFrame, setup: dict, seconds: np.ndarray) -> dict[str, float]:
    """Constants that fit measured times, in logarithms, robustly; `abradem.cost` then has them."""

    def residuals(logarithms):
        for name, value in zip(CONSTANTS, np.exp(logarithms), strict=True):
            setattr(cost, name, value)
        return np.log(cost.case_seconds(cases, setup) / seconds)

    first = np.log([getattr(cost, name) for name in CONSTANTS])
    found = least_squares(residuals, first, loss="soft_l1").x
    residuals(found)
    return dict(zip(CONSTANTS, np.exp(found), strict=True))


def makespan(seconds: np.ndarray, order: np.ndarray, cores: int = 2) -> float:
    """Time until all jobs are done when each core takes the next of the order, s."""
    ends = [0.0] * cores
    for index in order:
        heapq.heappush(ends, heapq.heappop(ends) + seconds[index])
    return max(ends)


def main() -> None:
    """Fit and compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("study", type=Path, help="folder of a finished study: results/paper")
    folder = parser.parse_args().study

    config = read_config(folder / "config.yaml")
    setup, per_block = setup_dict(config), config.sampling.cases_per_block
    jobs = shards_of_block(per_block, config.simulation.cases_per_job)
    parts = sorted((folder / "benchmarks" / "cases").glob("*.parquet"))
    if len(parts) != config.sampling.blocks * len(jobs):
        raise SystemExit(f"{folder}/benchmarks/cases/ holds {len(parts)} tables: not all jobs")
    times = pd.concat(read_table(part) for part in parts)
    cases = read_table(folder / "cases.parquet").merge(times, on="case_id")
    known = cases[cases["rejected"] == ""].reset_index(drop=True)
    seconds = known["processor_time"].to_numpy()
    guess = cost.case_seconds(known, setup)
    print(
        f"{len(known)} cases, {seconds.sum():.0f} s, guessed {guess.sum():.0f} s; "
        f"the longest {seconds.max():.0f} s"
    )
    print(
        f"correlation of guess and time {np.corrcoef(guess, seconds)[0, 1]:.2f}, "
        f"of logarithms {np.corrcoef(np.log(guess), np.log(seconds))[0, 1]:.2f}, "
        f"of ranks {pd.Series(guess).corr(pd.Series(seconds), method='spearman'):.2f}"
    )
    before = {name: getattr(cost, name) for name in CONSTANTS}
    for name, value in fitted(known, setup, seconds).items():
        print(f"  {name} = {value:.3g} by this fit, {before[name]:.3g} in abradem.cost")
    print(f"guessed by this fit {cost.case_seconds(known, setup).sum():.0f} s")

    row = known["case_id"] - per_block * known["block"]
    job = known["block"] * len(jobs) + np.searchsorted([start for start, _ in jobs], row, "right")
    by_job = known.assign(guess=guess).groupby(job)[["processor_time", "guess"]].sum().to_numpy()
    spent, guesses = by_job.T
    for name, order in (
        ("numbers", np.arange(len(spent))),
        ("the guess", np.argsort(-guesses)),
        ("the times", np.argsort(-spent)),
    ):
        print(f"two cores, in the order of {name}: {makespan(spent, order):.1f} s")
    print(f"half of the sum: {spent.sum() / 2:.1f} s")


if __name__ == "__main__":
    main()
