"""Whether a surrogate is asked for cases like those that it learned from.

A box of ranges is a poor test: a stiff rock is outside it and wears as the others do, and a corner
that no case came near is inside. Two questions are asked instead.

*Does it matter?* A quantity outside its range is named where it moves the prediction: if the
logarithm of the wear number changes by more than `HARMLESS` of its deviation when the quantity is
moved to the end of the range.

*Is any case near?* The distance between two cases is the change of the logarithm of the wear number
that their groups would cause one by one ::

    d(a, b)^2 = sum_j (s_j (a_j - b_j))^2

with the root mean square s_j of the slope of the Gaussian process along group j over its rows, at
least `LEAST_SLOPE`. A case is far if the mean distance to its `NEIGHBOURS` nearest training cases
is above the one that a share `SHARE` of the training cases keep to the others (distance to nearest
neighbours as a score of novelty: Ramaswamy, Rastogi and Shim 2000, SIGMOD Record 29:427).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from abradem.dataset.variation import SAME, held_fixed, scales_of
from abradem.quantities import quantity

SLACK = 0.01
"""Share of a training range by which a value may be outside it without a warning: the cases of a
study do not reach the exact ends of its ranges."""

HARMLESS = 0.5
"""Change of the prediction, in its deviations, that a value outside its range may cause unnamed."""

NEIGHBOURS = 5

SHARE = 0.99

LEAST_SLOPE = 0.02
"""Smallest slope s_j, per standard deviation of the group: a group without influence counts where
it is tens of standard deviations away, as nobody knows what it does there."""


class Domain(NamedTuple):
    """The training cases of a surrogate in the space of its groups.

    Attributes
    ----------
    rows : ndarray, shape (n, p)
        Standardised groups of the training cases, each combination once.
    slopes : ndarray, shape (p,)
        s_j per standard deviation of group j.
    limit : float
        Distance above which a case is far, dimensionless.
    """

    rows: np.ndarray
    slopes: np.ndarray
    limit: float

    @classmethod
    def of(cls, rows: np.ndarray, slopes: np.ndarray) -> Domain:
        """Domain of training cases, standardised groups (n, p), and slopes (p,)."""
        slopes = np.maximum(slopes, LEAST_SLOPE)
        own = _nearest(rows * slopes, rows * slopes, skipped=1)
        return cls(rows, slopes, float(np.quantile(own, SHARE)))

    def distance(self, z: np.ndarray) -> np.ndarray:
        """Mean distance (n,) of cases with standardised groups (n, p) to their nearest ones."""
        return _nearest(z * self.slopes, self.rows * self.slopes)


def _nearest(points: np.ndarray, rows: np.ndarray, skipped: int = 0) -> np.ndarray:
    """Mean distance of each point (n, p) to its nearest rows, without the ``skipped`` nearest."""
    count = min(NEIGHBOURS, len(rows) - skipped)
    if count < 1:
        return np.zeros(len(points))
    squared = np.sum(points**2, axis=1)[:, None] + np.sum(rows**2, axis=1) - 2.0 * (points @ rows.T)
    nearest = np.partition(squared, skipped + count - 1, axis=1)[:, : skipped + count]
    nearest = np.sort(nearest, axis=1)[:, skipped:]
    return np.sqrt(np.maximum(nearest, 0.0)).mean(axis=1)


def warnings_on(
    columns: Mapping[str, np.ndarray],
    ranges: Mapping[str, tuple[float, float]],
    numbers: Callable[[Mapping[str, np.ndarray]], tuple[np.ndarray, np.ndarray]],
    far: np.ndarray,
) -> list[str]:
    """Lines on what a surrogate did not learn, one for each quantity and one on far cases.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (n,)
        The sampled quantities.
    ranges : mapping of str to (float, float)
        Their training ranges.
    numbers : callable
        Logarithm of the wear number and of its deviation, each (n,), for such columns.
    far : ndarray of bool, shape (n,)
        Whether a case is far from all training cases.
    """
    lines, named, outside = [], np.zeros(len(far), dtype=bool), []
    for name, (low, high) in ranges.items():
        column = columns[name]
        ends, scale = np.array([[low], [high]]), scales_of([name])
        fixed = bool(held_fixed(ends, scale)[0])
        # A quantity held fixed is the same value if it differs by float noise alone.
        least = SAME * max(abs(low), abs(high), float(scale[0]))
        slack = least if fixed else SLACK * (high - low)
        beyond = (column < low - slack) | (column > high + slack)
        # The wear is exactly proportional to the Archard constant, in any range.
        if name == "archard_constant" or not beyond.any():
            continue
        unit = "" if quantity(name).unit == "1" else f" {quantity(name).unit}"
        if fixed:
            lines.append(
                f"{_shown(name, column, beyond)}: this quantity was held fixed at {low:g}{unit} in "
                "training; its effect is unknown to the model, the interval does not hold"
            )
            named |= beyond
            continue
        moves = _moves(columns, name, (low, high), beyond, numbers)
        if moves.any():
            lines.append(
                f"{_shown(name, column, moves)} is outside the training range "
                f"{low:g} ... {high:g}{unit}: extrapolated, the interval does not hold"
            )
            named |= moves
        outside.append(f"{name} ({low:g} ... {high:g}{unit})" if (beyond & far).any() else "")
    alone = far & ~named
    if alone.any():
        lines.append(_far_line(alone, list(filter(None, outside))))
    return lines


def _moves(columns, name: str, ends: tuple[float, float], beyond: np.ndarray, numbers):
    """Whether each row is beyond the range of a quantity and its prediction depends on that."""
    rows = np.flatnonzero(beyond)
    asked = {key: values[rows] for key, values in columns.items()}
    mean, spread = numbers(asked)
    at_end, _ = numbers({**asked, name: np.clip(asked[name], *ends)})
    found = np.zeros(len(beyond), dtype=bool)
    # Written so that what overflows counts as moved.
    found[rows] = ~(np.abs(mean - at_end) <= HARMLESS * np.exp(spread))
    return found


def _shown(name: str, column: np.ndarray, which: np.ndarray) -> str:
    row, count = quantity(name), int(which.sum())
    unit = "" if row.unit == "1" else f" {row.unit}"
    place = int(np.argmax(which))
    where = "" if len(column) == 1 else f" in row {place + 1}"
    more = "" if count == 1 else f" (and {count - 1} more)"
    return f"{name} = {column[place]:g}{unit}{where}{more}"


def _far_line(far: np.ndarray, outside: list[str]) -> str:
    place, count = int(np.argmax(far)), int(far.sum())
    where = "this case" if len(far) == 1 else f"row {place + 1}"
    more = "" if count == 1 else f" (and {count - 1} more)"
    why = (
        f"outside their ranges: {', '.join(outside)}"
        if outside
        else "each value is inside its range, but not their combination"
    )
    return (
        f"{where}{more} is far from all training cases ({why}): extrapolated, the interval may not "
        "hold"
    )
