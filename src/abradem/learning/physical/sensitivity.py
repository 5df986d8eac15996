"""Sensitivity of the wear to the sampled quantities, by three measures.

*Sobol indices* decompose the variance of the prediction over the ranges of the study. The
first-order index is the share explained by a quantity alone, the total index includes its
interactions (Sobol 2001, Math. Comput. Simul. 55:271; estimators of Saltelli et al. 2010, Comput.
Phys. Commun. 181:259, as in `scipy.stats.sobol_indices`). They require independent inputs, so
they are computed for the 14 sampled quantities and not for the 20 features. The indices are those
of the model; their intervals cover the error of the integration only.

*Permutation importance* is the fall of R2 on held-out rows when the values of a quantity are
shuffled among them (Breiman 2001, Machine Learning 45:5).

*Partial dependence* is the geometric mean of the predicted wear over the cases, with one quantity
set to the same value in all of them (after Friedman 2001, Ann. Stat. 29:1189).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pandas as pd

from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import WearProblem
from abradem.learning.protocols import repeated_splits
from abradem.learning.scores import r2
from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.surrogate.groups import group_matrix, wear_scale

PAPER = ("archard_constant", "plate_angle", "particle_radius", "particle_velocity_y")
"""The dominant predictors according to the paper."""

PERMUTATIONS = 5
GRID = 17
MOST_ROWS = 300
"""Largest number of cases over which a partial dependence is averaged."""


def predicted_wear(process: GaussianProcess, given: WearProblem, inputs: np.ndarray) -> np.ndarray:
    """Predicted wear depth rate (n,), mm/s, for sampled quantities (n, 14)."""
    values = dict(zip(SAMPLED_NAMES, inputs.T, strict=True))
    return wear_scale(values, given.jet) * np.exp(process.predict(group_matrix(values, given.jet)))


@contextmanager
def _global_seed(seed: int) -> Iterator[None]:
    """Seed numpy's global generator, which scipy's bootstrap uses, and restore it afterwards."""
    before = np.random.get_state()  # noqa: NPY002
    np.random.seed(seed % 2**32)  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(before)  # noqa: NPY002


def sobol(
    process: GaussianProcess,
    given: WearProblem,
    points: int = 2048,
    resamples: int = 200,
    confidence: float = 0.95,
    seed: int = 0,
) -> pd.DataFrame:
    """Sobol indices of the wear and of its logarithm.

    Parameters
    ----------
    process : GaussianProcess
        Fitted to all rows of ``given``.
    given : WearProblem
        Its inputs give the ranges of the quantities.
    points : int
        Number of base points, a power of two; the model is evaluated at up to 16 times as many.
    resamples : int
        Number of bootstrap resamples for the intervals.
    confidence : float
    seed : int

    Returns
    -------
    pandas.DataFrame
        explained (``wear`` or ``log wear``), feature, first, first_lower, first_upper, total,
        total_lower, total_upper. Quantities that do not vary have index 0.
    """
    from scipy import stats

    low, high = given.inputs.min(axis=0), given.inputs.max(axis=0)
    varies = np.flatnonzero(high > low)

    def function(x: np.ndarray) -> np.ndarray:
        inputs = np.tile(low, (x.shape[1], 1))
        inputs[:, varies] = x.T
        wear = predicted_wear(process, given, inputs)
        return np.stack([wear, np.log(wear)])

    found = stats.sobol_indices(
        func=function,
        n=points,
        dists=[stats.uniform(low[k], high[k] - low[k]) for k in varies],
        rng=np.random.default_rng(seed),
    )
    with warnings.catch_warnings(), _global_seed(seed):
        # The bootstrap warns about quantities without effect, whose indices do not vary.
        warnings.simplefilter("ignore")
        spread = found.bootstrap(confidence_level=confidence, n_resamples=resamples)
    rows = []
    for place, explained in enumerate(("wear", "log wear")):
        numbers = np.zeros((len(SAMPLED_NAMES), 6))
        for column, (index, interval) in enumerate(
            ((found.first_order, spread.first_order), (found.total_order, spread.total_order))
        ):
            ends = interval.confidence_interval
            for shift, values in enumerate((index, ends.low, ends.high)):
                found_here = np.where(np.isfinite(values[place]), values[place], index[place])
                numbers[varies, 3 * column + shift] = found_here
        rows += [(explained, name, *numbers[k]) for k, name in enumerate(SAMPLED_NAMES)]
    columns = [
        "explained", "feature", "first", "first_lower", "first_upper", "total", "total_lower",
        "total_upper",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def permutation(
    given: WearProblem, test_share: float = 0.2, repeats: int = 5, seed: int = 0
) -> pd.DataFrame:
    """Fall of R2 on held-out rows when a quantity is shuffled among them.

    Parameters
    ----------
    given : WearProblem
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.

    Returns
    -------
    pandas.DataFrame
        feature, fall (of R2, mean over splits and shuffles), fall_lower, fall_upper (smallest and
        largest of the splits).
    """
    make = makers(seed)[PROCESS]
    falls = np.zeros((repeats, len(SAMPLED_NAMES)))
    splits = repeated_splits(given.table.keys, test_share, repeats, seed)
    for repeat, (train, test) in enumerate(splits):
        process = fitted(make, given, train)
        y, inputs = given.table.target[test], given.inputs[test]
        whole = r2(y, predicted_wear(process, given, inputs))
        rng = np.random.default_rng([seed, repeat])
        for column in range(len(SAMPLED_NAMES)):
            for _ in range(PERMUTATIONS):
                shuffled = inputs.copy()
                shuffled[:, column] = rng.permutation(inputs[:, column])
                fall = whole - r2(y, predicted_wear(process, given, shuffled))
                falls[repeat, column] += fall / PERMUTATIONS
    return pd.DataFrame(
        {
            "feature": SAMPLED_NAMES,
            "fall": falls.mean(axis=0),
            "fall_lower": falls.min(axis=0),
            "fall_upper": falls.max(axis=0),
        }
    )


def partial_dependence(process: GaussianProcess, given: WearProblem, seed: int = 0) -> pd.DataFrame:
    """Geometric mean of the predicted wear over the cases, with one quantity set to a value.

    Parameters
    ----------
    process : GaussianProcess
    given : WearProblem
    seed : int
        Seed of the choice of at most `MOST_ROWS` cases.

    Returns
    -------
    pandas.DataFrame
        feature, setting (in the quantity's unit), predicted (mm/s).
    """
    count = len(given.inputs)
    kept = np.random.default_rng(seed).permutation(count)[:MOST_ROWS]
    rows = []
    for column, row in enumerate(SAMPLED):
        values = given.inputs[:, column]
        for setting in np.linspace(values.min(), values.max(), GRID):
            inputs = given.inputs[kept].copy()
            inputs[:, column] = setting
            wear = np.exp(np.mean(np.log(predicted_wear(process, given, inputs))))
            rows.append((row.name, float(setting), float(wear)))
    return pd.DataFrame(rows, columns=["feature", "setting", "predicted"])


def verdict(indices: pd.DataFrame) -> dict:
    """Dominant quantities by total Sobol index, compared with those of the paper.

    Parameters
    ----------
    indices : pandas.DataFrame
        From `sobol`.

    Returns
    -------
    dict
        ``dominant`` (the four largest total indices of the wear), ``paper`` (the four named in
        the paper), ``shared``, ``agrees`` (whether they are the same), ``hardly_any_effect``
        (total index of the log wear below 0.01).
    """
    wear = indices[indices["explained"] == "wear"].sort_values("total", ascending=False)
    logarithm = indices[indices["explained"] == "log wear"]
    dominant = list(wear["feature"][: len(PAPER)])
    return {
        "dominant": dominant,
        "paper": list(PAPER),
        "shared": [name for name in dominant if name in PAPER],
        "agrees": set(dominant) == set(PAPER),
        "hardly_any_effect": list(logarithm.loc[logarithm["total"] < 0.01, "feature"]),
    }
