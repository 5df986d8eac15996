"""Distributions of standardised wear, of predictions on test rows, and of their errors."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.learning.rows import standard_scaler
from abradem.words.labels import MODELS, PROTOCOLS

_BINS = 24


def draw(dataset: pd.DataFrame, predictions: pd.DataFrame, target: str, model: str) -> Figure:
    """Draw `distributions_figure` for the predictions of a model, see `standardised`."""
    return distributions_figure(standardised(dataset, predictions, target, model), model)


def distributions_figure(table: pd.DataFrame, model: str) -> Figure:
    """Histograms of the wear of all rows, of predictions on the test rows, and of their errors.

    Parameters
    ----------
    table : pandas.DataFrame
        From `abradem.figures.distributions.standardised`.
    model : str
        Name of the model, shown in the caption.
    """
    with style.style():
        figure, axes = style.panels(4, 2, 1.85)
        values = table[["actual_standardised", "predicted_standardised"]].to_numpy(dtype=float)
        finite = values[np.isfinite(values)]
        bins = np.linspace(np.floor(finite.min()), np.ceil(finite.max()), _BINS + 1)
        rows = table.loc[table["protocol"] == ALL_ROWS, "actual_standardised"]
        axes[0].hist(rows, bins=bins, color=style.LIGHT_GREY, edgecolor=style.GREY, lw=0.5)
        axes[0].set_title(f"{style.letter(0)} all {len(rows)} rows", loc="left")
        shown = [name for name in (AS_PUBLISHED, LEAKAGE_FREE) if name in set(table["protocol"])]
        for index, protocol in enumerate((AS_PUBLISHED, LEAKAGE_FREE), start=1):
            _test_rows(axes[index], index, table[table["protocol"] == protocol], protocol, bins)
        _errors(axes[3], table, shown)
        for panel in axes:
            panel.set_ylabel("Rows")
            panel.yaxis.get_major_locator().set_params(integer=True)
        for panel in axes[:3]:
            panel.set_xlabel("Wear depth rate (standard deviations from the mean)")
        axes[3].set_xlabel("Predicted minus simulated (standard deviations)")
        figure.legend(
            handles=[
                Patch(facecolor=style.LIGHT_GREY, edgecolor=style.GREY, label="simulated"),
                *(
                    Line2D([], [], color=style.PROTOCOL_COLOURS[name], lw=1.2,
                           label=f"predicted, {PROTOCOLS[name]}")
                    for name in shown
                ),
            ],
            loc="outside upper center",
            ncols=3,
        )  # fmt: skip
        style.caption(
            figure,
            f"model: {MODELS.get(model, model)}; test rows of one split, which differ between the "
            "protocols; standardised with the mean and standard deviation of all rows",
        )
    return figure


def _test_rows(panel, index, rows, protocol, bins) -> None:
    panel.set_title(
        f"{style.letter(index)} {PROTOCOLS[protocol]}: {len(rows)} test rows", loc="left"
    )
    panel.hist(
        rows["actual_standardised"], bins=bins, color=style.LIGHT_GREY, edgecolor=style.GREY, lw=0.5
    )
    panel.hist(
        rows["predicted_standardised"],
        bins=bins,
        histtype="step",
        color=style.PROTOCOL_COLOURS[protocol],
        lw=1.2,
    )


def _errors(panel, table, shown) -> None:
    rows = table[table["protocol"].isin(shown)]
    reach = float(rows["error_standardised"].abs().max()) if len(rows) else 1.0
    bins = np.linspace(-reach, reach, _BINS)
    for protocol in shown:
        errors = rows.loc[rows["protocol"] == protocol, "error_standardised"]
        mean, spread = errors.mean(), errors.std(ddof=0)
        panel.hist(
            errors, bins=bins, histtype="step", color=style.PROTOCOL_COLOURS[protocol], lw=1.2,
            label=f"{style.number(round(mean, 3), 2)} ± {style.number(spread, 2)}",
        )  # fmt: skip
    panel.axvline(0.0, color=style.BLACK, lw=0.5, ls="--")
    panel.set_title(f"{style.letter(3)} errors: mean ± standard deviation", loc="left")
    if shown:
        panel.legend(loc="upper left")


ALL_ROWS = "all rows"
"""Value of the column ``protocol`` for the rows of the data set."""


def standardised(dataset: pd.DataFrame, predictions: pd.DataFrame, target: str, model: str):
    """Standardised wear of all rows, and predictions of a model on the test rows of a split.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Mean and standard deviation of its target standardise all values.
    predictions : pandas.DataFrame
        model, protocol, case_id, repeat, split, actual, predicted.
    target : str
        Column of ``dataset``.
    model : str

    Returns
    -------
    pandas.DataFrame
        protocol (`ALL_ROWS` for the rows of ``dataset``, whose predictions are nan), case_id,
        actual_standardised, predicted_standardised, error_standardised (dimensionless).
    """
    wear = dataset[target]
    mean, spread = map(float, standard_scaler(wear.to_numpy(dtype=float)))
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
