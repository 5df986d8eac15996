"""Fit and evaluation of the models on dimensionless groups, for every wear rate."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, NOT_IDENTIFIED, of_kind
from abradem.learning.evaluation import Results
from abradem.learning.physical.ensembles import Boosting, Networks
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.noise_terms import noise_terms
from abradem.learning.physical.power_law import SHARES, PowerLaw
from abradem.learning.physical.problem import WearProblem, problem
from abradem.learning.physical.stacked import Stacked
from abradem.learning.protocols import LEAKAGE_FREE, repeated_splits
from abradem.learning.repeated_rows import repeats_among
from abradem.learning.scores import central, middle_of, r2, scores_of
from abradem.quantities import FEATURE_NAMES, GEOMETRY_NAMES, WEAR_COLUMNS
from abradem.surrogate.groups import GROUP_NAMES, Jet, group_names, input_names

POWER_LAW, PROCESS, BOOSTING, NETWORKS, STACKED = MODELS = (
    "power_law", "gaussian_process", "boosting", "networks", "stacked",
)  # fmt: skip


VELOCITY = "particle_velocity_y"
"""The speed of impact varies with it alone, as all particles fall from the same height."""

BEST = PROCESS
"""The model behind intervals, sensitivity and surrogate."""


def makers(
    seed: int,
    boosting: dict | None = None,
    networks: dict | None = None,
    groups: Sequence[str] = GROUP_NAMES,
) -> dict:
    """Constructors of the models, by name.

    Parameters
    ----------
    seed : int
    boosting, networks : dict, optional
        Options of the models.
    groups : sequence of str
        Names of the groups, see `abradem.surrogate.groups.group_names`.
    """

    def process():
        return GaussianProcess(seed, noise_terms)

    def boosted():
        return Boosting(**(boosting or {}), seed=seed)

    return {
        POWER_LAW: lambda: PowerLaw(groups),
        PROCESS: process,
        BOOSTING: boosted,
        NETWORKS: lambda: Networks(**(networks or {}), seed=seed),
        STACKED: lambda: Stacked(process, boosted, seed),
    }


def fitted(make: Callable, given: WearProblem, rows: np.ndarray):
    """Fit a new model to some rows of a problem."""
    return make().fit(given.groups[rows], given.log_number[rows], given.error[rows])


def evaluate(
    given: WearProblem,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
) -> Results:
    """Score models on the test rows of repeated splits; they see training rows only.

    Parameters
    ----------
    given : WearProblem
    models : dict of str to callable
        Constructors, from `makers`.
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    """
    results = Results(given.table)
    splits = list(repeated_splits(given.table.keys, given.table.groups, test_share, repeats, seed))
    for name, make in models.items():
        for repeat, (train, test) in enumerate(splits):
            model = fitted(make, given, train)
            floor = float(given.table.target[train].min())
            for split, rows in (("train", train), ("test", test)):
                wear = given.wear(rows, model.predict(given.groups[rows]))
                results.add(
                    name, LEAKAGE_FREE, split, repeat, rows, wear, floor, keep=split == "test"
                )
    return results


def fit_physical(
    given: WearProblem,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
    confidence: float = 0.95,
) -> tuple[Results, pd.DataFrame, dict, tuple[dict, dict]]:
    """Score the models, and fit power law and Gaussian process to all rows.

    Parameters
    ----------
    given : WearProblem
    models : dict of str to callable
        Constructors, from `makers`.
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    confidence : float
        Central share of the splits that the intervals of the scores contain.

    Returns
    -------
    results : Results
    exponents : pandas.DataFrame
        See `PowerLaw.exponents`.
    summary : dict
        ``rows``, their number; ``repeated``, those that repeat others, see
        `abradem.learning.repeated_rows.repeats_among`; ``equation``, ``equation_tex`` and
        ``scatter`` of the power law, and the ``exponents`` of the quantities; ``held_fixed`` and
        ``not_identified``, the sampled quantities on which the rows say nothing alone;
        ``lengths`` of the process (in standard deviations of each group), its ``noise``, and
        ``outliers``, the cases with a weight below 0.5; ``raised``, see `WearProblem`;
        ``scores`` of each model.
    process : tuple of dict
        Description and arrays of the Gaussian process.
    """
    results = evaluate(given, models, test_share, repeats, seed)
    everything = np.arange(len(given.log_number))
    law = fitted(models[POWER_LAW], given, everything)
    exponents = law.exponents(fixed_quantities(given), given.jet.mass_rate is None)
    process = fitted(models[PROCESS], given, everything)
    scores = {name: scores_of(results.scores, name, LEAKAGE_FREE, confidence) for name in models}
    names = input_names(given.jet)
    # If the process was fitted to a subset, its weights do not match the rows.
    doubted = process.weights < 0.5 if len(process.weights) == len(everything) else []
    summary = {
        "rows": len(everything),
        "repeated": repeats_among(given.table.groups, given.table.keys),
        "equation": law.equation(),
        "equation_tex": law.equation_tex(),
        "scatter": law.scatter,
        "exponents": exponents[exponents["kind"] == "quantity"].to_dict("records"),
        "held_fixed": of_kind(names, given.variation, HELD_FIXED),
        "not_identified": of_kind(names, given.variation, NOT_IDENTIFIED),
        "lengths": dict(zip(group_names(given.jet), process.lengths, strict=True)),
        "noise": process.noise,
        "outliers": [int(key) for key in given.table.keys[np.flatnonzero(doubted)]],
        "raised": given.raised,
        "scores": scores,
    }
    description = {
        "model": PROCESS,
        "kind": "gaussian_process",
        "protocol": LEAKAGE_FREE,
        "table": given.table.name,
        "training_rows": len(everything),
        "dataset_hash": given.table.hash,
        "groups": list(group_names(given.jet)),
        "jet": given.jet.stored(),
        "target": {"name": given.table.target_name, "unit": given.table.unit},
        "scores": scores[PROCESS],
    }
    return results, exponents, summary, (description, process.arrays())


def fixed_quantities(given: WearProblem) -> list[str]:
    """Quantities of the power law (`PowerLaw.shares`) that were held fixed."""
    fixed = set(of_kind(input_names(given.jet), given.variation, HELD_FIXED))
    fixed |= {
        name for place, name in enumerate(given.table.names) if place not in given.table.varied
    }
    of_plate = [name for name in SHARES if (name if name in FEATURE_NAMES else VELOCITY) in fixed]
    return of_plate + [name for name in GEOMETRY_NAMES if name in fixed]


def all_targets(
    dataset: pd.DataFrame,
    jet: Jet,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 5,
    seed: int = 0,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """R2 for every wear rate of the data set: each wear measure and statistic over the plate.

    Parameters
    ----------
    dataset : pandas.DataFrame
        See `abradem.learning.physical.problem.problem`.
    jet : Jet
    models : dict of str to callable
        Constructors, from `makers`.
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    confidence : float
        Central share of the splits between r2_lower and r2_upper.

    Returns
    -------
    pandas.DataFrame
        target, model, repeats (splits with a defined R2), r2 (their median), r2_lower, r2_upper,
        r2_log (median R2 of ln y), r2_number (median R2 of the logarithm of the wear number),
        raised (number of targets that were not positive).
    """
    rows = []
    for target in WEAR_COLUMNS:
        if target not in dataset or not (dataset[target] > 0.0).any():
            continue
        given = problem(dataset, jet, target)
        y = given.table.target
        for name, make in models.items():
            raw, logarithmic, numbers = [], [], []
            for train, test in repeated_splits(
                given.table.keys, given.table.groups, test_share, repeats, seed
            ):
                predicted = fitted(make, given, train).predict(given.groups[test])
                raw.append(r2(y[test], given.wear(test, predicted)))
                numbers.append(r2(given.log_number[test], predicted))
                logarithmic.append(
                    r2(given.log_number[test] + np.log(given.scale[test]),
                       predicted + np.log(given.scale[test]))
                )  # fmt: skip
            scored, *ends = central(raw, confidence)
            rows.append(
                (target, name, scored, *ends, middle_of(logarithmic), middle_of(numbers),
                 given.raised)
            )  # fmt: skip
    columns = [
        "target", "model", "repeats", "r2", "r2_lower", "r2_upper", "r2_log", "r2_number", "raised",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)
