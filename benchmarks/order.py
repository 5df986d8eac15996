"""How well a guess of the computing times orders the simulations, and the fit behind it.

    python benchmarks/order.py results/large results/paper

reads the processor time of every case of finished studies, prints for each how long two cores
would need for its jobs in the order of their numbers, of the guess and of the times themselves, and
fits the constants of `abradem.sampling.cost` to all of them.
"""

from __future__ import annotations

import argparse
import heapq
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from study import Study, read_study

from abradem.config import setup_dict
from abradem.sampling import cost
from abradem.store.tables import read_table

CONSTANTS = (
    "SECONDS_PER_PARTICLE", "SECONDS_IN_A_BED", "BED_RADIUS_EXPONENT", "BED_ANGLE", "BED_SPEED",
)  # fmt: skip


class Timed(NamedTuple):
    """Cases of a study that were simulated to their end, and their processor times."""

    study: Study
    cases: pd.DataFrame
    seconds: np.ndarray

    @property
    def guess(self) -> np.ndarray:
        """What `abradem.sampling.cost` says of each case now, s."""
        return cost.case_seconds(self.cases, setup_dict(self.study.config))


def read_times(folder: Path) -> Timed:
    """Read a finished study."""
    study = read_study(folder)
    blocks = range(study.config.sampling.blocks)
    cases = pd.concat(
        read_table(folder / "cases" / f"block-{block:03d}.parquet") for block in blocks
    )
    runs, times = pd.concat(study.runs), pd.concat(study.times)
    ended = runs.loc[runs["status"] == "ok", ["case_id"]]
    known = cases.merge(ended, on="case_id").merge(times, on="case_id")
    if known.empty or not (known["processor_time"] > 0.0).all():
        raise SystemExit(f"{folder}: no case was simulated, or one took no time")
    return Timed(study, known, known["processor_time"].to_numpy())


def fit(studies: list[Timed]) -> dict[str, float]:
    """Constants that make the times likely as exponential deviates about the guess.

    That is the mean of cases alike which the sum of a study takes, and errors count relative to
    the time. `abradem.sampling.cost` has the constants afterwards.
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


def say_how_well(timed: Timed) -> None:
    """Print how the guess compares with the times."""
    config, cases, seconds, guess = timed.study.config, timed.cases, timed.seconds, timed.guess
    print(
        f"{config.study}: {len(seconds)} cases, {seconds.sum():.0f} s, guessed "
        f"{guess.sum():.0f} s; the longest {seconds.max():.0f} s"
    )
    print(
        f"  correlation of guess and time {np.corrcoef(guess, seconds)[0, 1]:.2f}, "
        f"of logarithms {np.corrcoef(np.log(guess), np.log(seconds))[0, 1]:.2f}, "
        f"of ranks {pd.Series(guess).corr(pd.Series(seconds), method='spearman'):.2f}"
    )
    batches = config.batches
    row = cases["case_id"] - config.sampling.cases_per_block * cases["block"]
    job = cases["block"] * len(batches) + np.searchsorted([a for a, _ in batches], row, "right")
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
    studies = [read_times(folder) for folder in parser.parse_args().studies]
    for study in studies:
        say_how_well(study)
    before = {name: getattr(cost, name) for name in CONSTANTS}
    print("\nfitted to these times:")
    for name, value in fit(studies).items():
        print(f"  {name} = {value:.3g}, {before[name]:.3g} in abradem.sampling.cost")
    for study in studies:
        say_how_well(study)


if __name__ == "__main__":
    main()
