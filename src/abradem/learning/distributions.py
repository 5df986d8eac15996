"""Distributions of standardised wear, of its predictions and of their errors."""

from __future__ import annotations

import pandas as pd

from abradem.dataset import Column

COLUMNS = {
    "actual_standardised": Column("1", "simulated wear, in standard deviations from the mean"),
    "predicted_standardised": Column("1", "predicted wear, on the same scale"),
    "error_standardised": Column("1", "predicted minus simulated, on the same scale"),
}
"""Columns of the table beside those of `abradem.dataset.COLUMNS`."""

ALL_ROWS = "all rows"


def standardised(dataset: pd.DataFrame, predictions: pd.DataFrame, target: str, model: str):
    """Wear of all rows, and predictions of a model on the test rows of its first split.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Its target gives mean and standard deviation, which standardise everything here.
    predictions : pandas.DataFrame
        model, protocol, case_id, repeat, split, actual, predicted.
    target : str
        Column of ``dataset``.
    model : str

    Returns
    -------
    pandas.DataFrame
        protocol (`ALL_ROWS` for the rows of ``dataset``, whose predictions are nan), case_id
        and the columns of `COLUMNS`.
    """
    wear = dataset[target]
    mean, spread = float(wear.mean()), float(wear.std(ddof=0)) or 1.0
    rows = predictions[
        (predictions["model"] == model)
        & (predictions["split"] == "test")
        & (predictions["repeat"] == 0)
    ]
    everything = pd.DataFrame(
        {
            "protocol": ALL_ROWS,
            "case_id": dataset["case_id"],
            "actual_standardised": (wear - mean) / spread,
            "predicted_standardised": float("nan"),
            "error_standardised": float("nan"),
        }
    )
    of_model = pd.DataFrame(
        {
            "protocol": rows["protocol"],
            "case_id": rows["case_id"],
            "actual_standardised": (rows["actual"] - mean) / spread,
            "predicted_standardised": (rows["predicted"] - mean) / spread,
            "error_standardised": (rows["predicted"] - rows["actual"]) / spread,
        }
    )
    return pd.concat([everything, of_model], ignore_index=True)
