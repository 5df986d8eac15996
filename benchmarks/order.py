"""How well a guess of the computing times orders the simulations, and the fit behind it.

    python benchmarks/order.py config.yaml --blocks 2 --table results/benchmarks/order.csv

times every case of a study's first blocks (processor time of one core), fits the constants of
`abradem.cost` to them, and prints how long two cores would need for the shards in the order of
their numbers, of the guess and of the times themselves. With a table that exists, it reads the
times from there.
"""

from __future__ import annotations

import argparse
import heapq
import time
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from abradem import cost
from abradem.config import read_config, sampled_ranges, setup_dict
from abradem.sampling import block_cases
from abradem.shards import run_case, setup_from_dict, shards_of_block

CONSTANTS = (
    "SECONDS_PER_STONE", "SECONDS_IN_A_BED", "BED_RADIUS_EXPONENT", "BED_ANGLE", "BED_SPEED",
)  # fmt: skip


def timed(cases: pd.DataFrame, setup: dict) -> np.ndarray:
    """Processor time of each case, s; shape (n,)."""
    rows = cases.to_dict("records")
    # The first call loads compiled code.
    run_case(max(rows, key=lambda row: row["particle_radius"]), setup)
    seconds = []
    for row in rows:
        start = time.process_time()
        run_case(row, setup)
        seconds.append(time.process_time() - start)
    return np.array(seconds)


def fitted(cases: pd.DataFrame, setup: dict, seconds: np.ndarray) -> dict[str, float]:
    """Constants of `abradem.cost` that fit measured times, in logarithms, robustly."""

    def residuals(logarithms):
        for name, value in zip(CONSTANTS, np.exp(logarithms), strict=True):
            setattr(cost, name, value)
        return np.log(cost.case_seconds(cases, setup) / seconds)

    first = np.log([getattr(cost, name) for name in CONSTANTS])
    found = least_squares(residuals, first, loss="soft_l1").x
    residuals(first)
    return dict(zip(CONSTANTS, np.exp(found), strict=True))


def makespan(seconds: np.ndarray, order: np.ndarray, cores: int = 2) -> float:
    """Time until all jobs are done when each core takes the next of the order, s."""
    ends = [0.0] * cores
    for index in order:
        heapq.heappush(ends, heapq.heappop(ends) + seconds[index])
    return max(ends)


def main() -> None:
    """Time, fit and compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config", nargs="+", help="configuration and overlays")
    parser.add_argument("--blocks", type=int, default=2)
    parser.add_argument("--table", type=Path, default=Path("results/benchmarks/order.csv"))
    arguments = parser.parse_args()

    config = read_config(*arguments.config)
    sampling, setup = config.sampling, setup_dict(config)
    cases = pd.concat(
        [
            block_cases(
                config.seed, block, sampling.cases_per_block, sampling.method,
                sampled_ranges(config), setup_from_dict(setup),
            )
            for block in range(arguments.blocks)
        ],
        ignore_index=True,
    )  # fmt: skip
    if not arguments.table.exists():
        arguments.table.parent.mkdir(parents=True, exist_ok=True)
        times = pd.DataFrame({"case_id": cases["case_id"], "seconds": timed(cases, setup)})
        times.to_csv(arguments.table, index=False)
    times = pd.read_csv(arguments.table)
    known = cases.merge(times, on="case_id")
    known = known[known["rejected"] == ""].reset_index(drop=True)
    seconds = known["seconds"].to_numpy()
    guess = cost.case_seconds(known, setup)
    print(f"{len(known)} cases, {seconds.sum():.0f} s, the longest {seconds.max():.0f} s")
    print(
        f"correlation of guess and time {np.corrcoef(guess, seconds)[0, 1]:.2f}, "
        f"of logarithms {np.corrcoef(np.log(guess), np.log(seconds))[0, 1]:.2f}, "
        f"of ranks {pd.Series(guess).corr(pd.Series(seconds), method='spearman'):.2f}"
    )
    for name, value in fitted(known, setup, seconds).items():
        print(f"  {name} = {value:.3g} by this fit, {getattr(cost, name):.3g} in abradem.cost")
    shards = shards_of_block(sampling.cases_per_block, config.simulation.cases_per_job)
    starts = [
        block * sampling.cases_per_block + start
        for block in range(arguments.blocks)
        for start, _ in shards
    ]
    shard = np.searchsorted(starts, known["case_id"], side="right")
    by_shard = known.assign(guess=guess).groupby(shard)[["seconds", "guess"]].sum().to_numpy()
    jobs, guesses = by_shard.T
    for name, order in (
        ("numbers", np.arange(len(jobs))),
        ("the guess", np.argsort(-guesses)),
        ("the times", np.argsort(-jobs)),
    ):
        print(f"two cores, in the order of {name}: {makespan(jobs, order):.1f} s")
    print(f"half of the sum: {jobs.sum() / 2:.1f} s")


if __name__ == "__main__":
    main()
