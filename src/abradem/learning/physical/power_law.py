"""Power law of the wear with standard errors, a transparent baseline.

The logarithm of the wear number y / s is linear in the groups of `abradem.surrogate.groups`, and
quadratic in the plate angle, for which a linear term is not sufficient::

    y = s C Fr^a (R/H)^b L^c Ca^d (G*/E*)^f mu_s^g mu_r^h (1+e)^k exp(p cos theta + q phi + r phi^2)

It is fitted by weighted least squares. The weight of a row is 1 / (n^2 + e_i^2), where e_i is the
relative standard error of its simulation and n the residual scatter, estimated together with the
law. Standard errors come from the HC3 sandwich estimator (MacKinnon and White 1985,
J. Econometrics 29:305).

The groups share quantities (the density is in L and Ca, the speed in Fr, L and Ca), so the
exponents of the quantities are reported as well. They are sums of the exponents of the groups
(`SHARES`), and their standard errors follow from the covariance of the fit.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.surrogate.groups import GROUP_NAMES

ROUNDS = 5
"""Iterations in which the weights and the scatter converge."""

TERMS = (*GROUP_NAMES, "plate_angle_squared")
"""Terms of the law in the order of its coefficients, without the constant."""

_SPEED, _SIZE, _LOADING, _CAUCHY, _RATIO = range(5)

SHARES: dict[str, tuple[float, dict[int, float]]] = {
    "impact_speed": (2.0, {_SPEED: 2.0, _LOADING: -1.0, _CAUCHY: 2.0}),
    "particle_radius": (0.0, {_SIZE: 1.0}),
    "particle_density": (0.0, {_LOADING: -1.0, _CAUCHY: 1.0}),
    "effective_youngs_modulus": (0.0, {_CAUCHY: -1.0, _RATIO: -1.0}),
    "effective_shear_modulus": (0.0, {_RATIO: 1.0}),
    "archard_constant": (1.0, {}),
}
"""For each quantity its exponent in the scale s, and its exponent in each group."""


class PowerLaw:
    """Power law fitted to groups (n, 10) and the logarithm of the wear number (n,).

    Attributes
    ----------
    coefficients : ndarray, shape (12,)
        ln C, then those of `TERMS`.
    covariance : ndarray, shape (12, 12)
        HC3; nan if there are too few rows.
    scatter : float
        n, the residual scatter, relative.
    """

    def fit(self, x: np.ndarray, target: np.ndarray, error: np.ndarray) -> PowerLaw:
        """Fit to groups, target and its standard errors (n,)."""
        design = _design(x)
        self.scatter = max(float(np.std(target)), 1e-12)
        for _ in range(ROUNDS):
            weight = 1.0 / (self.scatter**2 + error**2)
            weight /= weight.max()
            root = np.sqrt(weight)[:, None]
            # Constant groups make the system singular: take the minimum-norm solution.
            inverse = np.linalg.pinv(root * design, rcond=1e-10)
            self.coefficients = inverse @ (root[:, 0] * target)
            residual = target - design @ self.coefficients
            # Moment estimate of the scatter, without the standard errors of the rows.
            spread = np.sum(weight * (residual**2 - error**2)) / np.sum(weight)
            freedom = max(len(target) - np.linalg.matrix_rank(design), 1)
            spread *= len(target) / freedom
            self.scatter = float(np.sqrt(max(spread, 1e-8)))
        leverage = np.einsum("ij,ji->i", root * design, inverse)
        if len(target) > len(self.coefficients) and leverage.max() < 1.0 - 1e-9:
            scaled = inverse * (root[:, 0] * residual / (1.0 - leverage))
            self.covariance = scaled @ scaled.T
        else:
            self.covariance = np.full((len(self.coefficients),) * 2, np.nan)
        return self

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Logarithm of the wear number for groups (n, 10)."""
        return _design(x) @ self.coefficients

    def exponents(self) -> pd.DataFrame:
        """Exponents of quantities and coefficients of groups, with standard errors.

        Returns
        -------
        pandas.DataFrame
            term, kind (``quantity`` or ``group``), exponent, standard_error. The exponent of a
            quantity is that of the wear rate, the scale s included.
        """
        rows = []
        for name, (in_scale, shares) in SHARES.items():
            along = np.zeros(len(self.coefficients))
            for group, share in shares.items():
                along[1 + group] = share
            error = float(np.sqrt(along @ self.covariance @ along)) if shares else 0.0
            rows.append((name, "quantity", in_scale + along @ self.coefficients, error))
        errors = np.sqrt(np.diag(self.covariance))
        terms = ("constant", *TERMS)
        for name, value, error in zip(terms, self.coefficients, errors, strict=True):
            rows.append((name, "group", value, error))
        columns = ["term", "kind", "exponent", "standard_error"]
        return pd.DataFrame(rows, columns=columns)

    def equation(self) -> str:
        """The law as one line of text, exponents with their standard errors."""
        return self._equation(
            "y = W m' v^2 / (2 A) * {c} * {powers} * exp({exponential})",
            ("Fr", "(R/H)", "L", "Ca", "(G*/E*)", "mu_s", "mu_r", "(1+e)"),
            ("cos(theta)", "phi", "phi^2"),
            lambda base, value, error: f"{base}^({value:.3f} +- {error:.3f})",
            lambda value, error, term: f"({value:+.3f} +- {error:.3f}) {term}",
            " * ",
        )

    def equation_tex(self) -> str:
        """The law as LaTeX."""
        return self._equation(
            r"\dot h = \frac{{W \dot m v^2}}{{2A}}\, {c}\, {powers}\,"
            r" \exp\left[{exponential}\right]",
            ("Fr", "(R/H)", "L", "Ca", "(G^*/E^*)", r"\mu_s", r"\mu_r", "(1+e)"),
            (r"\cos\theta", r"\varphi", r"\varphi^2"),
            lambda base, value, error: f"{base}^{{{value:.3f} \\pm {error:.3f}}}",
            lambda value, error, term: f"({value:+.3f} \\pm {error:.3f})\\,{term}",
            r"\, ",
        )

    def _equation(self, pattern, bases, terms, power, summand, between) -> str:
        values, errors = self.coefficients, np.sqrt(np.diag(self.covariance))
        count = len(bases)
        powers = [
            power(base, value, error)
            for base, value, error in zip(
                bases, values[1 : count + 1], errors[1 : count + 1], strict=True
            )
        ]
        # cos theta is the last group, and the plate angle the one before it.
        order = (count + 2, count + 1, count + 3)
        sums = [summand(values[k], errors[k], term) for k, term in zip(order, terms, strict=True)]
        return pattern.format(
            c=f"{np.exp(values[0]):.3g}", powers=between.join(powers), exponential=" ".join(sums)
        )


def _design(x: np.ndarray) -> np.ndarray:
    angle = x[:, GROUP_NAMES.index("plate_angle")]
    return np.column_stack([np.ones(len(x)), x, angle**2])
