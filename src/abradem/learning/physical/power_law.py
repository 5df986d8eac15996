"""Power law of the wear with standard errors, a transparent baseline.

The logarithm of the wear number y / s is linear in the groups of `abradem.surrogate.groups`, and
quadratic in the plate angle, for which a linear term is not sufficient::

    y = s C Fr^a (R/H)^b L^c Ca^d (G*/E*)^f mu_s^g mu_r^h (1+e)^k exp(p cos theta + q phi + r phi^2)

The groups of a geometry (`abradem.surrogate.geometry_groups`) are further terms: powers of lengths,
exponentials of ratios and of angles, with the squares of these.

It is fitted by weighted least squares. The weight of a row is 1 / (n^2 + e_i^2), where e_i is the
relative standard error of its simulation and n the residual scatter, estimated together with the
law. Standard errors come from the HC3 sandwich estimator (MacKinnon and White 1985,
J. Econometrics 29:305).

Rows say nothing about a group that was held fixed, and do not tell groups apart that always vary
together: if of all quantities the speed alone varies, Fr, L and Ca are one variable. The law is
fitted to what varied. C then holds the effect of what was held fixed, and exponents that the rows
do not determine are given as such, without a number (`abradem.dataset.variation`).

The groups share quantities (the density is in L and Ca, the speed in Fr, L and Ca), so the
exponents of the quantities are reported as well. They are sums of the exponents of the groups
(`shares_of`), and their standard errors follow from the covariance of the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np
import pandas as pd

from abradem.dataset.variation import (
    HELD_FIXED,
    NOT_IDENTIFIED,
    VARIED,
    held_fixed,
    ranks,
    row_space,
)
from abradem.learning.number_text import UNDETERMINED, number_or_words, number_with_error
from abradem.quantities import GEOMETRY_GROUPS, GEOMETRY_NAMES
from abradem.surrogate.groups import GROUP_NAMES

_TOLERANCE = 1e-5
"""Share of a combination of coefficients that may lie outside of what the rows determine."""

ROUNDS = 5
"""Iterations in which the weights and the scatter converge."""

SQUARED = ("plate_angle", *(name for name in GEOMETRY_NAMES if GEOMETRY_GROUPS[name] == name))
"""Groups that are angles, of which the law has the square too."""

_SPEED, _SIZE, _LOADING, _CAUCHY, _RATIO = range(5)

SHARES: dict[str, tuple[float, dict[int, float]]] = {
    "impact_speed": (2.0, {_SPEED: 2.0, _LOADING: -1.0, _CAUCHY: 2.0}),
    "particle_radius": (0.0, {_SIZE: 1.0}),
    "particle_density": (0.0, {_LOADING: -1.0, _CAUCHY: 1.0}),
    "effective_youngs_modulus": (0.0, {_CAUCHY: -1.0, _RATIO: -1.0}),
    "effective_shear_modulus": (0.0, {_RATIO: 1.0}),
    "archard_constant": (1.0, {}),
}
"""For each quantity its exponent in the scale s, and its exponent in each group, with a feed by
mass."""


def shares_of(by_number: bool) -> dict[str, tuple[float, dict[int, float]]]:
    """`SHARES` of a feed by mass or by number.

    With a feed by number the scale s = W n' m v^2 / (2 A) holds the mass m of a particle, and the
    loading is proportional to the density.
    """
    if not by_number:
        return SHARES
    return {
        **SHARES,
        "impact_speed": (2.0, {_SPEED: 2.0, _CAUCHY: 2.0}),
        "particle_radius": (3.0, {_SIZE: 1.0}),
        "particle_density": (1.0, {_LOADING: 1.0, _CAUCHY: 1.0}),
    }


class PowerLaw:
    """Power law fitted to groups (n, p) and the logarithm of the wear number (n,).

    Parameters
    ----------
    names : sequence of str
        Names of the groups, see `abradem.surrogate.groups.group_names`.

    Attributes
    ----------
    terms : tuple of str
        The groups and the squares of those that are angles, in the order of the coefficients,
        without the constant.
    coefficients : ndarray, shape (1 + number of terms,)
        ln C, then those of ``terms``: 0 for groups held fixed, and of least norm where the rows
        do not determine them.
    covariance : ndarray, shape (1 + number of terms,) * 2
        HC3; nan if there are too few rows.
    variation : tuple of str
        For each coefficient ``varied``, ``held fixed`` or ``not identified``.
    scatter : float
        n, the residual scatter, relative.
    """

    def __init__(self, names: Sequence[str] = GROUP_NAMES):
        self.names = tuple(names)
        self._squared = [place for place, name in enumerate(names) if name in SQUARED]
        squares = (f"{names[place]}_squared" for place in self._squared)
        self.terms = (*names, *squares)

    def fit(self, x: np.ndarray, target: np.ndarray, error: np.ndarray) -> PowerLaw:
        """Fit to groups, target and its standard errors (n,)."""
        design, onto = self._reduced(self._design(x))
        self.scatter = max(float(np.std(target)), 1e-12)
        for _ in range(ROUNDS):
            weight = 1.0 / (self.scatter**2 + error**2)
            weight /= weight.max()
            root = np.sqrt(weight)[:, None]
            inverse = np.linalg.pinv(root * design, rcond=1e-10)
            found = inverse @ (root[:, 0] * target)
            residual = target - design @ found
            # Moment estimate of the scatter, without the standard errors of the rows.
            spread = np.sum(weight * (residual**2 - error**2)) / np.sum(weight)
            freedom = max(len(target) - design.shape[1], 1)
            spread *= len(target) / freedom
            self.scatter = float(np.sqrt(max(spread, 1e-8)))
        leverage = np.einsum("ij,ji->i", root * design, inverse)
        if len(target) > design.shape[1] and leverage.max() < 1.0 - 1e-9:
            scaled = inverse * (root[:, 0] * residual / (1.0 - leverage))
            covariance = scaled @ scaled.T
        else:
            covariance = np.full((design.shape[1],) * 2, np.nan)
        if onto is None:
            self.coefficients, self.covariance = found, covariance
        else:
            self.coefficients, self.covariance = onto @ found, onto @ covariance @ onto.T
        units = np.eye(len(self.coefficients))
        self.variation = tuple(self._says_of(unit) for unit in units)
        return self

    def _reduced(self, design: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """Design of what the rows determine, and the map from its coefficients to all of them.

        The map is None if the rows determine all coefficients.
        """
        terms = design[:, 1:]
        self._fixed = held_fixed(terms, 1.0)
        kept = np.flatnonzero(~self._fixed)
        columns = terms[:, kept]
        self._centre, self._spread = columns.mean(axis=0), columns.std(axis=0)
        # Groups that are functions of each other are not told apart by the curvature of the
        # function alone. The square of an angle is meant to be told apart in this way.
        groups = len(self.names)
        order = np.column_stack([ranks(terms[:, :groups]), terms[:, groups:]])[:, kept]
        self._spaces = row_space(columns), row_space(order)
        space = self._spaces[0]
        if len(space) < len(kept):
            z = (columns - self._centre) / self._spread
            slopes = space.T / self._spread[:, None]
            reduced = np.column_stack([np.ones(len(design)), z @ space.T])
        elif len(kept) < terms.shape[1]:
            slopes = np.eye(len(kept))
            reduced = np.column_stack([np.ones(len(design)), columns])
        else:
            return design, None
        onto = np.zeros((design.shape[1], reduced.shape[1]))
        onto[0, 0] = 1.0
        onto[1 + kept, 1:] = slopes
        if len(space) < len(kept):
            onto[0, 1:] = -self._centre @ slopes
        return reduced, onto

    def _says_of(self, along: np.ndarray) -> str:
        """What the rows say of the sum of the coefficients with the factors ``along``."""
        slopes = along[1:]
        if (slopes[self._fixed] != 0.0).any():
            return NOT_IDENTIFIED if (slopes[~self._fixed] != 0.0).any() else HELD_FIXED
        wanted = (slopes[~self._fixed] - along[0] * self._centre) / self._spread
        size = np.linalg.norm(wanted)
        for space in self._spaces:
            if np.linalg.norm(wanted - space.T @ (space @ wanted)) > _TOLERANCE * size:
                return NOT_IDENTIFIED
        return VARIED

    def predict(self, x: np.ndarray) -> np.ndarray:
        """Logarithm of the wear number for groups (n, p)."""
        return self._design(x) @ self.coefficients

    def _design(self, x: np.ndarray) -> np.ndarray:
        squares = [x[:, place] ** 2 for place in self._squared]
        return np.column_stack([np.ones(len(x)), x, *squares])

    def shares(self, by_number: bool = False) -> dict[str, tuple[float, dict[int, float]]]:
        """`shares_of`, and the exponents of the lengths of a geometry."""
        places = {name: place for place, name in enumerate(self.names)}
        lengths = {
            name: (0.0, {places[group]: 1.0})
            for name, group in GEOMETRY_GROUPS.items()
            if group.startswith("log_") and group in places
        }
        return {**shares_of(by_number), **lengths}

    def exponents(self, fixed: Collection[str] = (), by_number: bool = False) -> pd.DataFrame:
        """Exponents of quantities and coefficients of groups, with standard errors.

        Parameters
        ----------
        fixed : collection of str
            The quantities of `shares` that were held fixed in the rows.
        by_number : bool
            Whether particles were fed by number, not by mass.

        Returns
        -------
        pandas.DataFrame
            term, kind (``quantity`` or ``group``), exponent, standard_error, variation. The
            exponent of a quantity is that of the wear rate, the scale s included. Exponents of
            what was held fixed or is not identified are nan.
        """
        rows = []
        for name, (in_scale, shares) in self.shares(by_number).items():
            along = np.zeros(len(self.coefficients))
            for group, share in shares.items():
                along[1 + group] = share
            error = float(np.sqrt(along @ self.covariance @ along)) if shares else 0.0
            says = HELD_FIXED if name in fixed else self._says_of(along)
            # A group may have been held fixed although the quantity varied, with others.
            says = NOT_IDENTIFIED if says == HELD_FIXED and name not in fixed else says
            rows.append((name, "quantity", in_scale + along @ self.coefficients, error, says))
        errors = np.sqrt(np.diag(self.covariance))
        terms = ("constant", *self.terms)
        for name, value, error, says in zip(
            terms, self.coefficients, errors, self.variation, strict=True
        ):
            rows.append((name, "group", value, error, says))
        columns = ["term", "kind", "exponent", "standard_error", "variation"]
        found = pd.DataFrame(rows, columns=columns)
        found.loc[found["variation"] != VARIED, ["exponent", "standard_error"]] = np.nan
        return found

    def equation(self) -> str:
        """The law as one line of text, exponents with their standard errors.

        It ends with the groups that were held fixed, whose effect is in its constant, and with
        those that the rows do not tell apart.
        """
        return self._equation(
            "y = W m' v^2 / (2 A) * {c}{powers}{exponential}",
            ("Fr", "(R/H)", "L", "Ca", "(G*/E*)", "mu_s", "mu_r", "(1+e)"),
            ("cos(theta)", "phi", "phi^2"),
            lambda term: _of_geometry(term, str),
            lambda base, shown: f"{base}^({shown})",
            lambda shown, term: f"({shown}) {term}",
            (" * ", " * exp({})"),
            "+-",
        )

    def equation_tex(self) -> str:
        """The law as LaTeX; likewise."""
        return self._equation(
            r"\dot h = \frac{{W \dot m v^2}}{{2A}}\, {c}{powers}{exponential}",
            ("Fr", "(R/H)", "L", "Ca", "(G^*/E^*)", r"\mu_s", r"\mu_r", "(1+e)"),
            (r"\cos\theta", r"\varphi", r"\varphi^2"),
            lambda term: _of_geometry(term, lambda words: rf"\text{{{words.replace('_', ' ')}}}"),
            lambda base, shown: f"{base}^{{{shown}}}",
            lambda shown, term: rf"({shown})\,{term}",
            (r"\, ", r"\, \exp\left[{}\right]"),
            r"\pm",
            lambda words: rf"\quad\text{{{words}}}",
            lambda terms: ", ".join(f"${term}$" for term in terms),
        )

    def _equation(
        self, pattern, bases, terms, named, power, summand, between, sign,
        aside=lambda words: f"; {words}", listed=", ".join,
    ) -> str:  # fmt: skip
        values, errors = self.coefficients, np.sqrt(np.diag(self.covariance))
        places = {name: 1 + place for place, name in enumerate(self.terms)}
        ordered = ("jet_width", "plate_angle", "plate_angle_squared")
        names = dict(zip((places[name] for name in ordered), terms, strict=True))
        bare = dict(zip(range(1, len(bases) + 1), bases, strict=True))
        for name in self.terms[len(GROUP_NAMES) :]:
            if name.startswith("log_"):
                bare[places[name]] = named(name)
            elif name != "plate_angle_squared":
                names[places[name]] = named(name)
        order = (*bare, *names)
        names = {**bare, **names}

        def shown(place: int, form: str) -> str:
            return number_with_error(values[place], errors[place], form, sign)

        varied = [place for place in order if self.variation[place] == VARIED]
        powers = [power(names[k], shown(k, ".3f")) for k in varied if k in bare]
        sums = [summand(shown(k, "+.3f"), names[k]) for k in varied if k not in bare]
        said = pattern.format(
            c=number_or_words(factor_of(values[0]), ".3g") if self.variation[0] == VARIED else "C",
            powers="".join(between[0] + one for one in powers),
            exponential=between[1].format(" ".join(sums)) if sums else "",
        )
        if self.variation[0] != VARIED:
            said += aside(f"C is {UNDETERMINED}")
        if not np.isfinite(errors).all():
            said += aside("standard errors are not determined, the rows are too few")
        for kind, words in (
            (HELD_FIXED, "held fixed, their effect is in the constant: "),
            (NOT_IDENTIFIED, "not identified, as the rows do not tell them apart: "),
        ):
            found = [names[k] for k in order if self.variation[k] == kind]
            if found:
                said += aside(words + listed(found))
        return said


def factor_of(logarithm: float) -> float:
    """The factor C from its logarithm, without overflow."""
    return float(np.exp(min(logarithm, 700.0)))


def _of_geometry(term: str, written: Callable[[str], str]) -> str:
    """A term of a geometry in the equation: a length over the fall height, a ratio or an angle."""
    if term.startswith("log_"):
        return f"({written(term.removeprefix('log_'))}/H)"
    if term.endswith("_squared"):
        return f"{written(term.removesuffix('_squared'))}^2"
    return written(term)
