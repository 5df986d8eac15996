"""Boosted trees and an ensemble of networks on the logarithm of the wear number.

Both are fitted to groups (n, p), target (n,) and relative standard errors (n,), like the other
models of this package. Boosting weights each row with 1 / (floor^2 + error^2), scaled to mean 1.

Boosting adds small trees, each fitted to the residuals of the previous ones on a random half of
the rows (Friedman 2002, Comput. Stat. Data Anal. 38:367). The ensemble is the mean of networks
that differ in initial weights and in the order of the rows, so that their individual errors
average out (Lakshminarayanan, Pritzel and Blundell 2017, NeurIPS).
"""

from __future__ import annotations

import numpy as np

from abradem.learning.network import Training, start, train
from abradem.learning.rows import standard_scaler

ERROR_FLOOR = 0.02
"""Relative standard error below which all rows have about the same weight."""


class Boosting:
    """Gradient-boosted trees.

    Parameters
    ----------
    trees : int
    depth : int
        Largest number of splits along a branch, which limits the order of interactions.
    learning_rate : float
    seed : int
    """

    def __init__(self, trees: int = 400, depth: int = 4, learning_rate: float = 0.05, seed=0):
        self.trees, self.depth, self.learning_rate, self.seed = trees, depth, learning_rate, seed

    def fit(self, x: np.ndarray, target: np.ndarray, error: np.ndarray) -> Boosting:
        """Fit to groups (n, p), target (n,) and its standard errors (n,)."""
        from sklearn.ensemble import GradientBoostingRegressor

        self._model = GradientBoostingRegressor(
            n_estimators=self.trees,
            max_depth=self.depth,
            learning_rate=self.learning_rate,
            subsample=0.5,
            min_samples_leaf=2,
            random_state=self.seed % 2**32,
        ).fit(x, target, _weights(error))
        return self

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Target for groups (n, p), shape (n,)."""
        return self._model.predict(x)


class Networks:
    """Ensemble of small networks; the prediction is their mean.

    Parameters
    ----------
    members : int
        Number of networks.
    hidden : tuple of int
        Neurons of the hidden layers.
    steps : int
        Training steps (mini-batches) of each network, independent of the number of rows.
    batch : int
        Rows of a mini-batch.
    learning_rate : float
        Learning rate in the first half of the steps; the second half uses a fifth of it.
    seed : int
    """

    def __init__(
        self,
        members: int = 4,
        hidden: tuple[int, ...] = (64, 64),
        steps: int = 2000,
        batch: int = 32,
        learning_rate: float = 3e-3,
        seed: int = 0,
    ):
        self.members, self.hidden, self.steps = members, hidden, steps
        self.batch, self.learning_rate, self.seed = batch, learning_rate, seed

    def fit(self, x: np.ndarray, target: np.ndarray, error: np.ndarray) -> Networks:
        """Fit to groups (n, p) and target (n,); the standard errors are not used."""
        self._of_x, self._of_t = standard_scaler(x), standard_scaler(target)
        z, t = self._of_x.forward(x), self._of_t.forward(target)
        epochs = max(1, round(0.5 * self.steps * self.batch / len(t)))
        self._nets = []
        for member in range(self.members):
            net = start(z.shape[1], self.hidden, self.seed + member)
            for half, rate in enumerate((self.learning_rate, 0.2 * self.learning_rate)):
                training = Training(epochs, self.batch, rate)
                (net,) = train([net], [self.seed + member + 1000 * half], z, t, training)
            self._nets.append(net)
        return self

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Target for groups (n, p), shape (n,)."""
        z = self._of_x.forward(x)
        return self._of_t.back(np.mean([net.predict(z) for net in self._nets], axis=0))


def _weights(error: np.ndarray) -> np.ndarray:
    weight = 1.0 / (ERROR_FLOOR**2 + error**2)
    return weight / weight.mean()
