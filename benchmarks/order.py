"""How well a guess of the computing times orders the simulations, and the fit behind it.

    python benchmarks/order.py results/large results/paper

reads the processor time of every case of finished studies, prints for each how long two cores
would need for its jobs in the order of their numbers, of the guess and of the times themselves, and
fits the constants of `abradem.cost` to all of them.
"""

from __future__ import annotations

import argparse
import heapq
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from abradem import cost
from abradem.config import Config, read_config, setup_dict
from abradem.dataset import read_table
from abradem.shards import shards_of_block

CONSTANTS = (
    "SECONDS_PER_STONE", "SECONDS_IN_A_BED", "BED_RADIUS_EXPONENT", "BED_ANGLE", "BED_SPEED",
)  # fmt: skip


class Study(NamedTuple):
    """The cases of a study that were simulated, and their processor times."""

    config: Config
    cases: pd.DataFrame
    seconds: np.ndarray

    @property
    def guess(self) -> np.ndarray:
        """What `abradem.cost` says of each case now, s."""
        return cost.case_seconds(self.cases, setup_dict(self.config))


def read_study(folder: Path) -> Study:
    """Read a finished study."""
    config = read_config(folder / "config.yaml")
    parts = sorted((folder / "benchmarks" / "cases").glob("*.parquet"))
    if len(parts) != config.sampling.blocks * len(jobs_of_block(config)):
        raise SystemExit(f"{folder}/benchmarks/cases/ holds {len(parts)} tables: not all jobs")
    times = pd.concat(map(read_table, parts))
    cases = read_table(folder / "cases.parquet").merge(times, on="case_id")
    known = cases[cases["rejected"] == ""].reset_index(drop=True)
    return Study(config, known, known["processor_time"].to_numpy())


def jobs_of_block(config: Config) -> list[tuple[int, int]]:
    """First and last-plus-one case of the jobs of a block."""
    return shards_of_block(config.sampling.cases_per_block, config.simulation.cases_per_job)


def fit(studies: list[Study]) -> dict[str, float]:
    """Constants that make the times likely as exponential deviates about the guess.

    That is the mean of cases alike which the sum of a study takes, and errors count relative to
    the time. `abradem.cost` has the constants afterwards.
    """
    seconds = np.concatenate([study.seconds for study in studies])

    def deviance(logarithms):
        for name, value in zip(CONSTANTS, np.exp(logarithms), strict=True):
            setattr(cost, name, value)
        guess = np.concatenate([study.guess for study in studies])
        return np.mean(np.log(guess / seconds) + seconds / guess)

    first = np.log([getattr(cost, name) for name in CONSTANTS])
    found = minimize(deviance, first, method="Nelder-Mead", options={"maxiter": 5000})
    if not found.success:
        raise SystemExit(f"the fit does not converge: {found.message}")
    deviance(found.x)
    return dict(zip(CONSTANTS, np.exp(found.x), strict=True))


def makespan(seconds: np.ndarray, order: np.ndarray, cores: int = 2) -> float:
    """Time until all jobs are done when each core takes the next of the order, s."""
    ends = [0.0] * cores
    for index in order:
        heapq.heappush(ends, heapq.heappop(ends) + seconds[index])
    return max(ends)


def say_how_well(study: Study) -> None:
    """Print how the guess compares with the times."""
    seconds, guess = study.seconds, study.guess
    print(
        f"{study.config.study}: {len(seconds)} cases, {seconds.sum():.0f} s, guessed "
        f"{guess.sum():.0f} s; the longest {seconds.max():.0f} s"
    )
    print(
        f"  correlation of guess and time {np.corrcoef(guess, seconds)[0, 1]:.2f}, "
        f"of logarithms {np.corrcoef(np.log(guess), np.log(seconds))[0, 1]:.2f}, "
        f"of ranks {pd.Series(guess).corr(pd.Series(seconds), method='spearman'):.2f}"
    )
    jobs, cases = jobs_of_block(study.config), study.cases
    row = cases["case_id"] - study.config.sampling.cases_per_block * cases["block"]
    job = cases["block"] * len(jobs) + np.searchsorted([start for start, _ in jobs], row, "right")
    by_job = pd.DataFrame({"spent": seconds, "guess": guess}).groupby(job.to_numpy()).sum()
    spent, guesses = by_job.to_numpy().T
    print(f"  {len(spent)} jobs on two cores: half of the sum {spent.sum() / 2:.1f} s")
    for name, order in (
        ("numbers", np.arange(len(spent))),
        ("the guess", np.argsort(-guesses)),
        ("the times", np.argsort(-spent)),
    ):
        print(f"    in the order of {name}: {makespan(spent, order):.1f} s")


def main() -> None:
    """Compare, fit, compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("studies", nargs="+", type=Path, help="folders: results/paper")
    studies = [read_study(folder) for folder in parser.parse_args().studies]
    for study in studies:
        say_how_well(study)
    before = {name: getattr(cost, name) for name in CONSTANTS}
    print("\nfitted to these times:")
    for name, value in fit(studies).items():
        print(f"  {name} = {value:.3g}, {before[name]:.3g} in abradem.cost")
    for study in studies:
        say_how_well(study)


if __name__ == "__main__":
    main()
