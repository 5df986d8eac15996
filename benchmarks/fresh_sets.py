"""Coverage of the prediction intervals over training sets: on average, and how much it varies.

    snakemake coverage --configfile config.yaml studies/fresh_cases.yaml
    python benchmarks/fresh_sets.py config.yaml studies/fresh_cases.yaml

A study and its fresh cases are one division of the same cases. Here they are divided at random,
again and again, into as many to learn from and as many to test; the Gaussian process and its
conformal intervals, without the distillation, are fitted to the former.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.config import read_config, setup_dict
from abradem.learning.physical.intervals import REPORTED, conformal_of, hold_out_in_turn
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import WearProblem, problem
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of


def shares_inside(given: WearProblem, train: np.ndarray, test: np.ndarray, folds: int, seed: int):
    """Share of the test rows inside the intervals of each reported level."""
    process = fitted(makers(seed)[PROCESS], given, train)
    mean, deviation = process.predict_with_deviation(given.groups[test])
    intervals = conformal_of(given, train, hold_out_in_turn(given, train, folds, seed))
    away = np.abs(given.log_number[test] - mean) / deviation
    return [np.mean(away <= intervals.half(given.groups[test], level)) for level in REPORTED]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", help="configuration of a study with fresh cases")
    parser.add_argument("--divisions", type=int, default=12)
    parser.add_argument("--targets", nargs="+", default=["wear_friction_p99", "wear_friction_mean"])
    asked = parser.parse_args()
    config = read_config(*asked.files)
    folder = Path("results", config.study)
    tables = [read_table(folder / part / "dataset.parquet") for part in ("", "fresh")]
    trained = len(tables[0])
    for target in asked.targets:
        given = problem(pd.concat(tables, ignore_index=True), jet_of(setup_dict(config)), target)
        found = []
        for division in range(asked.divisions):
            rows = np.random.default_rng(division).permutation(len(given.log_number))
            found.append(
                shares_inside(
                    given, np.sort(rows[:trained]), np.sort(rows[trained:]),
                    config.learning.physical.interval_folds, config.seed,
                )
            )  # fmt: skip
        for place, level in enumerate(REPORTED):
            share = 100.0 * np.array(found)[:, place]
            print(
                f"{target}, {100 * level:g} %: {share.mean():.1f} % of the test cases inside, "
                f"{share.min():.1f} to {share.max():.1f} over {asked.divisions} divisions"
            )


if __name__ == "__main__":
    main()
