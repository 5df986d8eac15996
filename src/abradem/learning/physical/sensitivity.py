"""Sensitivity of the wear to the sampled quantities, by three measures.

*Sobol indices* decompose the variance of the prediction over the ranges of the study. The
first-order index is the share explained by a quantity alone, the total index includes its
interactions (Sobol 2001, Math. Comput. Simul. 55:271; estimators of Saltelli et al. 2010, Comput.
Phys. Commun. 181:259, as in `scipy.stats.sobol_indices`). They require independent inputs, so
they are computed for the sampled quantities and not for the features. Their intervals come
from functions drawn from the posterior of the model, so they tell how sure the model is, the error
of the integration included.

*Permutation importance* is the fall of R2 on held-out rows when the values of a quantity are
shuffled among them (Breiman 2001, Machine Learning 45:5).

*Partial dependence* is the geometric mean of the predicted wear over the cases, with one quantity
set to the same value in all of them (after Friedman 2001, Ann. Stat. 29:1189).

None of them says anything about a quantity that was held fixed, or of one of several that always
varied together; see `abradem.dataset.variation`.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, NOT_IDENTIFIED, VARIED, held_fixed, of_kind
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.posterior_draws import FunctionDraw
from abradem.learning.physical.problem import LARGEST_LOG, WearProblem
from abradem.learning.protocols import DRAWS, SHUFFLES, repeated_splits
from abradem.learning.rows import HUGE
from abradem.learning.scores import mean_columns, r2
from abradem.surrogate.groups import group_matrix, input_names, wear_scale

PAPER = ("archard_constant", "plate_angle", "particle_radius", "particle_velocity_y")
"""The dominant predictors according to the paper."""

PERMUTATIONS = 5
GRID = 17
MOST_ROWS = 300
"""Largest number of cases over which a partial dependence is averaged."""


def predicted_wear(
    process: GaussianProcess | FunctionDraw, given: WearProblem, inputs: np.ndarray
) -> np.ndarray:
    """Predicted wear depth rate (n,), mm/s, for sampled quantities (n, m)."""
    values = dict(zip(input_names(given.jet), inputs.T, strict=True))
    number = process.predict(group_matrix(values, given.jet))
    return wear_scale(values, given.jet) * np.exp(np.minimum(number, LARGEST_LOG))


def sobol(
    process: GaussianProcess,
    given: WearProblem,
    points: int = 2048,
    draws: int = 50,
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
    draws : int
        Number of functions drawn from the posterior of the process for the intervals.
    confidence : float
    seed : int

    Returns
    -------
    pandas.DataFrame
        explained (``wear`` or ``log wear``), feature, first, first_lower, first_upper, total,
        total_lower, total_upper, variation. Quantities that were held fixed have no index (nan),
        and there are none at all if the predicted wear does not vary. Those of quantities that
        are not identified follow from the model alone.
    """
    indices = _indices(process, given, points, np.random.default_rng(seed))
    drawn = []
    for number in range(draws):
        rng = np.random.default_rng([seed, number, DRAWS])
        drawn.append(_indices(FunctionDraw(process, rng), given, points, rng))
    ends = [np.full(indices.shape, end) for end in (np.inf, -np.inf)]
    if draws:
        tail = 50.0 * (1.0 - confidence)
        ends = list(np.percentile(drawn, [tail, 100.0 - tail], axis=0))
    says = given.variation
    rows = []
    for place, explained in enumerate(("wear", "log wear")):
        for k, name in enumerate(input_names(given.jet)):
            numbers: list[float] = []
            for order in range(2):
                index = float(indices[order, place, k])
                # The index of the mean function need not be one of the drawn ones.
                numbers += [
                    index,
                    min(index, float(ends[0][order, place, k])),
                    max(index, float(ends[1][order, place, k])),
                ]
            rows.append((explained, name, *numbers, says[k]))
    columns = [
        "explained", "feature", "first", "first_lower", "first_upper", "total", "total_lower",
        "total_upper", "variation",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def _indices(
    model: GaussianProcess | FunctionDraw,
    given: WearProblem,
    points: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Sobol indices of a model, shape (2, 2, m): first and total; wear and log wear; quantity.

    They are nan for quantities held fixed, and where the wear has no variance.
    """
    from scipy import stats

    low, high = given.inputs.min(axis=0), given.inputs.max(axis=0)
    varies = np.flatnonzero(given.variation != HELD_FIXED)
    largest = float(given.table.target.max())
    # Squares of huge wear overflow; the indices do not depend on its unit.
    unit = largest if largest > HUGE else 1.0
    spread_of: list[np.ndarray] = []

    def function(x: np.ndarray) -> np.ndarray:
        inputs = np.tile(low, (x.shape[1], 1))
        inputs[:, varies] = x.T
        wear = predicted_wear(model, given, inputs) / unit
        found = np.stack([wear, np.log(wear)])
        spread_of.append(~held_fixed(found.T, np.array([0.0, 1.0])))
        return found

    with np.errstate(divide="ignore", invalid="ignore"):
        # Without variance the indices are undefined.
        found = stats.sobol_indices(
            func=function,
            n=points,
            dists=[stats.uniform(low[k], high[k] - low[k]) for k in varies],
            rng=rng,
        )
    indices = np.full((2, 2, given.inputs.shape[1]), np.nan)
    # With a single quantity the library leaves out its axis.
    indices[:, :, varies] = np.stack([found.first_order, found.total_order]).reshape(2, 2, -1)
    indices[:, ~np.any(spread_of, axis=0)] = np.nan
    return indices


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
        largest of the splits), variation. They are nan for quantities that were held fixed, and
        where R2 is undefined.
    """
    make = makers(seed)[PROCESS]
    says = given.variation
    falls = np.zeros((repeats, given.inputs.shape[1]))
    falls[:, says == HELD_FIXED] = np.nan
    splits = repeated_splits(given.table.keys, given.table.groups, test_share, repeats, seed)
    for repeat, (train, test) in enumerate(splits):
        process = fitted(make, given, train)
        y, inputs = given.table.target[test], given.inputs[test]
        whole = r2(y, predicted_wear(process, given, inputs))
        rng = np.random.default_rng([seed, repeat, SHUFFLES])
        for column in range(given.inputs.shape[1]):
            # Every quantity takes its draws, so that those of the others do not depend on it.
            for _ in range(PERMUTATIONS):
                shuffled = inputs.copy()
                shuffled[:, column] = rng.permutation(inputs[:, column])
                fall = whole - r2(y, predicted_wear(process, given, shuffled))
                falls[repeat, column] += fall / PERMUTATIONS
    return pd.DataFrame(
        {
            "feature": input_names(given.jet),
            "fall": mean_columns(falls),
            "fall_lower": _end_of(falls, np.inf).min(axis=0),
            "fall_upper": _end_of(falls, -np.inf).max(axis=0),
            "variation": says,
        }
    ).replace([np.inf, -np.inf], np.nan)


def _end_of(falls: np.ndarray, instead: float) -> np.ndarray:
    return np.where(np.isfinite(falls), falls, instead)


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
        feature, setting (in the quantity's unit), predicted (mm/s), of quantities that varied.
    """
    count = len(given.inputs)
    kept = np.random.default_rng(seed).permutation(count)[:MOST_ROWS]
    rows = []
    names = input_names(given.jet)
    for column, (name, says) in enumerate(zip(names, given.variation, strict=True)):
        if says == HELD_FIXED:
            continue
        values = given.inputs[:, column]
        for setting in np.linspace(values.min(), values.max(), GRID):
            inputs = given.inputs[kept].copy()
            inputs[:, column] = setting
            wear = np.exp(np.mean(np.log(predicted_wear(process, given, inputs))))
            rows.append((name, float(setting), float(wear)))
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
        ``dominant`` (the largest total indices of the wear, at most four), ``paper`` (the four
        named in the paper), ``shared``, ``agrees`` (whether they are the same; None if not all of
        the paper's were varied and identified), ``hardly_any_effect`` (total index of the log wear
        below 0.01), ``held_fixed``, ``not_identified``. Only quantities that varied independently
        are ranked.
    """
    ranked = indices[(indices["variation"] == VARIED) & indices["total"].notna()]
    wear = ranked[ranked["explained"] == "wear"].sort_values("total", ascending=False)
    logarithm = ranked[ranked["explained"] == "log wear"]
    dominant = list(wear["feature"][: len(PAPER)])
    says = indices.drop_duplicates("feature")
    told = set(PAPER) <= set(wear["feature"])
    return {
        "dominant": dominant,
        "paper": list(PAPER),
        "shared": [name for name in dominant if name in PAPER],
        "agrees": set(dominant) == set(PAPER) if told else None,
        "hardly_any_effect": list(logarithm.loc[logarithm["total"] < 0.01, "feature"]),
        "held_fixed": of_kind(says["feature"], says["variation"], HELD_FIXED),
        "not_identified": of_kind(says["feature"], says["variation"], NOT_IDENTIFIED),
    }
