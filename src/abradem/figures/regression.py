"""What stands behind the regressions: residuals, dependence of features, penalties, selection."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from abradem.figures import style
from abradem.figures.words import AS_PUBLISHED, COLOURS, HONEST, MODELS, PROTOCOLS, feature_rows
from abradem.parameters import quantity

HIGH_INFLATION = 10.0
"""From here on a variance inflation factor is commonly called high."""


def residuals_figure(residuals: pd.DataFrame, coefficients: pd.DataFrame, model: dict) -> Figure:
    """Residuals of the linear equation, their quantiles, and variance inflation factors.

    Parameters
    ----------
    residuals, coefficients : pandas.DataFrame
        From `abradem.learning.linear.fit_linear`.
    model : dict
        Its summary.

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
            f"least squares on all {len(residuals)} rows: a description, without training and test "
            f"rows, hence the same under both protocols; p of the test of Breusch and Pagan, small "
            "where the scatter depends on the features; dashed in (b): normal, in (c): "
            f"{HIGH_INFLATION:g}",
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
    words = "cannot be tested"
    if p_value is not None and np.isfinite(p_value):
        size = f"= {p_value:.2g}" if p_value >= 1e-4 else r"< $10^{-4}$"
        size = size if "e" not in size else f"= {style.number(p_value, 2)}"
        words = f"p {size}"
    panel.set_title(f"{style.letter(0)} residuals, Breusch-Pagan {words}", loc="left", fontsize=7.0)


def _quantiles(panel, residuals: pd.DataFrame) -> None:
    expected, found = residuals["normal_quantile"], residuals["studentised"]
    if not np.isfinite(found).any():
        style.say_nothing_to_show(panel, "no scatter to judge: as many coefficients as rows")
        return
    panel.scatter(expected, found, s=7, color=style.BLUE, lw=0, alpha=0.7)
    ends = np.array([expected.min(), expected.max()]) * 1.05
    panel.plot(ends, ends, color=style.BLACK, ls="--", lw=0.9)
    panel.set_xlabel("Quantile of the normal distribution")
    panel.set_ylabel("Studentised residual")
    panel.set_title(f"{style.letter(1)} shape of the residuals", loc="left", fontsize=7.0)


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
    feature_rows(panel, coefficients["feature"])
    panel.set_xlabel("Variance inflation factor")
    panel.set_title(f"{style.letter(2)} dependence of features", loc="left", fontsize=7.0)


NAMED = 6
"""Paths of the largest weights are named, the others are grey."""


def penalised_figure(
    paths: pd.DataFrame, validation: pd.DataFrame, weights: pd.DataFrame, summary: dict
) -> Figure:
    """Paths of lasso and ridge, their cross-validation, and the weights of both protocols.

    Parameters
    ----------
    paths, validation, weights : pandas.DataFrame
        From `abradem.learning.penalised.fit_penalised`.
    summary : dict

    Returns
    -------
    matplotlib.figure.Figure
    """
    models = list(dict.fromkeys(paths["model"]))
    with style.style():
        figure, axes = style.panels(6, 3, 3.2)
        # Those that the lasso keeps as published, then the largest of the ridge.
        of_paper = weights[weights["protocol"] == AS_PUBLISHED].assign(
            size=lambda rows: rows["weight"].abs()
        )
        ranked = of_paper.sort_values(["model", "size"], ascending=[True, False], kind="stable")
        named = list(dict.fromkeys(ranked.loc[ranked["size"] > 0.0, "feature"]))[:NAMED]
        for row, model in enumerate(models):
            alphas = summary[model]["alpha"]
            first = 3 * row
            _path_panel(axes[first], first, model, paths, named, alphas)
            _validation_panel(axes[first + 1], first + 1, model, validation, alphas)
            _weights_panel(axes[first + 2], first + 2, model, weights)
        figure.legend(
            handles=[
                *(Line2D([], [], color=style.PALETTE[i], label=f"{quantity(name).symbol} "
                         f"${quantity(name).tex}$") for i, name in enumerate(named)),
                Line2D([], [], color=style.LIGHT_GREY, label="others"),
                Line2D([], [], color=COLOURS[AS_PUBLISHED], ls=":", label="penalty as published"),
                Line2D([], [], color=COLOURS[HONEST], ls="--", label="cross-validated"),
                *(Patch(color=COLOURS[name], label=f"weights, {PROTOCOLS[name]}")
                  for name in (AS_PUBLISHED, HONEST)),
            ],
            loc="outside upper center",
            ncols=6,
        )  # fmt: skip
        style.caption(
            figure,
            "(a, b, d, e): all rows, standardised; cross-validated $R^2$ is the mean over the "
            "folds, band: its standard error. (c, f): weights as published (scaler of all rows, "
            "penalty given) and honest (mean over the repeated splits, penalty cross-validated "
            "inside the training rows); numbers: share of the honest splits in which the feature "
            "survives",
        )
    return figure


def _path_panel(panel, index, model, paths, named, alphas) -> None:
    mine = paths[paths["model"] == model]
    for name, rows in mine.groupby("feature", sort=False):
        shown = name in named
        colour = style.PALETTE[named.index(name)] if shown else style.LIGHT_GREY
        panel.plot(
            rows["alpha"], rows["weight"], color=colour, lw=1.1 if shown else 0.8,
            zorder=2 if shown else 1,
        )  # fmt: skip
    # Least squares of dependent features would dwarf the rest.
    reach = 1.3 * mine.loc[mine["feature"].isin(named[:3]), "weight"].abs().max() or 1.0
    panel.set_ylim(-reach, reach)
    panel.axhline(0.0, color=style.BLACK, lw=0.5)
    _alpha_axis(panel, alphas)
    panel.set_ylabel("Standardised weight")
    panel.set_title(f"{style.letter(index)} {model}: path", loc="left", fontsize=7.0)


def _validation_panel(panel, index, model, validation, alphas) -> None:
    mine = validation[validation["model"] == model]
    low, high = (mine["mean"] + sign * mine["stderr_of_mean"] for sign in (-1.0, 1.0))
    panel.fill_between(mine["alpha"], low, high, color=style.SKY, alpha=0.35, lw=0)
    panel.plot(mine["alpha"], mine["mean"], color=style.BLUE)
    _alpha_axis(panel, alphas)
    panel.set_ylabel("Cross-validated $R^2$")
    panel.set_title(f"{style.letter(index)} {model}: choice of penalty", loc="left", fontsize=7.0)


def _alpha_axis(panel, alphas) -> None:
    panel.set_xscale("log")
    panel.set_xlabel(r"Penalty $\alpha$")
    panel.axvline(alphas[AS_PUBLISHED], color=COLOURS[AS_PUBLISHED], ls=":", lw=1.0)
    panel.axvline(alphas[HONEST], color=COLOURS[HONEST], ls="--", lw=0.9)


def _weights_panel(panel, index, model, weights) -> None:
    mine = weights[weights["model"] == model]
    features = list(dict.fromkeys(mine["feature"]))
    places = np.arange(len(features))
    reach = 0.0
    for shift, protocol in ((-0.2, AS_PUBLISHED), (0.2, HONEST)):
        rows = mine[mine["protocol"] == protocol].set_index("feature").loc[features]
        panel.barh(places + shift, rows["weight"], height=0.4, color=COLOURS[protocol])
        reach = max(reach, float(rows["weight"].abs().max()))
    reach = 1.45 * reach or 1.0
    panel.set_xlim(-reach, reach)
    if model == "lasso":
        for place, share in zip(places, rows["survives"], strict=True):
            panel.text(reach, place, f"{share:.2f}", fontsize=6.5, va="center", ha="right")
    panel.axvline(0.0, color=style.BLACK, lw=0.5)
    panel.xaxis.set_major_locator(MaxNLocator(4))
    feature_rows(panel, features)
    panel.set_xlabel("Standardised weight")
    panel.set_title(f"{style.letter(index)} {MODELS[model]}: weights", loc="left", fontsize=7.0)


def selection_figure(selection: pd.DataFrame, summary: dict) -> Figure:
    """The features chosen by weight and by loading, beside the study's own list.

    Parameters
    ----------
    selection : pandas.DataFrame
    summary : dict
        From `abradem.learning.selection.fit_selection`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style.style():
        figure, axes = style.panels(3, 3, 3.3)
        published = selection[selection["protocol"] == AS_PUBLISHED]
        places = np.arange(len(published))
        largest = published[["lasso_weight", "ridge_weight"]].abs().max(axis=1)
        for panel, index, values, words in (
            (axes[0], 0, largest, "Largest absolute weight"),
            (axes[1], 1, published["leading_share"], "Share in leading components"),
        ):
            by = ("weight", "loading")[index]
            chosen = published["chosen_by"] == by
            colours = np.where(chosen, COLOURS[AS_PUBLISHED], style.LIGHT_GREY)
            panel.barh(places, values, height=0.66, color=colours)
            feature_rows(panel, published["feature"])
            panel.set_xlabel(words)
            panel.set_title(
                f"{style.letter(index)} chosen by {by}, as published", loc="left", fontsize=7.0
            )
        _survival(axes[2], selection[selection["protocol"] == HONEST])
        shared = {name: summary[name]["shared_with_paper"] for name in (AS_PUBLISHED, HONEST)}
        style.caption(
            figure,
            f"{summary['count']} features, half by weight (larger of lasso and ridge), half by "
            "squared loadings on the components that hold half of the variance; grey in (a, b): "
            f"not chosen. Shared with the paper's 12: {shared[AS_PUBLISHED]} as published (all "
            f"rows, min-max scaling), {shared[HONEST]} honest (training rows of the first split)",
        )
    return figure


def _survival(panel, honest) -> None:
    places = np.arange(len(honest))
    panel.barh(places, honest["survives"], height=0.66, color=COLOURS[HONEST])
    listed = honest["in_paper"].to_numpy(dtype=bool)
    panel.plot(np.full(listed.sum(), 1.06), places[listed], "o", color=style.BLACK, ms=3.0)
    panel.set_xlim(0.0, 1.12)
    feature_rows(panel, honest["feature"])
    panel.set_xlabel("Share of splits that choose it")
    panel.set_title(f"{style.letter(2)} honest; dot: in the paper's list", loc="left", fontsize=7.0)
