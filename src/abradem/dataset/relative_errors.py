"""Relative standard errors of the wear rates of a data set."""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.quantities import stderr_column


def relative_stderr(rates: pd.DataFrame, target: str) -> np.ndarray:
    """Return the standard error of each wear rate by the rate, shape (n,).

    Parameters
    ----------
    rates : pandas.DataFrame
        Holds ``target`` and, if it is known, its standard error.
    target : str
        A wear-rate column, mm/s.

    Returns
    -------
    ndarray, shape (n,)
        nan where the error is not known or the rate is not positive.
    """
    error = stderr_column(target)
    if error not in rates:
        return np.full(len(rates), np.nan)
    rate = rates[target].to_numpy(dtype=float)
    found = np.full(len(rates), np.nan)
    np.divide(rates[error].to_numpy(dtype=float), rate, out=found, where=rate > 0.0)
    return found
