"""Noise floor: the largest R2 that any model could reach, from replicate simulations.

A simulated wear rate is noisy because the particles are released at random positions. Even a
perfect model, which predicts the expectation, would have an R2 below 1 on simulated rows::

    R2_floor = 1 - sum_i noise_i^2 / sum_i (y_i - mean y)^2

Two estimates of the noise are compared. Every case has a standard error from the batch means of
its own time series. In addition, some cases are simulated again with other seeds. The ratio of
the variance over seeds to the mean square of these standard errors is 1 if the standard errors
are correct. The noise variance of all cases is multiplied by this ratio. With d degrees of freedom
(cases times replicates), the confidence band of the ratio is
[d / chi2_d(0.975), d / chi2_d(0.025)] times the ratio; more replicates give a narrower band.

Only cases with large particles are replicated, evenly over their radii, because a case with small
particles has many of them and takes minutes. The wear of small particles is less noisy, and for
these cases the floor relies on their own standard errors.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from abradem.learning.scores import has_spread


def noise_floor(
    replicates: pd.DataFrame, dataset: pd.DataFrame, confidence: float = 0.95
) -> tuple[pd.DataFrame, dict]:
    """Largest R2 that any model could reach on a data set.

    It is undefined, nan, if the wear has no spread.

    Parameters
    ----------
    replicates : pandas.DataFrame
        From `abradem.wear.replicates.replicate`.
    dataset : pandas.DataFrame
        case_id, wear_total_mean and wear_total_mean_stderr (mm/s) of all cases.
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
        1), ``r2_log_floor``, ``cases``, ``replicates``, ``degrees_of_freedom``, ``confidence``,
        ``median_relative_stderr``.
    """
    own = dataset[["case_id", "wear_total_mean", "wear_total_mean_stderr"]]
    both = pd.concat([replicates, own[own["case_id"].isin(replicates["case_id"])]])
    rows, weighted, freedom = [], 0.0, 0
    for case, group in both.groupby("case_id", sort=True):
        rate, error = group["wear_total_mean"], group["wear_total_mean_stderr"]
        stated = float(np.mean(error**2))
        if len(group) < 2 or not stated > 0.0:
            continue
        variance = float(rate.var(ddof=1))
        weighted += (len(group) - 1) * variance / stated
        freedom += len(group) - 1
        mean = float(rate.mean())
        rows.append((case, len(group), np.sqrt(variance) / mean, np.sqrt(stated) / mean))
    per_case = pd.DataFrame(
        rows, columns=["case_id", "replicates", "relative_spread", "relative_stderr"]
    ).astype({"case_id": "int64", "replicates": "int32"})

    y = dataset["wear_total_mean"].to_numpy(dtype=float)
    error = dataset["wear_total_mean_stderr"].to_numpy(dtype=float)
    share, log_share = (
        float(np.sum(noise**2) / np.sum((values - values.mean()) ** 2))
        if has_spread(values)
        else np.nan
        for noise, values in ((error, y), (error / y, np.log(y)))
    )
    ratio = weighted / freedom if freedom else np.nan
    tail = 0.5 * (1.0 - confidence)
    band = (
        [float(ratio * freedom / stats.chi2.ppf(p, freedom)) for p in (1.0 - tail, tail)]
        if freedom
        else [np.nan, np.nan]
    )
    return per_case, {
        "cases": len(per_case),
        "replicates": int(per_case["replicates"].sum()),
        "degrees_of_freedom": freedom,
        "confidence": confidence,
        "ratio": ratio,
        "ratio_band": band,
        "r2_floor_of_stated_errors": 1.0 - share,
        "r2_floor": 1.0 - ratio * share,
        "r2_floor_band": [1.0 - band[1] * share, 1.0 - band[0] * share],
        "r2_log_floor": 1.0 - ratio * log_share,
        "median_relative_stderr": float(np.median(error / y)),
    }
