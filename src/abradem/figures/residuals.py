"""Residuals of the linear regression, and dependence among the features."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.learning.number_text import UNDETERMINED, is_number

HIGH_INFLATION = 10.0
"""Variance inflation factors above this value are commonly called high."""


def residuals_figure(residuals: pd.DataFrame, coefficients: pd.DataFrame, model: dict) -> Figure:
    """Residuals of the linear equation, their quantiles, and variance inflation factors.

    Parameters
    ----------
    residuals, coefficients : pandas.DataFrame
        From `abradem.learning.baselines.linear.fit_linear`.
    model : dict
        Summary of the model.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style.style():
        figure, axes = style.panels(3, 3, 3.2)
        _against_fitted(axes[0], residuals, model)
        _quantiles(axes[1], residuals)
        _inflation(axes[2], coefficients)
        figure.legend(handles=style.feature_handles(), loc="outside upper right", ncols=2)
        style.caption(
            figure,
            f"least squares on all {len(residuals)} rows, descriptive, without training and test "
            f"rows, hence the same under both protocols; p of the Breusch-Pagan test, small if the "
            "variance of the residuals depends on the features; dashed in (b): normal "
            f"distribution, in (c): {HIGH_INFLATION:g}",
        )
    return figure


def _against_fitted(panel, residuals: pd.DataFrame, model: dict) -> None:
    panel.scatter(
        residuals["fitted"], residuals["residual"], s=7, color=style.BLUE, lw=0, alpha=0.7
    )
    panel.axhline(0.0, color=style.BLACK, lw=0.6)
    panel.set_xlabel("Fitted wear (standard deviations)")
    panel.set_ylabel("Residual (standard deviations)")
    p_value = model["breusch_pagan"]["p_value"]
    words = f"p {UNDETERMINED}"
    if is_number(p_value):
        size = f"= {p_value:.2g}" if p_value >= 1e-4 else r"< $10^{-4}$"
        size = size if "e" not in size else f"= {style.number(p_value, 2)}"
        words = f"p {size}"
    panel.set_title(f"{style.letter(0)} residuals, Breusch-Pagan {words}", loc="left", fontsize=7.0)


def _quantiles(panel, residuals: pd.DataFrame) -> None:
    expected, found = residuals["normal_quantile"], residuals["studentised"]
    if not np.isfinite(found).any():
        style.say_nothing_to_show(panel, "no residuals: as many coefficients as rows")
        return
    panel.scatter(expected, found, s=7, color=style.BLUE, lw=0, alpha=0.7)
    ends = np.array([expected.min(), expected.max()]) * 1.05
    panel.plot(ends, ends, color=style.BLACK, ls="--", lw=0.9)
    panel.set_xlabel("Quantile of the normal distribution")
    panel.set_ylabel("Studentised residual")
    panel.set_title(f"{style.letter(1)} distribution of the residuals", loc="left", fontsize=7.0)


def _inflation(panel, coefficients: pd.DataFrame) -> None:
    values = coefficients["variance_inflation"].to_numpy(dtype=float)
    finite = values[np.isfinite(values)]
    most = finite.max(initial=HIGH_INFLATION) * 3.0
    places = np.arange(len(values))
    shown = np.where(np.isinf(values), most, values)
    colours = style.feature_colours(coefficients["feature"])
    panel.barh(places, np.nan_to_num(shown, nan=1.0) - 0.8, left=0.8, height=0.66, color=colours)
    panel.set_xscale("log")
    panel.set_xlim(0.8, most)
    panel.axvline(HIGH_INFLATION, color=style.BLACK, ls="--", lw=0.8)
    style.feature_rows(panel, coefficients["feature"])
    style.name_fixed(panel, coefficients["variation"])
    panel.set_xlabel("Variance inflation factor")
    panel.set_title(f"{style.letter(2)} dependence of features", loc="left", fontsize=7.0)
