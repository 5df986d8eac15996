"""How good any model could be: the same case, simulated again with other seeds.

A simulated wear rate scatters, as the places of the particles are random. A perfect model would
predict its expectation, and its R2 on simulated rows would still be less than 1,

    R2_floor = 1 - sum_i noise_i^2 / sum_i (y_i - mean y)^2.

Two estimates of the noise are compared. Every case states a standard error from the batches of
its own record. And some cases are simulated again: the variance over seeds, by the mean square of
the standard errors stated, is a ratio that would be 1 if the latter are right. It multiplies the
noise of all cases. Of d degrees of freedom (cases times replicates) its band is
[d / chi2_d(0.975), d / chi2_d(0.025)] times it; so many replicates as there are, so narrow it is.

Replicates are made of cases with large particles, evenly over their radii: small particles are many and
cost minutes a case. Their wear scatters less, and the floor rests on the errors they state.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats


def noise_floor(
    replicates: pd.DataFrame, dataset: pd.DataFrame, confidence: float = 0.95
) -> tuple[pd.DataFrame, dict]:
    """The best R2 that any model could reach on rows like those of a data set.

    Parameters
    ----------
    replicates : pandas.DataFrame
        From `replicate`.
    dataset : pandas.DataFrame
        case_id, wear_total_mean and wear_total_mean_stderr of all cases.
    confidence : float
        Of the band.

    Returns
    -------
    per_case : pandas.DataFrame
        case_id, replicates, relative_spread (standard deviation over seeds by the mean),
        relative_stderr (root mean square of the errors stated, by the mean).
    summary : dict
        ``ratio`` with its band, ``r2_floor`` with its band, ``r2_floor_of_stated_errors``,
        ``r2_log_floor``, ``cases``, ``replicates``, ``degrees_of_freedom``.
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
