"""Which quantities decide the wear: three answers to three questions.

*Sobol indices* split the variance of the prediction over the ranges of the study. First order:
what a quantity explains alone; total order: with all it acts together with (Sobol 2001, Math.
Comput. Simul. 55:271; estimators of Saltelli et al. 2010, Comput. Phys. Commun. 181:259, as in
`scipy.stats.sobol_indices`). They need independent inputs, hence the 14 sampled quantities and
not the 20 features. They are those of the model; their intervals are of the integration alone.

*Permutation importance* is how much R2 falls on held-out rows when a quantity is shuffled among
them: what a good model loses without it.

*Partial dependence* is the geometric mean of the predicted wear over the cases, with one quantity
set to a value for all.
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
"""The predictors that the study found to dominate."""

PERMUTATIONS = 5
GRID = 17
MOST_ROWS = 300
"""Cases that a partial dependence is averaged over."""


def predicted_wear(process: GaussianProcess, given: WearProblem, inputs: np.ndarray) -> np.ndarray:
    """Wear depth rate, mm/s, of the sampled quantities (n, 14)."""
    values = dict(zip(SAMPLED_NAMES, inputs.T, strict=True))
    return wear_scale(values, given.jet) * np.exp(process.predict(group_matrix(values, given.jet)))


@contextmanager
def _global_seed(seed: int) -> Iterator[None]:
    """numpy's global generator at a seed, put back afterwards: scipy's bootstrap takes no other."""
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
        Gives the ranges of the quantities.
    points : int
        Base points, a power of two; the model is evaluated at 16 times as many.
    resamples : int
        Bootstrap draws behind the intervals.
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
        # A quantity without any effect has no scatter to draw an interval from.
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

    Returns
    -------
    pandas.DataFrame
        feature, fall of R2 (mean over splits and shuffles), fall_lower, fall_upper (least and
        most of the splits).
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
    """Geometric mean of the predicted wear with one quantity set.

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
    """Which quantities the numbers name, and whether they are those of the study.

    Parameters
    ----------
    indices : pandas.DataFrame
        From `sobol`.

    Returns
    -------
    dict
        ``dominant`` (the four largest total indices of the wear), ``paper`` (the four of the
        study), ``shared``, ``agrees`` (the same four), ``hardly_any_effect`` (total index of the
        log wear below 0.01).
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
