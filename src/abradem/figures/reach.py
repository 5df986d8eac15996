"""Extrapolation beyond the training ranges, and scores for all wear rates."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from abradem.figures import style
from abradem.learning.number_text import percentage, score_number
from abradem.quantities import STATISTICS, WEAR_MEASURES
from abradem.words.labels import MODELS

_KEYS = ("r2", "within_r2")


def reach_figure(extrapolation: pd.DataFrame, targets: pd.DataFrame, table: str) -> Figure:
    """R2 of extrapolation beyond the training ranges, and R2 for all wear rates.

    Parameters
    ----------
    extrapolation : pandas.DataFrame
        From `abradem.learning.physical.reach.extrapolate`.
    targets : pandas.DataFrame
        From `abradem.learning.physical.models.all_targets`.
    table : str
        Name of the data set.
    """
    with style.style():
        figure = style.new_figure(style.PAGE, 2.9)
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
        _beyond(left, extrapolation)
        _targets(right, targets)
        style.caption(
            figure,
            f"data set: {table}. (a) filled: rows beyond the bound, models trained on the others; "
            "open: the same rows by cross-validation over all rows; number: share of the rows "
            "beyond the bound inside the 95 % intervals of the Gaussian process. (b) Gaussian "
            "process, median over the splits of $R^2$ of the wear (in brackets: of the "
            "logarithm of the wear number)",
        )
    return figure


def _beyond(panel: Axes, extrapolation: pd.DataFrame) -> None:
    panel.set_title(f"{style.letter(0)} extrapolation", loc="left")
    if extrapolation.empty:
        style.say_nothing_to_show(panel, "no range can be held out: held fixed, or too few rows")
        return
    tests = list(dict.fromkeys(extrapolation["test"]))
    models = list(dict.fromkeys(extrapolation["model"]))
    labels = []
    for place, test in enumerate(tests):
        rows = extrapolation[extrapolation["test"] == test].set_index("model")
        for step, model in enumerate(models):
            y = place + 0.22 * (step - 0.5 * (len(models) - 1))
            beyond, within = (np.maximum(rows.loc[model, key], -0.5) for key in _KEYS)
            colour = style.MODEL_COLOURS[model]
            panel.plot([beyond, within], [y, y], color=colour, lw=0.8)
            panel.plot(within, y, "o", ms=4.0, mfc="white", mec=colour)
            panel.plot(beyond, y, "o", ms=4.0, color=colour)
            if np.isfinite(rows.loc[model, "coverage"]) and np.isfinite(min(beyond, within)):
                panel.annotate(
                    percentage(rows.loc[model, "coverage"]),
                    (min(beyond, within), y), xytext=(-6.0, 0.0), textcoords="offset points",
                    ha="right", va="center", fontsize=6.5, color=colour,
                )  # fmt: skip
        first = rows.iloc[0]
        rows_of_all = f"{first['tested']} of {first['trained'] + first['tested']}"
        labels.append(f"{first['words']}\n({rows_of_all})")
    panel.set_yticks(range(len(tests)), labels)
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(tests) - 0.4, -0.6)
    low = float(np.nanmin([*extrapolation["r2"], *extrapolation["within_r2"], 1.0]))
    span = max(1.0 - max(low, -0.5), 0.02)
    panel.set_xlim(1.0 - 1.25 * span, 1.0 + 0.02 * span)
    panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
    panel.set_axisbelow(True)
    panel.set_xlabel("$R^2$")
    panel.legend(
        handles=[
            Line2D([], [], marker="o", ms=4.0, color=style.MODEL_COLOURS[m], label=MODELS[m])
            for m in models
        ],
        loc="upper center", bbox_to_anchor=(0.4, -0.22), ncols=3, columnspacing=1.0,
    )  # fmt: skip


def _targets(panel: Axes, targets: pd.DataFrame) -> None:
    panel.set_title(f"{style.letter(1)} all wear rates", loc="left")
    rows = targets[targets["model"] == "gaussian_process"].set_index("target")
    measures = [r for r in WEAR_MEASURES if f"wear_{r}_mean" in rows.index]
    statistics = [
        s for s in STATISTICS
        if any(f"wear_{r}_{s}" in rows.index for r in measures)
    ]  # fmt: skip
    values = np.array([[_score(rows, f"wear_{m}_{s}", "r2") for s in statistics] for m in measures])
    finite = values[np.isfinite(values)]
    low = float(np.clip(np.floor(20.0 * finite.min(initial=0.95)) / 20.0, -1.0, 0.95))
    mesh = panel.imshow(values, cmap="viridis_r", vmin=low, vmax=1.0, aspect="auto")
    for (i, j), value in np.ndenumerate(values):
        name = f"wear_{measures[i]}_{statistics[j]}"
        if name in rows.index:
            of_number = style.minus(score_number(rows.loc[name, "r2_number"], 2))
            panel.text(
                j, i, f"{style.minus(score_number(value, 3))}\n({of_number})", ha="center",
                va="center", fontsize=7.0,
                color="white" if value > low + 0.5 * (1.0 - low) else "black",
            )  # fmt: skip
    bar = panel.figure.colorbar(mesh, ax=panel, pad=0.03, aspect=25)
    bar.outline.set_linewidth(0.6)
    bar.set_label("$R^2$")
    words = {"mean": "plate", "worn": "worn", "footprint": "footprint", "p99": "99th perc.",
             "max": "worst"}  # fmt: skip
    panel.set_xticks(range(len(statistics)), [words[s] for s in statistics], fontsize=6.5)
    panel.set_yticks(range(len(measures)), measures)
    panel.tick_params(length=0)
    for side in panel.spines.values():
        side.set_visible(False)


def _score(rows: pd.DataFrame, target: str, column: str) -> float:
    """A score of a target; nan where it was not learned."""
    return float(rows.loc[target, column]) if target in rows.index else np.nan
