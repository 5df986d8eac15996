"""Selection of the cases shown in a figure, and concatenation of their tables."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd


def runs_shown(runs: pd.DataFrame, shown: Sequence[int]) -> list[dict]:
    """Rows of ``runs`` for the cases ``shown``, in that order; missing cases are left out."""
    records = {run["case_id"]: run for run in runs.to_dict("records")}
    return [records[key] for key in dict.fromkeys(shown) if key in records]


def stacked(frames: list[pd.DataFrame], columns: Sequence[str]) -> pd.DataFrame:
    """Concatenate tables; of none, an empty table with the given columns."""
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=list(columns))
