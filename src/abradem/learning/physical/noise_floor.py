"""Noise floor: the largest R2 that any model could reach, from replicate simulations.

A simulated wear rate is noisy because the particles are released at random positions. Even a
perfect model, which predicts the expectation, would have an R2 below 1 on simulated rows::

    R2_floor = 1 - sum_i noise_i^2 / sum_i (y_i - mean y)^2

Two estimates of the noise are compared. Every case has a standard error of its own. In addition,
some cases are simulated again with other seeds. The ratio of the variance over seeds to the mean
square of these standard errors is 1 if the standard errors are correct. The noise variance of all
cases is multiplied by this ratio. The ratio may differ from
case to case, so its band comes from the scatter of the cases (`mean_ratio`); more cases give a
narrower band, and more replicates of the same cases only up to their own scatter.

Only cases with large particles are replicated, evenly over their radii, because a case with small
particles has many of them and takes minutes. The wear of small particles is less noisy, and for
these cases the floor relies on their own standard errors.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from abradem.learning.scores import has_spread
from abradem.quantities import stderr_column


def noise_floor(
    replicates: pd.DataFrame,
    dataset: pd.DataFrame,
    target: str = "wear_total_mean",
    confidence: float = 0.95,
) -> tuple[pd.DataFrame, dict]:
    """Largest R2 that any model could reach on a data set.

    It is undefined, nan, if the wear has no spread.

    Parameters
    ----------
    replicates : pandas.DataFrame
        From `abradem.wear.replicates.replicate`.
    dataset : pandas.DataFrame
        case_id, the target and its standard error (mm/s) of all cases.
    target : str
        A wear-rate column.
    confidence : float
        Level of the bands.

    Returns
    -------
    per_case : pandas.DataFrame
        case_id, replicates (the original simulation included), relative_spread (standard
        deviation over seeds divided by the mean), relative_stderr (root mean square of the
        standard errors divided by the mean).
    summary : dict
        ``ratio`` and ``r2_floor`` with their bands, ``r2_floor_of_stated_errors`` (for a ratio of
        1), ``r2_log_floor`` (nan if a target is not positive), ``target``, ``cases``,
        ``replicates``, ``degrees_of_freedom``, ``confidence``, ``median_relative_stderr`` (of the
        positive targets).
    """
    own = dataset[["case_id", target, stderr_column(target)]]
    both = pd.concat([replicates, own[own["case_id"].isin(replicates["case_id"])]])
    rows, ratios, freedoms = [], [], []
    for case, group in both.groupby("case_id", sort=True):
        rate, error = group[target], group[stderr_column(target)]
        stated = float(np.mean(error**2))
        if len(group) < 2 or not stated > 0.0:
            continue
        variance = float(rate.var(ddof=1))
        ratios.append(variance / stated)
        freedoms.append(len(group) - 1)
        mean = float(rate.mean())
        rows.append((case, len(group), np.sqrt(variance) / mean, np.sqrt(stated) / mean))
    per_case = pd.DataFrame(
        rows, columns=["case_id", "replicates", "relative_spread", "relative_stderr"]
    ).astype({"case_id": "int64", "replicates": "int32"})

    y = dataset[target].to_numpy(dtype=float)
    error = dataset[stderr_column(target)].to_numpy(dtype=float)
    positive = y > 0.0
    relative = error[positive] / y[positive]
    share = _unexplained(error, y)
    log_share = _unexplained(relative, np.log(y)) if positive.all() else np.nan
    freedom = sum(freedoms)
    ratio, band = mean_ratio(np.array(ratios), np.array(freedoms), confidence)
    return per_case, {
        "target": target,
        "cases": len(per_case),
        "replicates": int(per_case["replicates"].sum()),
        "degrees_of_freedom": freedom,
        "confidence": confidence,
        "ratio": ratio,
        "ratio_band": list(band),
        "r2_floor_of_stated_errors": 1.0 - share,
        "r2_floor": 1.0 - ratio * share,
        "r2_floor_band": [1.0 - band[1] * share, 1.0 - band[0] * share],
        "r2_log_floor": 1.0 - ratio * log_share,
        "median_relative_stderr": float(np.median(relative)) if positive.any() else np.nan,
    }


def mean_ratio(
    ratios: np.ndarray, freedoms: np.ndarray, confidence: float
) -> tuple[float, tuple[float, float]]:
    """Mean ratio of the cases, weighted by their degrees of freedom, and its band.

    The true ratio may differ from case to case. So the standard error s of the mean m comes from
    the scatter of the cases (a ratio estimate, Cochran 1977, Sampling Techniques, 6.4), which holds
    the chance of the replicates as well, and the band is m exp(+- t s / m) with Student's t of as
    many degrees of freedom as there are cases, less one.

    Parameters
    ----------
    ratios : ndarray, shape (k,)
    freedoms : ndarray of int, shape (k,)
    confidence : float

    Returns
    -------
    mean : float
        nan without cases.
    band : tuple of float
        nan for fewer than two cases.
    """
    if not len(ratios):
        return np.nan, (np.nan, np.nan)
    mean = float(np.average(ratios, weights=freedoms))
    count = len(ratios)
    if count < 2 or not mean > 0.0:
        return mean, (np.nan, np.nan)
    away = freedoms * (ratios - mean) / np.sum(freedoms)
    relative = np.sqrt(count / (count - 1) * np.sum(away**2)) / mean
    reach = float(stats.t.ppf(0.5 + 0.5 * confidence, count - 1) * relative)
    return mean, (mean * float(np.exp(-reach)), mean * float(np.exp(min(reach, LARGEST))))


LARGEST = 700.0
"""Largest logarithm of the width of a band."""


def _unexplained(noise: np.ndarray, values: np.ndarray) -> float:
    """Share of the variance of ``values`` that is noise; nan if they have no spread."""
    if not has_spread(values):
        return np.nan
    return float(np.sum(noise**2) / np.sum((values - values.mean()) ** 2))
