"""Which cases a figure shows, and their tables stacked."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd


def runs_shown(runs: pd.DataFrame, shown: Sequence[int]) -> list[dict]:
    """Runs of the cases shown, in that order; cases that do not exist are left out."""
    records = {run["case_id"]: run for run in runs.to_dict("records")}
    return [records[key] for key in dict.fromkeys(shown) if key in records]


def stacked(frames: list[pd.DataFrame], columns: Sequence[str]) -> pd.DataFrame:
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=list(columns))
