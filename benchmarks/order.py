"""Quality of the estimated computing times for the order of jobs, and fit of the estimate.

    python benchmarks/order.py results/large results/paper

reads the processor time of every case of finished studies. For each study it prints the time that
two cores would need for its jobs in the order of their numbers, of the estimated times and of the
actual times. It then fits the constants of `abradem.sampling.cost` to all studies of the plate and
prints both. Those of geometries are in `abradem.sampling.surface_cost`.
"""

from __future__ import annotations

import argparse
import heapq
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import least_squares
from study import Study, read_study

from abradem.config import setup_dict
from abradem.sampling import cost
from abradem.store.tables import read_table

POSITIVE = ("case", "second", "particle", "contact")
"""Constants of `abradem.sampling.cost.Costs` that are positive; the others are exponents."""

WEIGHT = 0.2
"""Power of the time by which a case counts in the fit: order and sum depend on expensive cases."""

SPREAD = 0.4
"""Usual difference of the logarithms of time and estimate; larger ones count less."""

HOLD = 1e-3
"""Weight of the constants themselves: what the studies say nothing of stays as it is."""


class Timed(NamedTuple):
    """Completely simulated cases of a study, and their processor times."""

    study: Study
    cases: pd.DataFrame
    seconds: np.ndarray

    def guess(self, costs: cost.Costs = cost.COSTS) -> np.ndarray:
        """Estimate of `abradem.sampling.cost` for each case, s."""
        return cost.case_seconds(self.cases, setup_dict(self.study.config), costs)


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


def fit(studies: list[Timed]) -> cost.Costs:
    """Fit the constants, from the current ones, to the logarithms of all times, robustly."""
    seconds = np.concatenate([study.seconds for study in studies])
    weight = np.clip(seconds, 0.01, 100.0) ** WEIGHT / SPREAD
    positive = np.array([name in POSITIVE for name in cost.Costs._fields])

    def costs_of(numbers):
        with np.errstate(over="ignore"):
            return cost.Costs(*np.where(positive, np.exp(numbers), numbers).tolist())

    def misfit(numbers):
        costs = costs_of(numbers)
        guess = np.concatenate([study.guess(costs) for study in studies])
        return np.concatenate([weight * np.log(seconds / guess), HOLD * (numbers - first)])

    current = np.array(cost.COSTS)
    first = np.where(positive, np.log(np.where(positive, current, 1.0)), current)
    found = least_squares(misfit, first, loss="soft_l1")
    if not found.success:
        raise SystemExit(f"the fit does not converge: {found.message}")
    costs = costs_of(found.x)
    # A sum needs the mean of similar cases; logarithms give their median.
    guess = np.concatenate([study.guess(costs) for study in studies])
    mean = np.exp(0.5 * np.var(np.log(seconds / guess)))
    return costs._replace(**{name: mean * getattr(costs, name) for name in POSITIVE})


def makespan(seconds: np.ndarray, order: np.ndarray, cores: int = 2) -> float:
    """Return the time until all jobs are done if each free core takes the next job, s."""
    ends = [0.0] * cores
    for index in order:
        heapq.heappush(ends, heapq.heappop(ends) + seconds[index])
    return max(ends)


def print_comparison(timed: Timed, costs: cost.Costs = cost.COSTS) -> None:
    """Print a comparison of estimated and actual times."""
    config, cases, seconds = timed.study.config, timed.cases, timed.seconds
    guess = timed.guess(costs)
    print(
        f"{config.study}: {len(seconds)} cases, {seconds.sum():.0f} s, estimated "
        f"{guess.sum():.0f} s; the longest {seconds.max():.0f} s"
    )
    print(
        f"  correlation of estimate and time {np.corrcoef(guess, seconds)[0, 1]:.2f}, "
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
        ("the estimates", np.argsort(-guesses)),
        ("the times", np.argsort(-spent)),
    ):
        print(f"    in the order of {name}: {makespan(spent, order):.1f} s")


def main() -> None:
    """Compare the estimates with the times, fit the constants, and compare again."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("studies", nargs="+", type=Path, help="folders: results/paper")
    studies = [read_times(folder) for folder in parser.parse_args().studies]
    for study in studies:
        print_comparison(study)
    studies = [one for one in studies if one.study.config.simulation.geometry.kind == "plate"]
    if not studies:
        return
    costs = fit(studies)
    print("\nfitted to these times:")
    for name, value, now in zip(cost.Costs._fields, costs, cost.COSTS, strict=True):
        print(f"  {name} = {value:.3g}, {now:.3g} in abradem.sampling.cost")
    for study in studies:
        print_comparison(study, costs)


if __name__ == "__main__":
    main()
