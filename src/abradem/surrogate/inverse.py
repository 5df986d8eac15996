"""Inverse questions to a surrogate: which value of a quantity gives a wear depth rate, and where
over a range the wear is least and greatest.

The wear is proportional to Archard's constant W, so that W follows in closed form. Any other
quantity is a root of the prediction: the range is divided by `POINTS` values, and each change of
sign of the logarithm of rate over wanted rate is narrowed down. Roots closer to each other than one
division are not told apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from abradem.quantities import quantity
from abradem.surrogate.inputs import PredictionError
from abradem.surrogate.model import Prediction, Surrogate

POINTS = 4001
"""Number of values over a range."""

NARROWED = 101
"""Number of values by which a division with a change of sign is divided again, twice."""

NO_EFFECT = 1e-9
"""Relative difference of the rates over a range up to which a quantity has no effect: rounding
alone would make every value of the grid a root, or none."""

CLOSED_FORM = "archard_constant"

UNIT_CONSTANT = 1e-9
"""Archard's constant, 1/Pa, at which the wear that is proportional to it is predicted."""


class Solution(NamedTuple):
    """Values of a quantity that give a wear depth rate.

    Attributes
    ----------
    roots : ndarray, shape (k,)
        At which the prediction is the rate, ascending; empty if there is none.
    spans : list of (float, float)
        Where the rate is inside the interval of the prediction, ascending.
    confidence : float
        Level of the interval.
    least, greatest : float
        Smallest and largest rate predicted over the range, mm/s; both are the rate itself for
        Archard's constant, which has no range.
    """

    roots: np.ndarray
    spans: list[tuple[float, float]]
    confidence: float
    least: float
    greatest: float


class Extremes(NamedTuple):
    """Where over the range of a quantity the wear is least and greatest.

    Attributes
    ----------
    values : (float, float)
        Of the quantity, at the least and at the greatest wear.
    predictions : (Prediction, Prediction)
        There, one case each.
    """

    values: tuple[float, float]
    predictions: tuple[Prediction, Prediction]


def range_of(
    surrogate: Surrogate, name: str, ends: tuple[float, float] | None = None
) -> tuple[float, float]:
    """The range over which a quantity is sought: as asked, or that of the training.

    Raises
    ------
    PredictionError
        If the quantity was held fixed in training and no range is given.
    """
    low, high = ends or surrogate.ranges[name]
    if not low < high:
        raise PredictionError(
            f"{name} was held fixed at {low:g} {quantity(name).unit} in training, so the surrogate "
            "does not know its effect"
            if ends is None
            else f"{name}: the range {low:g} ... {high:g} is not in order"
        )
    return low, high


def solve(
    surrogate: Surrogate,
    values: Mapping[str, float],
    name: str,
    rate: float,
    confidence: float | None = None,
    target: str | None = None,
    ends: tuple[float, float] | None = None,
) -> Solution:
    """All values of a quantity at which the surrogate predicts a wear depth rate.

    Parameters
    ----------
    surrogate : Surrogate
    values : mapping of str to float
        The other sampled quantities.
    name : str
        The quantity that is sought.
    rate : float
        Wear depth rate, mm/s.
    confidence, target
        See `Surrogate.predict`.
    ends : (float, float), optional
        Range that is searched; the training range by default. Archard's constant needs none.

    Raises
    ------
    PredictionError
        If the values or the range are invalid, or the prediction does not depend on the quantity.
    """
    if name == CLOSED_FORM:
        found = surrogate.predict({**values, name: UNIT_CONSTANT}, confidence, target)
        middle, low, high = (
            UNIT_CONSTANT * rate / float(one[0]) for one in (found.rate, found.upper, found.lower)
        )
        return Solution(np.array([middle]), [(low, high)], found.confidence, rate, rate)
    low, high = range_of(surrogate, name, ends)
    grid = np.linspace(low, high, POINTS)
    found = surrogate.predict({**values, name: grid}, confidence, target)
    if found.rate.max() - found.rate.min() <= NO_EFFECT * found.rate.max():
        unit = "" if quantity(name).unit == "1" else f" {quantity(name).unit}"
        raise PredictionError(
            f"{name} has no effect on the prediction: the wear depth rate is "
            f"{found.rate[0]:.4g} mm/s over all of {low:g} ... {high:g}{unit}"
        )
    roots = [
        _narrowed(surrogate, values, name, rate, target, (grid[at], grid[at + 1]))
        for at in _changes(found.rate - rate)
    ]
    roots += [float(grid[-1])] if found.rate[-1] == rate else []
    inside = (found.lower <= rate) & (rate <= found.upper)
    return Solution(
        np.array(roots), _spans(grid, inside), found.confidence,
        float(found.rate.min()), float(found.rate.max()),
    )  # fmt: skip


def least_and_greatest(
    surrogate: Surrogate,
    values: Mapping[str, float],
    name: str,
    confidence: float | None = None,
    target: str | None = None,
    ends: tuple[float, float] | None = None,
) -> Extremes:
    """Least and greatest wear over the range of a quantity; see `solve` for the parameters."""
    grid = np.linspace(*range_of(surrogate, name, ends), POINTS)
    found = surrogate.predict({**values, name: grid}, confidence, target)
    least, greatest = (float(grid[at]) for at in (np.argmin(found.rate), np.argmax(found.rate)))
    at_least, at_greatest = (
        surrogate.predict({**values, name: value}, confidence, target)
        for value in (least, greatest)
    )
    return Extremes((least, greatest), (at_least, at_greatest))


def _changes(away: np.ndarray) -> np.ndarray:
    """Places i of a function (n,) that has a root from i, included, to i + 1."""
    sign = np.sign(away)
    # A value that is 0 belongs to the division that it begins.
    return np.flatnonzero((sign[:-1] * sign[1:] < 0.0) | (sign[:-1] == 0.0))


def _narrowed(surrogate, values, name: str, rate: float, target, ends: tuple[float, float]):
    """Root between two values that enclose one, by dividing twice and a straight line."""
    low, high = ends
    for _ in range(2):
        grid = np.linspace(low, high, NARROWED)
        away = surrogate.predict({**values, name: grid}, None, target).rate - rate
        places = _changes(away)
        # Rounding of the networks may move a root by one place over the end.
        at = int(places[0]) if len(places) else int(np.argmin(np.abs(away[:-1])))
        low, high = grid[at], grid[at + 1]
    rise = away[at + 1] - away[at]
    share = float(np.clip(-away[at] / rise, 0.0, 1.0)) if rise else 0.0
    return float(low + share * (high - low))


def _spans(grid: np.ndarray, inside: np.ndarray) -> list[tuple[float, float]]:
    """First and last value of each run of values that are inside."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
    return [(float(grid[first]), float(grid[last - 1])) for first, last in edges.reshape(-1, 2)]
