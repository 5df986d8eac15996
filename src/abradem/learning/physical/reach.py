"""Learning curves (fewer training cases) and extrapolation beyond the training ranges."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, of_kind
from abradem.learning.physical.intervals import conformal_of, hold_out_in_turn
from abradem.learning.physical.models import PROCESS, fitted
from abradem.learning.physical.problem import WearProblem
from abradem.learning.protocols import CURVE, folds, repeated_splits
from abradem.learning.scores import central, middle_of, r2, score
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import input_names
from abradem.surrogate.model import highest_level

SMALLEST = 25
"""Number of training rows at the start of a learning curve."""

FEWEST_TRAINED, FEWEST_TESTED = 8, 5
"""Smallest numbers of training and test rows in a test of extrapolation."""

LEVEL = 0.95
"""Level of the intervals whose coverage beyond the ranges is computed."""


class Beyond(NamedTuple):
    """A test of extrapolation: rows with one quantity beyond a bound are held out."""

    name: str
    quantity: str
    words: str
    outside: Callable[[np.ndarray], np.ndarray]


TESTS = (
    Beyond("fast", "particle_velocity_y", "faster than 8 m/s", lambda v: v < -8.0),
    Beyond("steep", "plate_angle", "plate steeper than 60°", lambda a: a > 60.0),
    Beyond("large", "particle_radius", "largest fifth of the particles",
           lambda r: r > np.quantile(r, 0.8)),
)  # fmt: skip


def sizes(most: int) -> list[int]:
    """Numbers of training rows: doubled from `SMALLEST` on, with all ``most`` rows last."""
    found = []
    size = SMALLEST
    while size < 0.75 * most:
        found.append(size)
        size *= 2
    return [*found, most]


def learning_curve(
    given: WearProblem,
    models: dict[str, Callable],
    test_share: float = 0.2,
    repeats: int = 10,
    seed: int = 0,
    confidence: float = 0.95,
) -> pd.DataFrame:
    """R2 on the same held-out rows for increasing numbers of training rows.

    Parameters
    ----------
    given : WearProblem
    models : dict of str to callable
        Constructors, from `abradem.learning.physical.models.makers`.
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    confidence : float
        Central share of the splits between r2_lower and r2_upper.

    Returns
    -------
    pandas.DataFrame
        model, trained (number of rows), repeats (splits with a defined R2), r2 (their median),
        r2_lower, r2_upper, r2_number (median R2 of the logarithm of the wear number).
    """
    y = given.table.target
    splits = list(repeated_splits(given.table.keys, given.table.groups, test_share, repeats, seed))
    rows = []
    for name, make in models.items():
        for size in sizes(len(splits[0][0])):
            found, numbers = [], []
            for repeat, (train, test) in enumerate(splits):
                kept = np.random.default_rng([seed, repeat, CURVE]).permutation(train)[:size]
                model = fitted(make, given, np.sort(kept))
                predicted = model.predict(given.groups[test])
                found.append(r2(y[test], given.wear(test, predicted)))
                numbers.append(r2(given.log_number[test], predicted))
            rows.append((name, size, *central(found, confidence), middle_of(numbers)))
    columns = ["model", "trained", "repeats", "r2", "r2_lower", "r2_upper", "r2_number"]
    return pd.DataFrame(rows, columns=columns)


def extrapolate(given: WearProblem, models: dict[str, Callable], seed: int = 0) -> pd.DataFrame:
    """Scores on rows beyond a bound, for models trained on the other rows.

    For comparison, the same rows are also predicted by cross-validation over all rows, that is by
    models that were trained on similar cases.

    Parameters
    ----------
    given : WearProblem
    models : dict of str to callable
        Constructors, from `abradem.learning.physical.models.makers`.
    seed : int

    Returns
    -------
    pandas.DataFrame
        test, words, model, trained, tested (numbers of rows), r2, r2_number (of the logarithm of
        the wear number), mape, coverage (of the 95 % intervals of the Gaussian process; nan for
        other models, and where too few rows can promise that level), within_r2, within_mape (by
        cross-validation). Tests of a quantity that was held fixed, or with too few rows, are left
        out.
    """
    y = given.table.target
    everything = np.arange(len(y))
    fixed = of_kind(input_names(given.jet), given.variation, HELD_FIXED)
    rows = []
    for test in TESTS:
        if test.quantity in fixed:
            continue
        column = given.inputs[:, SAMPLED_NAMES.index(test.quantity)]
        outside = test.outside(column)
        held, train = everything[outside], everything[~outside]
        if len(held) < FEWEST_TESTED or len(train) < FEWEST_TRAINED:
            continue
        for name, make in models.items():
            model = fitted(make, given, train)
            predicted = model.predict(given.groups[held])
            found = score(y[held], given.wear(held, predicted), float(y[train].min()))
            coverage = np.nan
            if name == PROCESS and highest_level(len(train)) >= LEVEL:
                _, deviation = model.predict_with_deviation(given.groups[held])
                intervals = conformal_of(given, train, hold_out_in_turn(given, train, seed=seed))
                away = np.abs(given.log_number[held] - predicted) / deviation
                coverage = float(np.mean(away <= intervals.half(given.groups[held], LEVEL)))
            seen = _cross_validated(given, make, held, seed)
            inside = score(y[held], seen, float(y[train].min()))
            rows.append(
                (test.name, test.words, name, len(train), len(held), found["R2"],
                 r2(given.log_number[held], predicted), found["MAPE"], coverage, inside["R2"],
                 inside["MAPE"])
            )  # fmt: skip
    columns = [
        "test", "words", "model", "trained", "tested", "r2", "r2_number", "mape", "coverage",
        "within_r2", "within_mape",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def _cross_validated(
    given: WearProblem, make: Callable, wanted: np.ndarray, seed: int
) -> np.ndarray:
    """Predicted wear of some rows by cross-validation over all rows."""
    n = len(given.log_number)
    predicted = np.empty(n)
    for train, test in folds(given.table.groups, 5, seed):
        predicted[test] = fitted(make, given, train).predict(given.groups[test])
    return given.wear(wanted, predicted[wanted])
