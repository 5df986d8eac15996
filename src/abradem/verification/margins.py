"""How much of its tolerance each check of the verification study uses."""

from __future__ import annotations

import numpy as np
import pandas as pd


def margins(checks: pd.DataFrame) -> pd.DataFrame:
    """Share of the tolerance that each check uses; 1 is the limit.

    Parameters
    ----------
    checks : pandas.DataFrame
        As `abradem.verification.table.checks_table` makes them, all parts together.

    Returns
    -------
    pandas.DataFrame
        part, law, verdict and ``used``: absolute difference over tolerance; of a bound from
        above ours over it, of a bound from below it over ours.
    """
    ours, bound = (checks[name].abs().to_numpy(dtype=float) for name in ("ours", "reference"))
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.select(
            [checks["kind"] == "at most", checks["kind"] == "at least"],
            [ours / bound, bound / ours],
            checks["difference"].abs() / checks["tolerance"],
        )
    # Nothing used of a tolerance of nothing.
    used = np.where(np.isnan(used) & (ours == bound), 0.0, used)
    return checks[["part", "law", "verdict"]].assign(used=used)
