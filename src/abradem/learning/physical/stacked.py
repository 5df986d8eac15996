"""Two models stacked: a mean with the weight that serves rows held out inside the training rows.

The Gaussian process is smooth, boosted trees follow steps; where both err independently their mean
errs less. The weight is chosen by cross-validation inside the training rows (stacked regression:
Wolpert 1992, Neural Networks 5:241; Breiman 1996, Machine Learning 24:49), never by test rows.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abradem.learning.protocols import folds
from abradem.learning.repeated_rows import groups_of_rows

FOLDS = 5

WILD = 6.0
"""A row that both models miss by so many times the usual error is wild and has no say."""


class Stacked:
    """Weighted mean of two models.

    Parameters
    ----------
    first, second : callable
        Constructors of the models.
    seed : int
        Seed of the folds.

    Attributes
    ----------
    share : float
        Weight of the second model, from 0 to 1; 0 if the rows are too few to be held out.
    """

    def __init__(self, first: Callable, second: Callable, seed: int = 0):
        self._makers, self._seed = (first, second), seed

    def fit(self, x: np.ndarray, target: np.ndarray, error: np.ndarray) -> Stacked:
        """Fit to groups (n, p), target (n,) and its standard errors (n,)."""
        groups = groups_of_rows(x)
        self.share = 0.0
        if len(target) >= 2 * FOLDS and groups.max() > 0:
            away = np.empty((2, len(target)))
            for train, test in folds(groups, FOLDS, self._seed):
                for place, make in enumerate(self._makers):
                    model = make().fit(x[train], target[train], error[train])
                    away[place, test] = target[test] - model.predict(x[test])
            self.share = best_share(*away)
        self._models = [make().fit(x, target, error) for make in self._makers]
        return self

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Target for groups (n, p), shape (n,)."""
        first, second = (model.predict(x) for model in self._models)
        return first + self.share * (second - first)


def best_share(first: np.ndarray, second: np.ndarray) -> float:
    """Weight of the second of two models with which the mean of their errors is smallest.

    Parameters
    ----------
    first, second : ndarray, shape (n,)
        Errors of the models on the same rows.

    Returns
    -------
    float
        Minimises sum (first + w (second - first))^2 over w from 0 to 1, without wild rows.
    """
    least = np.minimum(np.abs(first), np.abs(second))
    kept = least <= WILD * np.median(least)
    first, apart = first[kept], (first - second)[kept]
    size = float(apart @ apart)
    return float(np.clip(first @ apart / size, 0.0, 1.0)) if size > 0.0 else 0.0
