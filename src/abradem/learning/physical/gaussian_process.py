"""Gaussian process regression with known noise of each row, robust against outliers.

The target t (logarithm of the wear number) is modelled as a function of standardised features z

    t(z) = trend of second order + smooth function + noise
    k(z, z') = c^2 + b^2 z.z' + d^2 (z.z')^2 / 2 + a^2 (1 + r + r^2/3) exp(-r),
    r^2 = 5 sum_j (z_j - z'_j)^2 / l_j^2

with the Matern 5/2 covariance and a length l_j for each feature (automatic relevance
determination; Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, 4.2 and 5.1).
The noise variance of row i is n_i^2 / w_i + e_i^2, where e_i is the relative standard error of the
simulation, n_i the remaining noise, and w_i <= 1 the weight of the row.

*Local noise.* Wear is less regular in some regions than in others. So ln n_i is linear in the
standardised terms that the process is given (regression of the noise: Goldberg, Williams and
Bishop 1998, NeurIPS 10:493; here with a parametric noise, most probable as all other parameters).
Without terms n is one number. A regular row then counts more than an irregular one.

*Robustness.* For noise with a Student t-distribution of nu degrees of freedom the weights are
w_i = (nu + 1) / (nu + u_i^2), at most 1, where u_i is the leave-one-out residual divided by its
predicted standard deviation (iterative reweighting, Lange, Little and Taylor 1989, J. Am. Stat.
Assoc. 84:881). Leave-one-out residuals need no further fit (Rasmussen and Williams, eq. 5.12):
t_i - mean_-i = alpha_i / K^-1_ii, variance_-i = 1 / K^-1_ii, the noise of the row included.

*Few rows.* Maximum likelihood alone would overfit ten lengths to a hundred rows, so each
parameter has a prior (the constants below): responses are smooth over the range of a feature, and
the remaining noise is a few percent.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abradem.learning.rows import standard_scaler

STUDENT_FREEDOM = 4.0
"""Degrees of freedom nu of the Student t-distribution of the noise."""

ROUNDS = 3
"""Iterations of the reweighting; the weights change little after two."""

PARAMETER_ROWS = 500
"""Largest number of rows, drawn at random, to which the parameters are fitted; the prediction uses
all rows."""

MOST_ROWS = 4000
"""Largest number of rows used for the prediction; of more rows a random subset is used, as memory
grows with the square of their number."""

LEAST_ERROR = 1e-3
"""Error below which no wear rate is known; without it repeated rows without a stated error would
make the covariance singular."""

CONSTANT = 10.0
"""c^2, large enough that the mean of the target is practically free."""

# Priors, normal in the logarithm: (mean, standard deviation).
_LENGTH = (1.4, 0.7)  # a length of 4 standard deviations of the feature, within a factor of two
_SMOOTH = (-1.0, 1.0)
_NOISE = (-3.0, 1.0)
_TREND = (-2.0, 2.0)
_CURVATURE = (-2.0, 0.5)
_NOISE_SLOPE = (0.0, 0.5)  # a factor of 1.6 in the noise by a standard deviation of a term


_SCALARS = ("_mean", "smooth", "noise", "trend", "curvature", "typical_error")


class GaussianProcess:
    """Gaussian process with predictions, standard deviations and leave-one-out residuals.

    Parameters
    ----------
    seed : int
        Seed of the choice of rows, see `PARAMETER_ROWS` and `MOST_ROWS`.
    noise_terms : callable, optional
        Gives the terms (n, k) of ln n_i for features (n, p); without it the noise is one number.

    Attributes
    ----------
    lengths : ndarray, shape (p,)
        l_j, in standard deviations of the feature; a long length means a weak influence.
    smooth, noise, trend, curvature : float
        a, n where all noise terms have their mean, b and d.
    noise_slopes : ndarray, shape (k,)
        Of ln n_i in the standardised noise terms.
    weights : ndarray, shape (n,)
        w_i, small for outliers.
    residuals, deviations : ndarray, shape (n,)
        Leave-one-out residuals of the rows used, and the standard deviations with which they
        would be predicted as new rows.
    rows : ndarray, shape (n, p)
        Standardised features of the rows used.
    row_variance : ndarray, shape (n,)
        Variance of the noise of each row, n_i^2 / w_i + e_i^2.
    typical_error : float
        Median of e_i, taken as the error of new rows.
    """

    def __init__(self, seed: int = 0, noise_terms: Callable | None = None):
        self.seed, self._noise_terms = seed, noise_terms or _no_terms

    def fit(self, x: np.ndarray, target: np.ndarray, error: np.ndarray) -> GaussianProcess:
        """Fit to features (n, p), target (n,) and its standard errors (n,)."""
        rng = np.random.default_rng(self.seed)
        error = np.hypot(error, LEAST_ERROR)
        if len(target) > MOST_ROWS:
            kept = np.sort(rng.permutation(len(target))[:MOST_ROWS])
            x, target, error = x[kept], target[kept], error[kept]
        self._scaler = standard_scaler(x)
        self.rows = self._scaler.forward(x)
        found = self._noise_terms(x)
        self._of_noise = standard_scaler(found)
        terms = self._of_noise.forward(found)
        self._mean = float(target.mean())
        t, variance = target - self._mean, error**2
        self.typical_error = float(np.median(error))
        self.weights = np.ones(len(t))
        few = np.sort(rng.permutation(len(t))[:PARAMETER_ROWS])
        theta = _priors(x.shape[1], terms.shape[1])[:, 0]
        for round_ in range(ROUNDS):
            iterations = 100 if round_ == 0 else 20
            theta = self._most_probable(theta, few, t, variance, terms, iterations)
            self._set(theta, terms)
            self._solve(t, variance)
            u = self.residuals / self.deviations
            self.weights = np.minimum((STUDENT_FREEDOM + 1.0) / (STUDENT_FREEDOM + u**2), 1.0)
        self._solve(t, variance)
        return self

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Mean of the target for features (n, p), shape (n,)."""
        return np.concatenate([self._mean + k @ self._alpha for k, _ in self.blocks(x)])

    def predict_with_deviation(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of new rows, each of shape (n,), for features (n, p).

        The standard deviation includes the uncertainty of the function, the noise n and the
        typical error of a simulation.
        """
        slopes = self._of_noise.forward(self._noise_terms(x)) @ self.noise_slopes
        noise = (self.noise * np.exp(slopes)) ** 2 + self.typical_error**2
        means, variances = [], []
        for k, z in self.blocks(x):
            means.append(self._mean + k @ self._alpha)
            prior = self.smooth**2 + CONSTANT + self._trends(np.sum(z**2, axis=1))
            explained = np.sum((k @ self._inverse) * k, axis=1)
            variances.append(np.maximum(prior - explained, 0.0))
        return np.concatenate(means), np.sqrt(np.concatenate(variances) + noise)

    def solve(self, values: np.ndarray) -> np.ndarray:
        """K^-1 times values (n,) at the rows, K their covariance with the noise."""
        return self._inverse @ values

    def arrays(self) -> dict[str, np.ndarray]:
        """All arrays needed for predictions, as stored in a file."""
        return {
            "feature_mean": self._scaler.mean,
            "feature_scale": self._scaler.scale,
            "rows": self.rows,
            "row_variance": self.row_variance,
            "alpha": self._alpha,
            "inverse": self._inverse,
            "lengths": self.lengths,
            "weights": self.weights,
            "residuals": self.residuals,
            "deviations": self.deviations,
            "noise_mean": self._of_noise.mean,
            "noise_scale": self._of_noise.scale,
            "noise_slopes": self.noise_slopes,
            "scalars": np.array([getattr(self, name) for name in _SCALARS]),
        }

    @classmethod
    def of(
        cls, arrays: dict[str, np.ndarray], noise_terms: Callable | None = None
    ) -> GaussianProcess:
        """Restore a process from the arrays of `arrays`, with the terms that it was given."""
        from abradem.learning.rows import Scaler

        self = cls(noise_terms=noise_terms)
        self._scaler = Scaler(arrays["feature_mean"], arrays["feature_scale"])
        self._of_noise = Scaler(arrays["noise_mean"], arrays["noise_scale"])
        self.noise_slopes = arrays["noise_slopes"]
        self.rows, self.row_variance, self._alpha, self._inverse = (
            arrays[name] for name in ("rows", "row_variance", "alpha", "inverse")
        )
        self.lengths, self.weights, self.residuals, self.deviations = (
            arrays[name] for name in ("lengths", "weights", "residuals", "deviations")
        )
        for name, value in zip(_SCALARS, arrays["scalars"], strict=True):
            setattr(self, name, float(value))
        return self

    def _set(self, theta: np.ndarray, terms: np.ndarray) -> None:
        p = self.rows.shape[1]
        self.lengths = np.exp(theta[:p])
        self.smooth, self.noise, self.trend, self.curvature = map(float, np.exp(theta[p : p + 4]))
        self.noise_slopes = theta[p + 4 :]
        self._row_noise = self.noise * np.exp(terms @ self.noise_slopes)

    def _trends(self, product: np.ndarray) -> np.ndarray:
        """Covariance of the trend for the scalar products z.z' of rows."""
        return self.trend**2 * product + 0.5 * self.curvature**2 * product**2

    def blocks(self, x: np.ndarray, size: int = 2048):
        """Yield blocks of ``x``: their covariances with the rows, and the standardised block."""
        z = self._scaler.forward(x)
        for first in range(0, max(len(z), 1), size):
            block = z[first : first + size]
            matern, _ = _matern(block / self.lengths, self.rows / self.lengths)
            trends = self._trends(block @ self.rows.T)
            yield self.smooth**2 * matern + trends + CONSTANT, block

    def _solve(self, t: np.ndarray, variance: np.ndarray) -> None:
        """Compute the coefficients alpha = K^-1 t and the leave-one-out residuals."""
        z = self.rows
        matern, _ = _matern(z / self.lengths, z / self.lengths)
        covariance = self.smooth**2 * matern + self._trends(z @ z.T) + CONSTANT
        noise = self._row_noise**2 / self.weights + variance
        covariance[np.diag_indices(len(t))] += noise
        self.row_variance = noise
        self._inverse, _ = _inverse(covariance)
        self._alpha = self._inverse @ t
        precision = np.diag(self._inverse)
        self.residuals = self._alpha / precision
        # As for a new row: with the typical noise instead of that of a downweighted row.
        function = np.maximum(1.0 / precision - noise, 0.0)
        self.deviations = np.sqrt(function + self._row_noise**2 + self.typical_error**2)

    def _most_probable(self, theta, few, t, variance, terms, iterations):
        """Maximum a posteriori parameters on the rows ``few``."""
        from scipy.optimize import minimize

        z, p = self.rows[few], self.rows.shape[1]
        ends = [(-2.0, 7.0)] * p + [(-4.0, 3.0), (-6.0, 0.0), (-6.0, 2.0), (-6.0, 1.0)]
        found = minimize(
            _loss, theta, (z, t[few], 1.0 / self.weights[few], variance[few], terms[few]),
            jac=True, method="L-BFGS-B", options={"maxiter": iterations},
            bounds=ends + [(-2.0, 2.0)] * terms.shape[1],
        )  # fmt: skip
        return found.x


def _no_terms(x: np.ndarray) -> np.ndarray:
    return np.empty((len(x), 0))


def _priors(features: int, terms: int) -> np.ndarray:
    """Mean and standard deviation of each parameter, shape (features + 4 + terms, 2)."""
    others = _SMOOTH, _NOISE, _TREND, _CURVATURE
    return np.array([*[_LENGTH] * features, *others, *[_NOISE_SLOPE] * terms])


def _matern(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Matern 5/2 covariance of scaled rows, and -2 times its derivative by the squared distance."""
    squared = np.sum(a**2, axis=1)[:, None] + np.sum(b**2, axis=1) - 2.0 * (a @ b.T)
    r = np.sqrt(5.0 * np.maximum(squared, 0.0))
    decay = np.exp(-r)
    return (1.0 + r + r**2 / 3.0) * decay, 5.0 / 3.0 * (1.0 + r) * decay


def _inverse(covariance: np.ndarray) -> tuple[np.ndarray, float]:
    """Inverse and half the log determinant of a covariance matrix, by Cholesky factorisation."""
    from scipy.linalg import cholesky
    from scipy.linalg.lapack import dpotri

    factor = cholesky(covariance, lower=True)
    inverse, _ = dpotri(factor, lower=1)
    lower = np.tril(inverse)
    return lower + np.tril(inverse, -1).T, float(np.log(np.diag(factor)).sum())


def _loss(theta, z, t, spread, variance, terms) -> tuple[float, np.ndarray]:
    """Negative log posterior of the parameters, and its gradient.

    With Q = (K^-1 - alpha alpha') / 2 the gradient of the negative log likelihood is
    sum Q * dK/dtheta (Rasmussen and Williams, eq. 5.9).
    """
    p = z.shape[1]
    lengths, (smooth, noise, trend, curved) = np.exp(theta[:p]), np.exp(2.0 * theta[p : p + 4])
    noisy = noise * spread * np.exp(2.0 * terms @ theta[p + 4 :])
    matern, slope = _matern(z / lengths, z / lengths)
    linear = z @ z.T
    covariance = smooth * matern + trend * linear + 0.5 * curved * linear**2 + CONSTANT
    covariance[np.diag_indices(len(t))] += noisy + variance
    inverse, half_log_determinant = _inverse(covariance)
    alpha = inverse @ t
    loss = 0.5 * t @ alpha + half_log_determinant
    q = 0.5 * (inverse - np.outer(alpha, alpha))

    # l_j dk/dl_j = a^2 slope (z_j - z'_j)^2 / l_j^2, summed without a matrix for each j.
    qs = smooth * q * slope
    sums = 2.0 * (qs.sum(axis=1) @ z**2 - np.einsum("ij,ij->j", z, qs @ z))
    gradient = np.empty_like(theta)
    gradient[:p] = sums / lengths**2
    gradient[p] = 2.0 * smooth * np.sum(q * matern)
    gradient[p + 1] = 2.0 * np.diag(q) @ noisy
    gradient[p + 2] = 2.0 * trend * np.sum(q * linear)
    gradient[p + 3] = curved * np.sum(q * linear**2)
    gradient[p + 4 :] = 2.0 * (np.diag(q) * noisy) @ terms

    priors = _priors(p, terms.shape[1])
    away = (theta - priors[:, 0]) / priors[:, 1]
    return loss + 0.5 * away @ away, gradient + away / priors[:, 1]
