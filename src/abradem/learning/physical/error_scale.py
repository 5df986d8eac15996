"""Error scale: how much larger the held-out errors are here than elsewhere.

The standard deviation s of a Gaussian process follows from the distances to its rows. It does not
know where wear is harder to predict, such as on flat plates: held-out scores |t - mean| / s are
larger there, so intervals with one quantile for all cases hold too few of some cases and too
many of others. The scale is a function of the groups ::

    g(x) = exp(c + sum_k w_k z_k(x)),   z = standardised exp(-u), u exp(1 - u), ln Fr, ln R/H

with u = tan |phi| / 0.3 (`abradem.learning.physical.noise_terms.error_terms`), and intervals use
the quantile of score / g and the deviation s g (normalised conformal prediction: Papadopoulos,
Gammerman and Vovk 2008, AIA '08, 64). It is fitted by maximum likelihood (as by
Harvey 1976, Econometrica 44:461) for errors with Student's t-distribution, the noise that the
process assumes, so a wild row counts little. A normal prior on the weights keeps few rows from
being overfitted: without dependence g is nearly constant, and the intervals are the usual ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.learning.physical.gaussian_process import STUDENT_FREEDOM as FREEDOM
from abradem.learning.physical.noise_terms import ERROR_TERMS, error_terms
from abradem.learning.rows import standard_scaler

PRIOR = 0.5
"""Standard deviation of the weights: a factor of 1.6 in g by a standard deviation of a term."""

LEAST = 1e-3
"""Least score that is told apart: rows that are met exactly must not make the scale 0."""


class ErrorScale(NamedTuple):
    """Scale of the held-out errors as a function of the groups.

    Attributes
    ----------
    centre, spread : ndarray, shape (4,)
        Standardisation of the terms.
    constant : float
    weights : ndarray, shape (4,)
        Of the standardised `ERROR_TERMS`.
    """

    centre: np.ndarray
    spread: np.ndarray
    constant: float
    weights: np.ndarray

    def at(self, groups: np.ndarray) -> np.ndarray:
        """Scale g of rows with groups (n, 10), shape (n,), dimensionless."""
        z = (error_terms(groups) - self.centre) / self.spread
        return np.exp(self.constant + z @ self.weights)

    @classmethod
    def of(cls, description: dict) -> ErrorScale:
        """Restore a scale from the dictionary of `describe`."""
        centre, spread, weights = (
            np.array([row[key] for row in description["terms"]], dtype=float)
            for key in ("centre", "spread", "weight")
        )
        return cls(centre, spread, float(description["constant"]), weights)

    def describe(self) -> dict:
        """The scale as stored in JSON: ``constant`` and, for each term, its numbers."""
        columns = zip(ERROR_TERMS, self.centre, self.spread, self.weights, strict=True)
        return {
            "constant": self.constant,
            "terms": [
                {"name": name, "centre": float(centre), "spread": float(spread),
                 "weight": float(weight)}
                for name, centre, spread, weight in columns
            ],
        }  # fmt: skip


def fit_scale(scores: np.ndarray, groups: np.ndarray) -> ErrorScale:
    """Fit the scale to held-out scores.

    Parameters
    ----------
    scores : ndarray, shape (n,)
        |t - mean| / deviation of rows that were held out, not negative.
    groups : ndarray, shape (n, 10)
        Their groups.

    Returns
    -------
    ErrorScale
        The weight of a term that all rows share is 0.
    """
    from scipy.optimize import minimize

    found = error_terms(groups)
    scaler = standard_scaler(found)
    z = np.column_stack([np.ones(len(found)), scaler.forward(found)])
    scores = np.maximum(scores, LEAST)
    start = np.array([np.log(np.median(scores)), *[0.0] * len(ERROR_TERMS)])
    # The loss is convex in the weights.
    weights = minimize(_loss, start, (z, scores), jac=True, method="BFGS").x
    centre, spread = np.asarray(scaler.mean), np.asarray(scaler.scale)
    return ErrorScale(centre, spread, float(weights[0]), weights[1:])


def _loss(weights: np.ndarray, z: np.ndarray, scores: np.ndarray) -> tuple[float, np.ndarray]:
    """Negative log posterior of the weights, and its gradient.

    With r = (score / g)^2 the density of a score is proportional to
    (1 + r / nu)^-((nu + 1) / 2) / g.
    """
    log_scale = z @ weights
    ratio = np.exp(2.0 * (np.log(scores) - log_scale))
    prior = np.array([0.0, *[PRIOR**-2] * len(ERROR_TERMS)])
    loss = np.sum(log_scale + 0.5 * (FREEDOM + 1.0) * np.log1p(ratio / FREEDOM))
    slope = 1.0 - (FREEDOM + 1.0) * ratio / (FREEDOM + ratio)
    return loss + 0.5 * weights @ (prior * weights), z.T @ slope + prior * weights


def cross_fitted(scores: np.ndarray, groups: np.ndarray, fold: np.ndarray) -> np.ndarray:
    """Scale of each row (n,), fitted to the rows of the other folds.

    So a score is compared with a scale that does not know it, as that of a new case is.

    Parameters
    ----------
    scores : ndarray, shape (n,)
    groups : ndarray, shape (n, 10)
    fold : ndarray of int, shape (n,)
        Fold in which each row was held out.
    """
    scale = np.empty(len(scores))
    for one in np.unique(fold):
        held = fold == one
        scale[held] = fit_scale(scores[~held], groups[~held]).at(groups[held])
    return scale
