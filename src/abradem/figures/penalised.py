"""Lasso and ridge: paths, penalties and weights."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.quantities import quantity
from abradem.words.labels import LABELS, MODELS, PROTOCOLS

NAMED = 6
"""Number of features, those with the largest weights, whose paths are coloured and named."""


def penalised_figure(
    paths: pd.DataFrame, validation: pd.DataFrame, weights: pd.DataFrame, summary: dict
) -> Figure:
    """Paths of lasso and ridge, their cross-validation, and the weights of both protocols.

    Parameters
    ----------
    paths, validation, weights : pandas.DataFrame
        From `abradem.learning.baselines.penalised.fit_penalised`.
    summary : dict

    Returns
    -------
    matplotlib.figure.Figure
    """
    models = list(dict.fromkeys(paths["model"]))
    with style.style():
        figure, axes = style.panels(6, 3, 3.2)
        # Features kept by the lasso as published, then the largest weights of the ridge.
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
                         f"${LABELS[name].tex}$") for i, name in enumerate(named)),
                Line2D([], [], color=style.LIGHT_GREY, label="others"),
                Line2D([], [], color=style.PROTOCOL_COLOURS[AS_PUBLISHED], ls=":",
                       label="penalty as published"),
                Line2D([], [], color=style.PROTOCOL_COLOURS[LEAKAGE_FREE], ls="--",
                       label="cross-validated"),
                *(Patch(color=style.PROTOCOL_COLOURS[name], label=f"weights, {PROTOCOLS[name]}")
                  for name in (AS_PUBLISHED, LEAKAGE_FREE)),
            ],
            loc="outside upper center",
            ncols=6,
        )  # fmt: skip
        style.caption(
            figure,
            "(a, b, d, e) all rows, standardised; cross-validated $R^2$: mean over the folds, "
            "band: its standard error. (c, f) weights as published (scaler of all rows, fixed "
            "penalty) and leakage-free (mean over the repeated splits, penalty cross-validated "
            "inside the training rows); kept in: share of the leakage-free splits in which the "
            "lasso keeps the feature" + style.sharing(weights),
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
    # Weights of dependent features are very large for small penalties.
    reach = 1.3 * mine.loc[mine["feature"].isin(named[:3]), "weight"].abs().max()
    reach = reach if reach > 0.0 else 1.0
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
    panel.axvline(alphas[AS_PUBLISHED], color=style.PROTOCOL_COLOURS[AS_PUBLISHED], ls=":", lw=1.0)
    panel.axvline(alphas[LEAKAGE_FREE], color=style.PROTOCOL_COLOURS[LEAKAGE_FREE], ls="--", lw=0.9)


def _weights_panel(panel, index, model, weights) -> None:
    mine = weights[weights["model"] == model]
    features = list(dict.fromkeys(mine["feature"]))
    places = np.arange(len(features))
    reach = 0.0
    for shift, protocol in ((-0.2, AS_PUBLISHED), (0.2, LEAKAGE_FREE)):
        rows = mine[mine["protocol"] == protocol].set_index("feature").loc[features]
        panel.barh(
            places + shift, rows["weight"], height=0.4, color=style.PROTOCOL_COLOURS[protocol]
        )
        reach = max(reach, float(rows["weight"].abs().max()))
    reach = 1.45 * reach or 1.0
    panel.set_xlim(-reach, reach)
    if model == "lasso":
        for place, share in zip(places, rows["survives"], strict=True):
            if not np.isfinite(share):
                continue
            panel.text(reach, place, f"{share:.2f}", fontsize=6.5, va="center", ha="right")
    panel.axvline(0.0, color=style.BLACK, lw=0.5)
    panel.xaxis.set_major_locator(MaxNLocator(4))
    style.feature_rows(panel, features)
    style.name_fixed(panel, rows["variation"])
    if model == "lasso":
        # A row above the first feature, for the header of the numbers.
        panel.set_ylim(panel.get_ylim()[0], -1.6)
        panel.text(reach, -1.05, "kept in", fontsize=6.5, va="center", ha="right")
    panel.set_xlabel("Standardised weight")
    panel.set_title(f"{style.letter(index)} {MODELS[model]}: weights", loc="left", fontsize=7.0)
