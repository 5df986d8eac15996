"""R2 of the physics-informed models by repeated 5-fold cross-validation of a study's data set.

    snakemake dataset --configfile config.yaml studies/dilute.yaml
    python benchmarks/cross_validation.py config.yaml studies/dilute.yaml

Each row is predicted once in a repeat, by a model that did not see it; rows that repeat each other
are in one fold. R2 is that of all rows of a repeat together. The study itself scores models on
repeated random splits instead, with a fifth of the rows to test: there each split has a mean and a
scatter of its own, so that its scores vary more and lie lower on average.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from abradem.config import read_config, setup_dict
from abradem.learning.physical.models import MODELS, PROCESS, fitted, makers
from abradem.learning.physical.problem import problem
from abradem.learning.protocols import folds
from abradem.learning.scores import r2
from abradem.store.tables import read_table
from abradem.surrogate.groups import group_names, jet_of

FOLDS = 5


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", help="configuration of a study")
    parser.add_argument("--models", nargs="+", choices=MODELS, default=[PROCESS])
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--target", help="wear rate; by default learning.target of the study")
    asked = parser.parse_args()
    config = read_config(*asked.files)
    rows = read_table(Path("results", config.study, "dataset.parquet"))
    target, jet = asked.target or config.learning.target, jet_of(setup_dict(config))
    given = problem(rows, jet, target)
    models = makers(config.seed, groups=group_names(jet))
    print(f"{config.study}, {target}, {len(rows)} rows, {asked.repeats} repeats of {FOLDS} folds")
    for name in asked.models:
        of_wear, of_number = [], []
        for repeat in range(asked.repeats):
            found = np.empty(len(rows))
            for train, test in folds(given.table.groups, FOLDS, config.seed + repeat):
                found[test] = fitted(models[name], given, train).predict(given.groups[test])
            everything = np.arange(len(rows))
            of_wear.append(r2(given.table.target, given.wear(everything, found)))
            of_number.append(r2(given.log_number, found))
        for words, scores in (("the wear", of_wear), ("ln(wear number)", of_number)):
            ends = f"{min(scores):.4f} to {max(scores):.4f}"
            print(f"  {name}: R2 of {words} {np.mean(scores):.4f} on average, {ends}", flush=True)


if __name__ == "__main__":
    main()
