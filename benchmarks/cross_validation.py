"""R2 of the models on a study's data set, by cross-validation and by random splits.

    snakemake dataset --configfile config.yaml studies/dilute.yaml
    python benchmarks/cross_validation.py config.yaml studies/dilute.yaml

Two protocols, both leakage-free, with everything that learns inside the training rows:

- *Repeated cross-validation.* All rows are shuffled into five folds, each row is predicted by the
  model that did not see its fold, and R2 is that of all rows at once; then again with another
  shuffle. Every row counts once in every score, and the variance that R2 divides by is that of the
  whole table. The values differ by the shuffles alone.
- *Random splits* (`learning.repeats`, `learning.test_share`), by which all models of a study are
  compared: R2 of the test rows of each split. Some splits hold few of the largest rates, so these
  scores scatter more, and their mean is lower as R2 is not symmetric.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from abradem.config import read_config, setup_dict
from abradem.learning.physical.models import MODELS, PROCESS, STACKED, fitted, makers
from abradem.learning.physical.problem import problem
from abradem.learning.protocols import folds, repeated_splits
from abradem.learning.scores import r2
from abradem.store.tables import read_table
from abradem.surrogate.groups import group_names, jet_of

FOLDS = 5


def scores_of(given, rows: np.ndarray, predicted: np.ndarray) -> tuple[float, float]:
    """R2 of the wear and of the logarithm of the wear number of some rows."""
    return (
        r2(given.table.target[rows], given.wear(rows, predicted)),
        r2(given.log_number[rows], predicted),
    )


def cross_validated(given, make, shuffle: int) -> tuple[float, float]:
    """Scores of all rows, each predicted without its fold."""
    predicted = np.empty(len(given.log_number))
    for train, test in folds(given.table.groups, FOLDS, shuffle):
        predicted[test] = fitted(make, given, train).predict(given.groups[test])
    return scores_of(given, np.arange(len(predicted)), predicted)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", help="configuration of a study")
    parser.add_argument("--models", nargs="+", choices=MODELS, default=[PROCESS, STACKED])
    parser.add_argument("--target", help="wear rate; by default learning.target of the study")
    parser.add_argument("--shuffles", type=int, default=10, help="repeats of the cross-validation")
    asked = parser.parse_args()
    config = read_config(*asked.files)
    given = problem(
        read_table(Path("results", config.study, "dataset.parquet")),
        jet_of(setup_dict(config)),
        asked.target or config.learning.target,
    )
    learning = config.learning
    for name in asked.models:
        make = makers(config.seed, groups=group_names(given.jet))[name]
        show(
            f"{name}, {asked.shuffles} times {FOLDS} folds",
            [cross_validated(given, make, shuffle) for shuffle in range(asked.shuffles)],
        )
        splits = repeated_splits(
            given.table.keys, given.table.groups, learning.test_share, learning.repeats, config.seed
        )
        show(
            f"{name}, {learning.repeats} random splits",
            [
                scores_of(given, test, fitted(make, given, train).predict(given.groups[test]))
                for train, test in splits
            ],
        )


def show(words: str, scores: list[tuple[float, float]]) -> None:
    """Print mean, median and range of both scores."""
    for what, values in zip(("the wear", "ln(wear number)"), np.transpose(scores), strict=True):
        print(
            f"{words}: R2 of {what} mean {values.mean():.4f}, median {np.median(values):.4f}, "
            f"{values.min():.4f} to {values.max():.4f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
