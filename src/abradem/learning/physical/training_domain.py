"""What the surrogate keeps of its training cases, to tell whether a case is like them.

The slopes of the Gaussian process along each group, and the groups of the training cases; see
`abradem.surrogate.domain` for what is made of them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.problem import WearProblem
from abradem.surrogate.domain import NEIGHBOURS, SHARE, Domain

STEP = 0.1
"""Half of the difference of central differences, in standard deviations of a group: below the
lengths of the process, and above its rounding."""

MOST_CASES = 1000
"""Largest number of cases kept; of more a random subset is, which makes distances a little longer
for training cases and asked cases alike."""


def slopes_of(
    predict: Callable[[np.ndarray], np.ndarray], groups: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """Root mean square slope of a model along each group, per standard deviation of the group.

    Parameters
    ----------
    predict : callable
        Logarithm of the wear number (n,) for groups (n, p).
    groups : ndarray, shape (n, p)
        Of the training cases.
    scale : ndarray, shape (p,)
        Standard deviations of the groups.

    Returns
    -------
    ndarray, shape (p,)
    """
    slopes = np.empty(groups.shape[1])
    for place in range(groups.shape[1]):
        step = np.zeros(groups.shape[1])
        step[place] = STEP * scale[place]
        rise = predict(groups + step) - predict(groups - step)
        slopes[place] = np.sqrt(np.mean((rise / (2.0 * STEP)) ** 2))
    return slopes


def domain_of(
    predict: Callable[[np.ndarray], np.ndarray],
    groups: np.ndarray,
    repeats: np.ndarray,
    mean: np.ndarray,
    scale: np.ndarray,
    seed: int = 0,
) -> tuple[dict, dict[str, np.ndarray]]:
    """Description and arrays of the domain of a surrogate.

    Parameters
    ----------
    predict : callable
        See `slopes_of`.
    groups : ndarray, shape (n, p)
        Dimensionless groups of the training cases.
    repeats : ndarray of int, shape (n,)
        Which cases repeat one another (`abradem.learning.rows.Table.groups`); one of them is kept.
    mean, scale : ndarray, shape (p,)
        Scaling of the groups in the surrogate.
    seed : int
        Of the subset of many cases.
    """
    kept = np.unique(repeats, return_index=True)[1]
    if len(kept) > MOST_CASES:
        kept = np.random.default_rng(seed).permutation(kept)[:MOST_CASES]
    groups = groups[np.sort(kept)]
    # As they are stored, so that the limit is that of the stored cases.
    rows = ((groups - mean) / scale).astype(np.float32)
    domain = Domain.of(rows, slopes_of(predict, groups, scale).astype(np.float32))
    described = {"limit": domain.limit, "share": SHARE, "neighbours": NEIGHBOURS}
    return described, {"domain_rows": domain.rows, "domain_slopes": domain.slopes}


def with_domain(
    model: tuple[dict, dict[str, np.ndarray]],
    process: GaussianProcess,
    given: WearProblem,
    seed: int = 0,
) -> tuple[dict, dict[str, np.ndarray]]:
    """Description and arrays of a surrogate with those of its domain.

    Parameters
    ----------
    model : pair
        From `abradem.learning.physical.distil.surrogate_of`.
    process : GaussianProcess
        Fitted to all rows.
    given : WearProblem
    seed : int
        See `domain_of`.
    """
    description, arrays = model
    described, found = domain_of(
        process.predict, given.groups, given.table.groups,
        arrays["group_mean"], arrays["group_scale"], seed,
    )  # fmt: skip
    return {**description, "domain": described}, {**arrays, **found}
