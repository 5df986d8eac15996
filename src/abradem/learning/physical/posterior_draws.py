"""Functions drawn from the posterior of the Gaussian process: how sure it is of what it learned.

A drawn function agrees with the rows as far as their noise tells, and varies between them as the
process thinks possible. It is a draw f of the prior, corrected by what the rows say (Matheron's
rule; Wilson et al. 2020, ICML, 10292) ::

    f(z) + k(z, Z) K^-1 (t - f(Z) - noise)

The smooth part of f is a sum of random cosines, whose frequencies follow the spectral density of
the Matern 5/2 covariance, a multivariate t-distribution of 5 degrees of freedom (Rahimi and Recht
2007, NeurIPS 20:1177). Constant and trends have normal coefficients and are exact.
"""

from __future__ import annotations

import numpy as np

from abradem.learning.physical.gaussian_process import CONSTANT, GaussianProcess

COSINES = 500
"""Number of cosines; their covariance differs from the exact one by some 1 / sqrt(COSINES)."""

MATERN_FREEDOM = 5
"""Twice the smoothness 5/2 of the covariance."""


class FunctionDraw:
    """A function from the posterior of a process; it predicts as the process does.

    Parameters
    ----------
    process : GaussianProcess
        Fitted.
    rng : numpy.random.Generator
    """

    def __init__(self, process: GaussianProcess, rng: np.random.Generator):
        self._process = process
        p = len(process.lengths)
        heavy = np.sqrt(rng.chisquare(MATERN_FREEDOM, COSINES) / MATERN_FREEDOM)
        self._frequencies = rng.standard_normal((p, COSINES)) / heavy / process.lengths[:, None]
        self._phases = rng.uniform(0.0, 2.0 * np.pi, COSINES)
        self._heights = process.smooth * np.sqrt(2.0 / COSINES) * rng.standard_normal(COSINES)
        self._constant = np.sqrt(CONSTANT) * rng.standard_normal()
        self._slopes = process.trend * rng.standard_normal(p)
        self._curvatures = process.curvature / np.sqrt(2.0) * rng.standard_normal((p, p))
        noise = np.sqrt(process.row_variance) * rng.standard_normal(len(process.row_variance))
        self._alpha = process.solve(self._prior(process.rows) + noise)

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Target for features (n, p), shape (n,)."""
        return self._process.predict(x) + np.concatenate(
            [self._prior(z) - k @ self._alpha for k, z in self._process.blocks(x)]
        )

    def _prior(self, z: np.ndarray) -> np.ndarray:
        """The draw of the prior at standardised features (n, p)."""
        smooth = np.cos(z @ self._frequencies + self._phases) @ self._heights
        return (
            smooth + self._constant + z @ self._slopes + np.sum((z @ self._curvatures) * z, axis=1)
        )
