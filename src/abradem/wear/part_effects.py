"""What the quantities that varied do to the wear rate of each part of a surface."""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.quantities import GEOMETRY_UNITS, SAMPLED_NAMES, quantity

FEWEST_CASES = 3
"""Cases from which thirds can be compared."""


def varied_quantities(cases: pd.DataFrame) -> list[str]:
    """Return the columns of a table of cases that hold quantities with different values.

    Parameters
    ----------
    cases : pandas.DataFrame
    """
    names = [name for name in (*SAMPLED_NAMES, *GEOMETRY_UNITS) if name in cases]
    return [name for name in names if cases[name].nunique() > 1]


def unit_of_quantity(name: str) -> str:
    """Return the unit of a sampled quantity, also of a geometry."""
    return GEOMETRY_UNITS[name] if name in GEOMETRY_UNITS else quantity(name).unit


def part_effects(parts: pd.DataFrame, cases: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return the effect of each quantity that varied on the wear rate of each part.

    Parameters
    ----------
    parts : pandas.DataFrame
        From `abradem.wear.surface_cells.part_table`.
    cases : pandas.DataFrame
    column : str
        Wear rate, mm/s.

    Returns
    -------
    pandas.DataFrame
        For each part and quantity: number of cases, rank correlation (Spearman 1904), and the mean
        rates in the lower and in the upper third of the values with the ranges of these. Parts are
        in their order, quantities in falling order of their largest correlation.
    """
    names = varied_quantities(cases)
    known = cases.set_index("case_id")
    rows = []
    for part in dict.fromkeys(parts["part_name"]):
        of_part = parts[parts["part_name"] == part]
        values = known.loc[of_part["case_id"], names]
        rate = of_part[column].to_numpy()
        if len(rate) >= FEWEST_CASES:
            rows += [_effect(part, name, values[name].to_numpy(), rate) for name in names]
    columns = [
        "part_name", "quantity", "unit", "cases", "rank_correlation",
        "low_from", "low_to", "low_rate", "high_from", "high_to", "high_rate",
    ]  # fmt: skip
    table = pd.DataFrame(rows, columns=columns)
    texts = {"part_name": "str", "quantity": "str", "unit": "str", "cases": "int64"}
    table = table.astype({name: texts.get(name, "float64") for name in columns})
    strength = table.groupby("quantity")["rank_correlation"].transform(lambda r: r.abs().max())
    order = np.lexsort((-strength.to_numpy(), pd.factorize(table["part_name"])[0]))
    return table.iloc[order].reset_index(drop=True)


def _effect(part: str, name: str, values: np.ndarray, rate: np.ndarray) -> dict:
    order = np.argsort(values, kind="stable")
    third = max(1, len(rate) // 3)
    low, high = order[:third], order[-third:]
    return {
        "part_name": part,
        "quantity": name,
        "unit": unit_of_quantity(name),
        "cases": len(rate),
        "rank_correlation": _rank_correlation(values, rate),
        "low_from": values[low[0]],
        "low_to": values[low[-1]],
        "low_rate": rate[low].mean(),
        "high_from": values[high[0]],
        "high_to": values[high[-1]],
        "high_rate": rate[high].mean(),
    }


def _rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Correlation of the ranks; nan if one of the two is constant."""
    ranks = [pd.Series(values).rank().to_numpy() for values in (first, second)]
    if any(np.ptp(rank) == 0.0 for rank in ranks):
        return float("nan")
    return float(np.corrcoef(*ranks)[0, 1])
