"""Which quantities varied in the rows at hand, and which can be told from the others.

A statement about the effect of a quantity (exponent, weight, index, loading) needs rows in which
the quantity varied. Every such statement asks this module:

``varied``
    The quantity varied, and independently of the others.
``held fixed``
    All rows have the same value, up to `SAME`. The rows say nothing about its effect.
``not identified``
    The quantity varied, but always together with others, so that the rows do not tell whose effect
    it was. With as many quantities as rows this is true of all of them.

Only numpy is needed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from abradem.quantities import GEOMETRY_GROUPS, GEOMETRY_UNITS

VARIED, HELD_FIXED, NOT_IDENTIFIED = "varied", "held fixed", "not identified"

SAME = 1e-6
"""Relative difference up to which values count as the same: that of single precision and of
rounded text, and far below any step that a study would take on purpose."""

SCALES: Mapping[str, float] = {
    "particle_poisson_ratio": 0.1,
    "equipment_poisson_ratio": 0.1,
    "rolling_friction": 0.01,
    "static_friction": 0.1,
    "plate_angle": 1.0,
    "factory_angle": 1.0,
    "particle_velocity_y": 0.1,
    "damping_ratio": 0.1,
    "damping_coefficient": 1e-6,
    **{
        name: {"m": 1e-3, "deg": 1.0, "m/s": 0.1, "rev/min": 1.0}[unit]
        for name, unit in GEOMETRY_UNITS.items()
        if not GEOMETRY_GROUPS[name].startswith("log_")
    },
}
"""Smallest magnitude to which a difference is related, in the unit of the quantity, for those
that may be zero: 1e-17 deg and 0 deg are the same angle."""

_DEPENDENT = 1e-6
"""Share of the spread of a column, not explained by the others, below which it depends on them."""


def held_fixed(values: np.ndarray, scales: float | np.ndarray = 0.0) -> np.ndarray:
    """Whether each column has the same value in all rows.

    Parameters
    ----------
    values : ndarray, shape (n, p)
    scales : float or ndarray, shape (p,)
        Smallest magnitude to which the difference of a column is related.

    Returns
    -------
    ndarray of bool, shape (p,)
        Differences up to `SAME` of the largest value are float noise.
    """
    if not len(values):
        return np.ones(values.shape[1], dtype=bool)
    low, high = values.min(axis=0), values.max(axis=0)
    # Halves, as the difference of huge values of both signs overflows.
    return 0.5 * high - 0.5 * low <= 0.5 * SAME * np.maximum(np.maximum(-low, high), scales)


def scales_of(names: Iterable[str]) -> np.ndarray:
    """Smallest magnitude of each quantity, see `SCALES`; 0 for those that cannot be zero."""
    return np.array([SCALES.get(name, 0.0) for name in names])


def settled(values: np.ndarray, scales: float | np.ndarray = 0.0) -> np.ndarray:
    """Values (n, p) whose columns that were held fixed are free of float noise.

    No model may learn from the last digits of a quantity that nobody varied.
    """
    fixed = held_fixed(values, scales)
    if not len(values) or not fixed.any():
        return values
    found = np.array(values, dtype=float)
    found[:, fixed] = found[0, fixed]
    return found


def dependent(values: np.ndarray) -> np.ndarray:
    """Whether each column is, in these rows, a linear function of other columns and a constant.

    Parameters
    ----------
    values : ndarray, shape (n, p)
        Columns that vary.

    Returns
    -------
    ndarray of bool, shape (p,)
    """
    basis = row_space(values)
    return np.sum(basis**2, axis=0) < 1.0 - _DEPENDENT


def row_space(values: np.ndarray) -> np.ndarray:
    """Combinations of standardised columns that the rows determine.

    Parameters
    ----------
    values : ndarray, shape (n, p)
        Columns that vary.

    Returns
    -------
    ndarray, shape (rank, p)
        Orthonormal rows.
    """
    if not values.size:
        return np.zeros((0, values.shape[1]))
    size = np.abs(values).max(axis=0)
    z = values / np.where(size > 0.0, size, 1.0)
    z = z - z.mean(axis=0)
    spread = z.std(axis=0)
    _, singular, vt = np.linalg.svd(z / np.where(spread > 0.0, spread, 1.0), full_matrices=False)
    return vt[singular > _DEPENDENT * singular.max(initial=0.0)]


def ranks(values: np.ndarray) -> np.ndarray:
    """Rank of each value among the different values of its column (n, p), from 0.

    Columns with equal or opposite ranks are functions of each other, in these rows.
    """
    found = np.zeros(values.shape)
    for place, column in enumerate(values.T):
        step = SAME * (0.5 * column.max() - 0.5 * column.min())
        if step > 0.0:
            column = np.round((0.5 * column - 0.5 * column.min()) / step)
        found[:, place] = np.unique(column, return_inverse=True)[1]
    return found


def variation(values: np.ndarray, names: Sequence[str], linear: bool = False) -> np.ndarray:
    """What the rows say about each quantity: varied, held fixed or not identified.

    Parameters
    ----------
    values : ndarray, shape (n, p)
    names : sequence of str
        Names of the columns.
    linear : bool
        Whether only linear dependence counts, as for the coefficients of a linear model.
        Otherwise quantities that always rise and fall together are not identified, whatever the
        function between them.

    Returns
    -------
    ndarray of str, shape (p,)
    """
    found = np.full(len(names), VARIED, dtype=object)
    fixed = held_fixed(values, scales_of(names))
    found[fixed] = HELD_FIXED
    places = np.flatnonzero(~fixed)
    columns = values[:, places]
    doubtful = dependent(columns)
    if linear:
        found[places[doubtful]] = NOT_IDENTIFIED
        return found
    positive = (columns > 0.0).all(axis=0)
    if positive.sum() > 1:
        # Quantities whose product is constant are collinear in their logarithms.
        doubtful[positive] |= dependent(np.log(columns[:, positive]))
    order = ranks(columns).T
    for i, one in enumerate(order):
        for j in range(i):
            same = np.array_equal(one, order[j])
            if same or np.array_equal(one, order[j].max() - order[j]):
                doubtful[[i, j]] = True
    found[places[doubtful]] = NOT_IDENTIFIED
    return found


def of_kind(names: Iterable[str], found: Iterable[str], kind: str) -> list[str]:
    """The names of the quantities of a kind, such as `HELD_FIXED`."""
    return [name for name, one in zip(names, found, strict=True) if one == kind]


def nothing_varies(values: Mapping[str, Sequence[float]]) -> bool:
    """Whether every quantity was held fixed.

    Parameters
    ----------
    values : mapping of str to sequence of float
        The ends of the range of each quantity, or its values in all rows.
    """
    return all(
        held_fixed(np.asarray(found, dtype=float)[:, None], scales_of([name]))[0]
        for name, found in values.items()
    )
