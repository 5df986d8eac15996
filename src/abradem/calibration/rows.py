"""Which rows of a table the search uses, in which order, and which it holds out."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pandas as pd

from abradem.quantities import SAMPLED_NAMES

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def arranged_rows(
    table: pd.DataFrame,
    target: str,
    every: int,
    least_radius: float,
    leave_out: Collection[int] = (),
) -> pd.DataFrame:
    """Return the rows with their part in the search.

    The rows are sorted by their wear rate, and every ``every``-th is held out, so that the rows
    used and those held out cover the same range. The rows used are taken in the order of the
    golden-ratio sequence of their ranks (the first n cover the range evenly for every n).

    Parameters
    ----------
    table : pandas.DataFrame
        From `abradem.dataset.external.read_external`.
    target : str
        Column of the wear rate, mm/s.
    every : int
        0 holds nothing out.
    least_radius : float
        Rows with smaller particles, m, are left out of the search: they are the most expensive.
    leave_out : collection of int
        Further rows that are left out, by ``case_id``.

    Returns
    -------
    pandas.DataFrame
        case_id, block, seed, the sampled quantities, ``rejected`` (empty), ``given`` (wear rate,
        mm/s) and ``part``: "used", "held out" or "left out". Rows used come first, in their order.
    """
    rows = table[["case_id", *SAMPLED_NAMES]].copy()
    rows["block"], rows["seed"], rows["rejected"] = 0, rows["case_id"], ""
    rows["given"] = table[target].to_numpy(dtype=float)
    rows = rows.sort_values(["given", "case_id"], kind="stable", ignore_index=True)
    left = (rows["particle_radius"] < least_radius) | rows["case_id"].isin(list(leave_out))
    part = np.where(left, "left out", "used").astype(object)
    considered = np.flatnonzero(~left)
    if every:
        # From the middle of a stride, so that neither the lowest nor the highest is held out.
        part[considered[every // 2 :: every]] = "held out"
    rows["part"] = part
    used = rows[rows["part"] == "used"]
    place = (np.arange(len(used)) + 0.5) / max(len(used), 1)
    # The row whose rank is nearest to the k-th point of the sequence that is still free.
    order, free = [], list(range(len(used)))
    for k in range(len(used)):
        point = (0.5 + k * GOLDEN) % 1.0
        best = min(free, key=lambda at: (abs(place[at] - point), at))
        free.remove(best)
        order.append(best)
    others = rows[rows["part"] != "used"].sort_values("case_id", kind="stable")
    return pd.concat([used.iloc[order], others], ignore_index=True)
