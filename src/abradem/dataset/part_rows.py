"""The rows of a data set with the wear of a named part of a geometry in place of the whole."""

from __future__ import annotations

import pandas as pd

from abradem.quantities import STDERR_COLUMNS, WEAR_COLUMNS
from abradem.store.files import TableError


def part_rows(dataset: pd.DataFrame, parts: pd.DataFrame, part: str) -> pd.DataFrame:
    """Return the rows of a data set whose wear rates are those of a part.

    Parameters
    ----------
    dataset : pandas.DataFrame
        From `abradem.dataset.join.join`.
    parts : pandas.DataFrame
        From `abradem.wear.surface_cells.part_table`.
    part : str
        Name of the part.

    Returns
    -------
    pandas.DataFrame
        The columns of ``dataset`` without standard errors, which a part has none of.

    Raises
    ------
    TableError
        If there is no such part, or nothing wore it.
    """
    names = list(dict.fromkeys(parts["part_name"]))
    if part not in names:
        raise TableError(f"learning.part: there is no part {part!r} (allowed {', '.join(names)})")
    rates = parts[parts["part_name"] == part][["case_id", *WEAR_COLUMNS]]
    kept = dataset.drop(columns=[*WEAR_COLUMNS, *STDERR_COLUMNS])
    found = kept.merge(rates, on="case_id", how="inner", validate="1:1")
    order = [name for name in dataset if name in found]
    return found[order].sort_values("case_id", ignore_index=True)
