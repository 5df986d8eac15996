"""Groups of rows that repeat one another, exactly or nearly.

Replicates are legitimate rows, but a model that has seen one of them knows the others. A split
therefore never divides a group: a score on the test rows would otherwise count what was learned by
heart. All splits and folds of all models use the groups of `groups_of_rows`.
"""

from __future__ import annotations

import numpy as np

from abradem.dataset.variation import SAME, held_fixed

NEAR = 0.02
"""Distance of rows that nearly repeat one another, as a share of the usual distance between
neighbours. Of rows drawn at random along one quantity about one in twenty has such a neighbour by
chance, of those drawn in many quantities none."""

USUAL = 0.95
"""Quantile of the distances between neighbours that counts as usual. It finds near repeats of
up to 1 / (1 - `USUAL`) = 20 rows each; exact ones are found whatever their number."""

MEASURED = 1000
"""Largest number of rows between which distances are measured."""

NAMED = 10
"""Largest number of groups that a summary names."""


def groups_of_rows(values: np.ndarray) -> np.ndarray:
    """Group of each row; rows of a group repeat one another, directly or through others.

    The distance of two rows is their largest difference in any column, in standard deviations of
    the column; a column of positive values counts twice, as it is and by its logarithm, so that
    small values that differ by a factor are not the same. The shortest tree that connects all rows
    (minimum spanning tree: Prim 1957, Bell Syst. Tech. J. 36:1389) has the distances between
    neighbours as its edges. Rows nearer than `NEAR` times the quantile `USUAL` of the edges, or
    than `SAME`, are of one group. So the measure follows the rows at hand: a dense series of one
    quantity is not taken for repeats, as its neighbours are all equally near.

    Parameters
    ----------
    values : ndarray, shape (n, p)
        Features.

    Returns
    -------
    ndarray of int, shape (n,)
        Numbers from 0, in the order of the first row of each group.
    """
    columns = _columns(np.asarray(values, dtype=float))
    if not len(columns):
        return np.zeros(len(values), dtype=int)
    different, group = np.unique(columns, axis=1, return_inverse=True)
    near = max(SAME, NEAR * _usual_distance(columns))
    return _numbered(_connected(different, near)[np.ravel(group)])


def _connected(columns: np.ndarray, near: float) -> np.ndarray:
    """Component of each row (n,), rows linked by steps of at most ``near``."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    count = columns.shape[1]
    one, other = cKDTree(columns.T).query_pairs(near, p=np.inf, output_type="ndarray").T
    links = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    return connected_components(links, directed=False)[1]


def _columns(values: np.ndarray) -> np.ndarray:
    """Standardised columns and logarithms of those that vary, shape (k, n)."""
    varied = values[:, ~held_fixed(values)]
    found = []
    for column in varied.T:
        # Huge values are scaled first, as their squares overflow.
        found.append(column / np.abs(column).max())
        if (column > 0.0).all():
            found.append(np.log(column))
    if not found:
        return np.empty((0, len(values)))
    z = np.array(found)
    return (z - z.mean(axis=1, keepdims=True)) / z.std(axis=1, keepdims=True)


def _usual_distance(columns: np.ndarray) -> float:
    """Quantile `USUAL` of the distances between neighbours.

    Of more than `MEASURED` rows it is estimated from as many of them, drawn at random. Neighbours
    are then farther apart, at most by the ratio of the numbers (rows along one quantity).
    """
    rows = columns.shape[1]
    if rows > MEASURED:
        kept = np.random.default_rng(0).permutation(rows)[:MEASURED]
        return _usual_distance(columns[:, kept]) * MEASURED / rows
    return float(np.quantile(edges(columns), USUAL)) if rows > 1 else 0.0


def edges(columns: np.ndarray) -> np.ndarray:
    """Lengths of the edges (n - 1,) of the minimum spanning tree of n rows, columns (k, n)."""
    count = columns.shape[1]
    found = np.zeros(count - 1)
    distance = np.full(count, np.inf)
    newest = 0
    for place in range(count - 1):
        distance[newest] = np.nan
        away = np.abs(columns - columns[:, newest, None]).max(axis=0)
        distance = np.where(away < distance, away, distance)
        newest = int(np.nanargmin(distance))
        found[place] = distance[newest]
    return found


def _numbered(root: np.ndarray) -> np.ndarray:
    """Numbers from 0 in the order of the first row of each group."""
    _, first, inverse = np.unique(root, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first, kind="stable"), kind="stable")[inverse]


def repeats_among(groups: np.ndarray, keys: np.ndarray) -> dict:
    """The rows that repeat others, counted and named.

    Parameters
    ----------
    groups : ndarray of int, shape (n,)
        From `groups_of_rows`.
    keys : ndarray of int, shape (n,)
        Case numbers.

    Returns
    -------
    dict
        ``rows``, the number of rows in groups of two or more; ``groups``, their number; ``cases``,
        the case numbers of the first `NAMED` of them.
    """
    sizes = np.bincount(groups, minlength=1)
    several = np.flatnonzero(sizes > 1)
    return {
        "rows": int(sizes[several].sum()),
        "groups": len(several),
        "cases": [[int(key) for key in keys[groups == one]] for one in several[:NAMED]],
    }
