"""Tables as text for the report, apart from their captions, which change no table."""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.learning.number_text import LARGEST


def readable(table: pd.DataFrame) -> pd.DataFrame:
    """A table as its text is written: cells without a number are empty.

    These are missing numbers, and numbers without bound, such as the variance inflation of a
    feature that others determine.
    """
    shown = table.copy()
    for name in shown.columns[shown.dtypes == "float64"]:
        values = shown[name].to_numpy()
        shown[name] = np.where(np.abs(values) <= LARGEST, values, np.nan)
    return shown
