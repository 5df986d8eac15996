"""Which cases stand for the parameter space in a gallery of wear maps."""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.dataset import Column

COLUMNS = {
    "row": Column("1", "row of the gallery", "int32"),
    "column": Column("1", "column of the gallery", "int32"),
}
"""Columns of the table beside those of `abradem.dataset.COLUMNS`."""


def chosen_cases(
    cases: pd.DataFrame, runs: pd.DataFrame, across: str, down: str, columns: int, rows: int
) -> pd.DataFrame:
    """The case nearest to the middle of each cell of a grid over two quantities.

    Parameters
    ----------
    cases, runs : pandas.DataFrame
        Cases without a window of facets are not chosen.
    across, down : str
        Quantities that grow from left to right and from top to bottom.
    columns, rows : int
        Cells; the quantities' spans are divided evenly.

    Returns
    -------
    pandas.DataFrame
        case_id, row, column; a cell without a case has no line.
    """
    good = runs[(runs["status"] == "ok") & (runs["window_end"] > runs["window_start"])]
    known = cases[cases["case_id"].isin(good["case_id"])].reset_index(drop=True)
    if known.empty:
        return pd.DataFrame({"case_id": [], "row": [], "column": []}, dtype=int)
    place = {}
    for name, count in ((across, columns), (down, rows)):
        low, high = cases[name].min(), cases[name].max()
        place[name] = count * (known[name] - low) / ((high - low) or 1.0)
    cell = {
        name: np.clip(place[name].astype(int), 0, count - 1)
        for name, count in ((across, columns), (down, rows))
    }
    off = sum((place[name] - cell[name] - 0.5) ** 2 for name in (across, down))
    table = pd.DataFrame(
        {"case_id": known["case_id"], "row": cell[down], "column": cell[across], "off": off}
    )
    nearest = table.sort_values(["off", "case_id"]).drop_duplicates(["row", "column"])
    return nearest.sort_values(["row", "column"], ignore_index=True)[["case_id", "row", "column"]]
