"""Which rows train and which test: the same for every model of a study."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np


def repeated_splits(
    keys: np.ndarray, test_share: float = 0.2, repeats: int = 50, seed: int = 0
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield ``repeats`` random splits into training and test rows.

    Parameters
    ----------
    keys : ndarray, shape (n,)
        Case numbers. Splits depend on the set of keys, not on the order of the rows.
    test_share : float
        Share of the rows held out, rounded up to whole rows.
    repeats : int
        Number of splits.
    seed : int

    Yields
    ------
    train, test : ndarray of int
        Row numbers, ascending by key.
    """
    keys = np.asarray(keys)
    n = len(keys)
    tested = held_out(n, test_share)
    order = np.argsort(keys, kind="stable")
    for repeat in range(repeats):
        shuffled = np.random.default_rng([seed, repeat]).permutation(n)
        yield order[np.sort(shuffled[tested:])], order[np.sort(shuffled[:tested])]


def held_out(rows: int, test_share: float) -> int:
    """Number of test rows; raises ValueError unless both parts keep a row."""
    if not 0.0 < test_share < 1.0:
        raise ValueError(f"test_share = {test_share!r} must lie between 0 and 1")
    tiny = 1e-9
    tested = math.ceil(test_share * rows - tiny)
    if not 1 <= tested < rows:
        raise ValueError(f"{rows} rows cannot be split with test_share = {test_share:g}")
    return tested
