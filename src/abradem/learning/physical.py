"""The models that learn physics: one problem, one protocol, four models, every target.

Each predicts the logarithm of the wear number from dimensionless groups
(`abradem.learning.groups`) and multiplies the scale back:

``power_law``           `abradem.learning.power_law`, transparent
``gaussian_process``    `abradem.learning.gaussian_process`, the best; decided beforehand, not by
                        the test rows, and used for intervals, sensitivity and the surrogate
``boosting``, ``networks``  `abradem.learning.ensembles`

Scores are those of the honest protocol, on the same splits as the other models of the study.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset import WEAR_COLUMNS
from abradem.learning.ensembles import Boosting, Networks
from abradem.learning.evaluation import Results
from abradem.learning.gaussian_process import GaussianProcess
from abradem.learning.groups import GROUP_NAMES, Jet, group_matrix, wear_scale
from abradem.learning.power_law import PowerLaw
from abradem.learning.protocols import HONEST, repeated_splits
from abradem.learning.scores import r2, scores_of
from abradem.learning.table import Table, learning_table
from abradem.parameters import SAMPLED_NAMES

POWER_LAW, PROCESS, BOOSTING, NETWORKS = MODELS = (
    "power_law", "gaussian_process", "boosting", "networks",
)  # fmt: skip
BEST = PROCESS
STDERR = "wear_total_mean_stderr"
HEADLINE = "wear_total_mean"


class Problem(NamedTuple):
    """Rows to learn from, in the order of their case numbers.

    ``inputs`` (n, 14) the sampled quantities, ``groups`` (n, 10), ``scale`` (n,) in mm/s,
    ``log_number`` (n,) logarithm of the wear number, ``error`` (n,) relative standard error of
    the simulation (0 where none is known), ``raised`` how many targets were not positive and
    count as the smallest wear number that is.
    """

    table: Table
    inputs: np.ndarray
    groups: np.ndarray
    scale: np.ndarray
    log_number: np.ndarray
    error: np.ndarray
    jet: Jet
    raised: int

    def wear(self, rows: np.ndarray, log_number: np.ndarray) -> np.ndarray:
        """Wear depth rate of rows, mm/s, from the logarithm of the wear number."""
        return self.scale[rows] * np.exp(log_number)


def problem(
    dataset: pd.DataFrame, jet: Jet, target: str = HEADLINE, name: str = "dataset", fewest: int = 3
) -> Problem:
    """What the models of this module learn from.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds case_id, the 20 features and ``target``, and of simulations the standard error.
    jet : Jet
    target : str
        A wear-rate column, mm/s.
    name : str
        What the scores call the table.
    fewest : int
        Least number of rows.
    """
    table = learning_table(dataset, target, name, fewest)
    rows = dataset.sort_values("case_id", ignore_index=True)
    columns = {key: rows[key].to_numpy(dtype=float) for key in SAMPLED_NAMES}
    scale = wear_scale(columns, jet)
    number = table.target / scale
    positive = number > 0.0
    if not positive.any():
        raise ValueError(f"dataset: {target} is nowhere positive, there is nothing to learn")
    # What a statistic over facets says of a plate that stays untouched.
    number = np.where(positive, number, number[positive].min())
    error = np.zeros(len(rows))
    if target == HEADLINE and STDERR in rows:
        error = rows[STDERR].to_numpy(dtype=float) / table.target
        error = np.where(np.isfinite(error), error, np.nanmax(error, initial=0.0))
    return Problem(
        table,
        np.column_stack([columns[key] for key in SAMPLED_NAMES]),
        group_matrix(columns, jet),
        scale,
        np.log(number),
        error,
        jet,
        int(np.sum(~positive)),
    )


def makers(seed: int, boosting: dict | None = None, networks: dict | None = None) -> dict:
    """Constructors of the four models, by name."""
    return {
        POWER_LAW: PowerLaw,
        PROCESS: lambda: GaussianProcess(seed),
        BOOSTING: lambda: Boosting(**(boosting or {}), seed=seed),
        NETWORKS: lambda: Networks(**(networks or {}), seed=seed),
    }


def fitted(make: Callable, given: Problem, rows: np.ndarray):
    """A model fitted to some rows of a problem."""
    return make().fit(given.groups[rows], given.log_number[rows], given.error[rows])


def evaluate(
    given: Problem,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
) -> Results:
    """Scores of models on the test rows of repeated splits; each sees training rows alone."""
    results = Results(given.table)
    splits = list(repeated_splits(given.table.keys, test_share, repeats, seed))
    for name, make in models.items():
        for repeat, (train, test) in enumerate(splits):
            model = fitted(make, given, train)
            floor = float(given.table.target[train].min())
            for split, rows in (("train", train), ("test", test)):
                wear = given.wear(rows, model.predict(given.groups[rows]))
                results.add(name, HONEST, split, repeat, rows, wear, floor, keep=split == "test")
    return results


def fit_physical(
    given: Problem,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
    confidence: float = 0.95,
) -> tuple[Results, pd.DataFrame, dict, tuple[dict, dict]]:
    """Scores of the models, and power law and Gaussian process of all rows.

    Returns
    -------
    results : Results
    exponents : pandas.DataFrame
        See `PowerLaw.exponents`.
    summary : dict
        ``equation``, ``equation_tex`` and ``scatter`` of the power law; ``lengths`` of the
        process (in standard deviations of each group), its ``noise``, and ``outliers``, the rows
        whose weight fell below a half; ``scores`` of each model.
    process : tuple of dict
        Description and arrays of the Gaussian process.
    """
    results = evaluate(given, models, test_share, repeats, seed)
    everything = np.arange(len(given.log_number))
    law = fitted(models[POWER_LAW], given, everything)
    process = fitted(models[PROCESS], given, everything)
    scores = {name: scores_of(results.scores, name, HONEST, confidence) for name in models}
    # Of a table that was thinned the weights belong to other rows.
    doubted = process.weights < 0.5 if len(process.weights) == len(everything) else []
    summary = {
        "equation": law.equation(),
        "equation_tex": law.equation_tex(),
        "scatter": law.scatter,
        "lengths": dict(zip(GROUP_NAMES, process.lengths, strict=True)),
        "noise": process.noise,
        "outliers": [int(key) for key in given.table.keys[np.flatnonzero(doubted)]],
        "raised": given.raised,
        "scores": scores,
    }
    description = {
        "model": PROCESS,
        "kind": "gaussian_process",
        "protocol": HONEST,
        "table": given.table.name,
        "training_rows": len(everything),
        "dataset_hash": given.table.hash,
        "groups": list(GROUP_NAMES),
        "jet": given.jet._asdict(),
        "target": {"name": given.table.target_name, "unit": given.table.unit},
        "scores": scores[PROCESS],
    }
    return results, law.exponents(), summary, (description, process.arrays())


def all_targets(
    dataset: pd.DataFrame,
    jet: Jet,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 5,
    seed: int = 0,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """R2 of every target that the data set holds: each reading, each statistic over the plate.

    Returns
    -------
    pandas.DataFrame
        target, model, repeats, r2 (median over the splits, raw target), r2_lower, r2_upper,
        r2_log (median, of ln y), raised (targets that were not positive).
    """
    tail = 50.0 * (1.0 - confidence)
    rows = []
    for target in WEAR_COLUMNS:
        if target not in dataset or not (dataset[target] > 0.0).any():
            continue
        given = problem(dataset, jet, target)
        y = given.table.target
        for name, make in models.items():
            raw, logarithmic = [], []
            for train, test in repeated_splits(given.table.keys, test_share, repeats, seed):
                predicted = fitted(make, given, train).predict(given.groups[test])
                raw.append(r2(y[test], given.wear(test, predicted)))
                logarithmic.append(
                    r2(given.log_number[test] + np.log(given.scale[test]),
                       predicted + np.log(given.scale[test]))
                )  # fmt: skip
            low, middle, high = np.percentile(raw, [tail, 50.0, 100.0 - tail])
            rows.append(
                (target, name, repeats, middle, low, high, np.median(logarithmic), given.raised)
            )
    columns = [
        "target", "model", "repeats", "r2", "r2_lower", "r2_upper", "r2_log", "raised",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)
