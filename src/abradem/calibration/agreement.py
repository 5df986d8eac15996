"""How well simulated wear rates agree with given ones, without a constant and with one.

With the given rates y and the simulated ones p, the errors are d = ln y - ln p. A constant c that
multiplies all p is fitted as ln c = mean d. R2 is 1 - (sum of squared errors) / (sum of squares of
y about its mean), for ln y and for y itself, each without the constant and with it.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.quantities import STATISTICS, WEAR_MEASURES, wear_column

SCORES = ("log_r2", "log_r2_constant", "r2", "r2_constant", "spearman", "constant")
"""Names of the scores of `agreement`."""

COMBINATION = ["trial", "measure", "statistic", "element_size"]
"""Columns that name a way to read a simulation."""

LEAST_ROWS = 4
"""Smallest number of rows that are scored."""


def agreement(given: np.ndarray, simulated: np.ndarray) -> dict[str, float]:
    """Scores of simulated wear rates against given ones.

    Parameters
    ----------
    given, simulated : ndarray, shape (n,)
        Wear rates in one unit; the given ones are positive.

    Returns
    -------
    dict of str to float
        One value for each of `SCORES`. All are nan if there are fewer than `LEAST_ROWS` rows, if
        the given rates do not differ, or if a simulated one is not positive.
    """
    given, simulated = np.asarray(given, dtype=float), np.asarray(simulated, dtype=float)
    fine = np.isfinite(simulated).all() and (simulated > 0.0).all()
    if len(given) < LEAST_ROWS or not fine or np.ptp(given) == 0.0:
        return dict.fromkeys(SCORES, np.nan)
    difference = np.log(given) - np.log(simulated)
    constant = float(np.exp(difference.mean()))
    return {
        "log_r2": _explained(np.log(given), difference),
        "log_r2_constant": _explained(np.log(given), difference - difference.mean()),
        "r2": _explained(given, given - simulated),
        "r2_constant": _explained(given, given - constant * simulated),
        "spearman": _rank_correlation(given, simulated),
        "constant": constant,
    }


def _explained(values: np.ndarray, errors: np.ndarray) -> float:
    return 1.0 - float(errors @ errors) / float(np.sum((values - values.mean()) ** 2))


def _rank_correlation(one: np.ndarray, two: np.ndarray) -> float:
    """Spearman's coefficient: the correlation of the ranks; nan if all ranks of one are equal."""
    ranks = [pd.Series(values).rank().to_numpy() for values in (one, two)]
    if any(np.ptp(values) == 0.0 for values in ranks):
        return np.nan
    return float(np.corrcoef(*ranks)[0, 1])


def simulated_means(runs: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return the mean over the replicates of a wear rate, rows by case_id, one column ``mean``,
    and one column for each replicate."""
    table = runs.pivot(index="case_id", columns="replicate", values=column)
    return table.assign(mean=table.mean(axis=1, skipna=False))


def scored(runs: pd.DataFrame, given: pd.Series) -> pd.DataFrame:
    """Score every measure, statistic and element size of some trials.

    Parameters
    ----------
    runs : pandas.DataFrame
        From `abradem.calibration.trials.run_trial`, all trials on the same rows.
    given : pandas.Series
        Given wear rates, mm/s, by case_id.

    Returns
    -------
    pandas.DataFrame
        `COMBINATION`, ``rows``, ``missing`` (simulations without a wear rate), `SCORES`, and
        ``<score>_noise``: their standard errors from the scatter of the replicates (jackknife,
        Efron 1982; nan for a single replicate).
    """
    found = []
    for (trial, size), part in runs.groupby(["trial", "element_size"], sort=True):
        first = size == runs["element_size"].min()
        for measure in WEAR_MEASURES:
            for statistic in STATISTICS:
                if statistic == "mean" and not first:
                    # The mean over the plate has no elements.
                    continue
                column = wear_column(measure, statistic)
                table = simulated_means(part, column)
                known = given.loc[table.index].to_numpy()
                scores = agreement(known, table["mean"].to_numpy())
                found.append(
                    {
                        "trial": trial,
                        "measure": measure,
                        "statistic": statistic,
                        "element_size": np.nan if statistic == "mean" else size,
                        "rows": len(table),
                        "missing": int(part[column].isna().sum()),
                        **scores,
                        **_noise(known, table.drop(columns="mean").to_numpy()),
                    }
                )
    return pd.DataFrame(found)


def _noise(given: np.ndarray, replicates: np.ndarray) -> dict[str, float]:
    """Jackknife standard errors of the scores of the mean over replicates, shape (n, r)."""
    count = replicates.shape[1]
    if count < 2:
        return {f"{name}_noise": np.nan for name in SCORES}
    without = [
        agreement(given, np.delete(replicates, place, axis=1).mean(axis=1))
        for place in range(count)
    ]
    found = {}
    for name in SCORES:
        values = np.array([one[name] for one in without])
        squares = float(np.sum((values - values.mean()) ** 2))
        found[f"{name}_noise"] = float(np.sqrt((count - 1.0) / count * squares))
    return found
