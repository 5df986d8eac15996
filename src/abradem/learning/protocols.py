"""The two evaluation protocols, and the training and test rows of each.

``leakage_free``
    Everything that learns (scaler, feature selection, hyper-parameters, genetic search) sees
    training rows only. The test rows of a split are used once, and are the same for all models of
    a study. Expensive models use only the first of the repeated splits.
``as_published``
    The procedure of the paper's notebooks: one shuffle with seed 42, a scaler fitted to all rows
    before the split, choices made on the test rows. It is kept to reproduce the printed scores.
    Its scores are optimistic, and every table and figure that shows them says so.
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


def repeated_splits(
    keys: np.ndarray, test_share: float = 0.2, repeats: int = 50, seed: int = 0
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield ``repeats`` random splits into training and test rows.

    Parameters
    ----------
    keys : ndarray, shape (n,)
        Case numbers. The splits depend on the set of keys, not on the order of the rows.
    test_share : float
        Share of the rows that is held out, rounded up to whole rows.
    repeats : int
        Number of splits.
    seed : int

    Yields
    ------
    train, test : ndarray of int
        Row numbers, in ascending order of the keys.
    """
    keys = np.asarray(keys)
    n = len(keys)
    tested = held_out(n, test_share)
    order = np.argsort(keys, kind="stable")
    for repeat in range(repeats):
        shuffled = np.random.default_rng([seed, repeat]).permutation(n)
        yield order[np.sort(shuffled[tested:])], order[np.sort(shuffled[:tested])]


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


def folds(rows: int, count: int, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Training and validation rows of a shuffled cross-validation.

    Parameters
    ----------
    rows : int
        Number of rows.
    count : int
        Number of folds; reduced so that each fold has at least two validation rows.
    seed : int

    Returns
    -------
    list of tuple
        (training rows, validation rows) of each fold, ascending.

    Raises
    ------
    ValueError
        If there are fewer than four rows.
    """
    count = min(count, rows // 2)
    if count < 2:
        raise ValueError(f"{rows} rows are too few to cross-validate")
    shuffled = np.random.default_rng(seed).permutation(rows)
    parts = [np.sort(part) for part in np.array_split(shuffled, count)]
    everything = np.arange(rows)
    return [(np.setdiff1d(everything, part), part) for part in parts]


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
