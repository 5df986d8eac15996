"""The two evaluation protocols, and the training and test rows of each.

``leakage_free``
    Everything that learns (scaler, feature selection, hyper-parameters, genetic search) sees
    training rows only. The test rows of a split are used once, and are the same for all models of
    a study. Rows that repeat one another, exactly or nearly, are on one side of every split and
    of every fold.
``as_published``
    The procedure of the paper's notebooks: one shuffle with seed 42, a scaler fitted to all rows
    before the split, choices made on the test rows. It is kept to reproduce the printed scores.
    Where they exceed the leakage-free ones they are optimistic. Every table and figure that shows
    them names the protocol.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

LEAKAGE_FREE = "leakage_free"
AS_PUBLISHED = "as_published"
PROTOCOLS = (AS_PUBLISHED, LEAKAGE_FREE)

PUBLISHED_SEED = 42
PUBLISHED_SHARE = 0.2
"""Share of the rows held out for the regressions and the tree, as published."""
PUBLISHED_NETWORK_SHARE = 0.3
"""Share of the rows held out for the networks, as published."""


VALIDATION, CROSS_VALIDATION, CURVE, SHUFFLES, DRAWS = 1, 2, 3, 4, 5
"""Last entry of the seed of each random stream beside the splits, so that no two are the same: a
seed and the same seed followed by zeros are one stream for numpy."""


def repeated_splits(
    keys: np.ndarray,
    groups: np.ndarray,
    test_share: float = 0.2,
    repeats: int = 50,
    seed: int = 0,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield ``repeats`` random splits into training and test rows.

    Parameters
    ----------
    keys : ndarray, shape (n,)
        Case numbers. The splits depend on the set of keys, not on the order of the rows.
    groups : ndarray of int, shape (n,)
        Group of each row, see `abradem.learning.repeated_rows.groups_of_rows`; no split divides
        one.
    test_share : float
        Share of the rows that is held out, rounded up to whole rows, or as near to it as whole
        groups allow.
    repeats : int
        Number of splits.
    seed : int

    Yields
    ------
    train, test : ndarray of int
        Row numbers, in ascending order of the keys.
    """
    order = np.argsort(np.asarray(keys), kind="stable")
    sorted_groups = np.asarray(groups)[order]
    for repeat in range(repeats):
        rng = np.random.default_rng([seed, repeat])
        train, test = divide(sorted_groups, test_share, rng)
        yield order[train], order[test]


def divide(
    groups: np.ndarray, share: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Rows that stay and rows that are held out, without dividing a group.

    Groups are taken at random. One that is too large for what is left to hold out is passed over,
    unless the number of rows comes nearer to the share with it.

    Parameters
    ----------
    groups : ndarray of int, shape (n,)
    share : float
        Share of the rows that is held out.
    rng : numpy.random.Generator

    Returns
    -------
    kept, held : ndarray of int
        Row numbers, ascending.

    Raises
    ------
    ValueError
        If all rows are one group, or see `held_out`.
    """
    left = held_out(len(groups), share)
    members = _members(groups)
    if len(members) < 2:
        raise ValueError(ONE_GROUP)
    held: list[np.ndarray] = []
    shuffled = [members[one] for one in rng.permutation(len(members))]
    for rows in shuffled:
        if left > 0 and len(rows) - left <= left and len(held) < len(members) - 1:
            held.append(rows)
            left -= len(rows)
    # If every group is too large, the smallest is held out.
    tested = np.sort(np.concatenate(held or [min(shuffled, key=len)]))
    return np.setdiff1d(np.arange(len(groups)), tested), tested


ONE_GROUP = "dataset: all rows repeat one another, so none can be held out"


def _members(groups: np.ndarray) -> list[np.ndarray]:
    """Row numbers of each group, groups in the order of their first rows."""
    _, first, inverse = np.unique(groups, return_index=True, return_inverse=True)
    found = np.split(np.argsort(inverse, kind="stable"), np.cumsum(np.bincount(inverse))[:-1])
    return [found[one] for one in np.argsort(first, kind="stable")]


def published_split(rows: int, test_share: float) -> tuple[np.ndarray, np.ndarray]:
    """Training and test rows as published: scikit-learn's ``train_test_split`` with seed 42.

    Parameters
    ----------
    rows : int
        Number of rows.
    test_share : float
        Share of the rows that is held out.

    Returns
    -------
    train, test : ndarray of int
        Row numbers in shuffled order, which determines the mini-batches.
    """
    tested = held_out(rows, test_share)
    shuffled = np.random.RandomState(PUBLISHED_SEED).permutation(rows)
    return shuffled[tested:], shuffled[:tested]


def folds(groups: np.ndarray, count: int, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Training and validation rows of a shuffled cross-validation.

    Parameters
    ----------
    groups : ndarray of int, shape (n,)
        Group of each row, see `abradem.learning.repeated_rows.groups_of_rows`; no fold divides
        one, so folds differ in size if groups do.
    count : int
        Number of folds; reduced so that each fold has at least two validation rows, as far as
        groups allow, and to the number of groups.
    seed : int

    Returns
    -------
    list of tuple
        (training rows, validation rows) of each fold, ascending.

    Raises
    ------
    ValueError
        If there are fewer than four rows, or all are one group.
    """
    rows = len(groups)
    if rows < 4:
        raise ValueError(f"{rows} rows are too few to cross-validate")
    members = _members(groups)
    if len(members) < 2:
        raise ValueError(ONE_GROUP)
    count = max(2, min(count, rows // 2, len(members)))
    rng = np.random.default_rng([seed, 0, CROSS_VALIDATION])
    # Each group goes to the fold that is emptiest, large groups first.
    shuffled = [members[one] for one in rng.permutation(len(members))]
    parts: list[list[np.ndarray]] = [[] for _ in range(count)]
    sizes = np.zeros(count, dtype=int)
    for group in sorted(shuffled, key=len, reverse=True):
        emptiest = int(np.argmin(sizes))
        parts[emptiest].append(group)
        sizes[emptiest] += len(group)
    everything = np.arange(rows)
    checked = [np.sort(np.concatenate(part)) for part in parts]
    return [(np.setdiff1d(everything, part), part) for part in checked]


def most_held_out(rows: int, fewest_trained: int) -> float:
    """Largest share of ``rows`` that can be held out with so many left for training."""
    return (rows - fewest_trained) / rows


def held_out(rows: int, test_share: float) -> int:
    """Number of test rows.

    Raises
    ------
    ValueError
        If ``test_share`` is not between 0 and 1, or leaves no training or no test row.
    """
    if not 0.0 < test_share < 1.0:
        raise ValueError(f"test_share = {test_share!r} must lie between 0 and 1")
    tiny = 1e-9
    tested = math.ceil(test_share * rows - tiny)
    if not 1 <= tested < rows:
        raise ValueError(f"{rows} rows cannot be split with test_share = {test_share:g}")
    return tested
