"""Comparison of all models under both protocols."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from abradem.figures import style
from abradem.learning.number_text import score_number
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.words.labels import MODELS, PROTOCOLS

LOWEST = -1.0
SPLITS, FIXED = "repeated splits", "fixed split"


def comparison_figure(comparison: pd.DataFrame, beside_paper: pd.DataFrame, table: str) -> Figure:
    """R2 of every model: printed in the paper, reproduced as published, and leakage-free.

    Parameters
    ----------
    comparison, beside_paper : pandas.DataFrame
        From `abradem.learning.comparison`.
    table : str
        Name of the data set.
    """
    models = list(beside_paper["model"])
    with style.style():
        figure, (panel,) = style.panels(1, 1, 0.9 + 0.29 * len(models))
        places = np.arange(len(models))
        lows = []
        for shift, protocol, basis, marker in (
            (-0.2, AS_PUBLISHED, FIXED, "o"),
            (0.06, LEAKAGE_FREE, SPLITS, "s"),
            (0.26, LEAKAGE_FREE, FIXED, "^"),
        ):
            rows = comparison[
                (comparison["protocol"] == protocol) & (comparison["basis"] == basis)
            ].set_index("model")
            for place, model in zip(places, models, strict=True):
                if model not in rows.index:
                    continue
                row = rows.loc[model]
                colour = style.PROTOCOL_COLOURS[protocol]
                light = 0.45 if (protocol, basis) == (LEAKAGE_FREE, FIXED) else 1.0
                if np.isfinite(row["r2_lower"]):
                    ends = row[["r2_lower", "r2_upper"]].to_numpy(dtype=float)
                    panel.plot(
                        np.maximum(ends, LOWEST), [place + shift] * 2,
                        color=colour, lw=1.2, alpha=light, clip_on=False,
                    )  # fmt: skip
                if row["r2"] >= LOWEST:
                    panel.plot(row["r2"], place + shift, marker, ms=4.0, color=colour, alpha=light)
                least = row[["r2", "r2_lower"]].min()
                if least < LOWEST:
                    panel.plot(LOWEST, place + shift, "<", ms=3.5, color=colour, alpha=light)
                lows.append(least)
        printed = beside_paper["printed_r2"].to_numpy(dtype=float)
        panel.plot(printed, places - 0.2, "|", ms=9.0, mew=1.6, color=style.BLACK, zorder=3)
        low = min([0.0, *(value for value in lows if np.isfinite(value)),
                   *printed[np.isfinite(printed)]])  # fmt: skip
        panel.set_xlim(max(low, LOWEST) - 0.05, 1.02)
        panel.axvline(0.0, color=style.BLACK, lw=0.5)
        panel.set_yticks(places, [MODELS.get(model, model) for model in models])
        panel.tick_params(axis="y", length=0)
        panel.set_ylim(len(models) - 0.45, -0.55)
        panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
        panel.set_axisbelow(True)
        panel.set_xlabel("$R^2$ on held-out rows")
        figure.legend(handles=_handles(), loc="outside upper center", ncols=4)
        style.caption(
            figure,
            f"data set: {table}. As published: one split, choices made on all rows or on the test "
            f"rows ({optimistic(beside_paper)}the wrong target is the last component, not the "
            "wear); interval: bootstrap of the test rows. Leakage-free: median and central share "
            "of the repeated splits, and a bootstrap of the test rows of the first split, which "
            "are the same for "
            f"all models. Arrowhead: the interval extends below {style.minus(f'{LOWEST:g}')}; "
            "without a marker the score does so too",
        )
    return figure


def optimistic(beside_paper: pd.DataFrame) -> str:
    """The models whose score as published is above the leakage-free one."""
    above = beside_paper["as_published_r2"] > beside_paper["leakage_free_r2"]
    names = ", ".join(MODELS.get(name, name) for name in beside_paper.loc[above, "model"])
    return f"above leakage-free, hence optimistic: {names}; " if names else ""


def _handles() -> list:
    return [
        Line2D([], [], marker="|", ms=8.0, mew=1.6, color=style.BLACK, ls="", label="printed"),
        Line2D([], [], marker="o", ms=4.0, color=style.PROTOCOL_COLOURS[AS_PUBLISHED],
               label="as published, reproduced"),
        Line2D([], [], marker="s", ms=4.0, color=style.PROTOCOL_COLOURS[LEAKAGE_FREE],
               label="leakage-free, repeated splits"),
        Line2D([], [], marker="^", ms=4.0, color=style.PROTOCOL_COLOURS[LEAKAGE_FREE], alpha=0.45,
               label="leakage-free, first split"),
    ]  # fmt: skip


def predictions_figure(predictions: pd.DataFrame, comparison: pd.DataFrame) -> Figure:
    """Predicted against simulated wear on the test rows of a fixed split, for each model.

    Parameters
    ----------
    predictions, comparison : pandas.DataFrame
        From `abradem.learning.comparison`.
    """
    fixed = predictions[(predictions["repeat"] == 0) & (predictions["split"] == "test")]
    models = [model for model in MODELS if model in set(fixed["model"])]
    with style.style():
        figure, axes = style.panels(len(models), 4, 2.0)
        most = max(float(fixed["actual"].max()), 1e-300)
        power = style.decade(most)
        unit = 10.0**power
        low = max(min(0.0, float(fixed["predicted"].min())), -0.4 * most)
        high = max(min(float(fixed["predicted"].max()), 1.4 * most), most)
        pad = 0.04 * (high - low)
        ends = ((low - pad) / unit, (high + pad) / unit)
        beyond = bool(((fixed["predicted"] < low) | (fixed["predicted"] > high)).any())
        for index, (panel, model) in enumerate(zip(axes, models, strict=True)):
            words = []
            for protocol, marker in ((AS_PUBLISHED, "x"), (LEAKAGE_FREE, "o")):
                rows = fixed[(fixed["model"] == model) & (fixed["protocol"] == protocol)]
                if rows.empty:
                    continue
                predicted = rows["predicted"].clip(low, high) / unit
                panel.plot(
                    rows["actual"] / unit, predicted, marker, ms=2.6, mew=0.7,
                    color=style.PROTOCOL_COLOURS[protocol], alpha=0.7, ls="",
                )  # fmt: skip
                found = comparison[
                    (comparison["model"] == model)
                    & (comparison["protocol"] == protocol)
                    & (comparison["basis"] == FIXED)
                ]["r2"]
                score = style.minus(score_number(found.iloc[0], 2, "undefined"))
                words.append(f"{PROTOCOLS[protocol]}: $R^2$ {score}")
            panel.plot(ends, ends, color=style.BLACK, ls="--", lw=0.7, zorder=0)
            panel.set_xlim(-0.04 * most / unit, ends[1])
            panel.set_ylim(*ends)
            panel.set_title(
                "\n".join([f"{style.letter(index)} {MODELS[model]}", *words]),
                loc="left",
                fontsize=6.5,
            )
            panel.tick_params(labelsize=6.5)
        label = style.scaled_unit(power, "mm/s")
        for panel in axes[-min(4, len(axes)) :]:
            panel.set_xlabel(f"Simulated ({label})", fontsize=7.0)
        for panel in axes[::4]:
            panel.set_ylabel(f"Predicted ({label})", fontsize=7.0)
        figure.legend(
            handles=[
                Line2D([], [], marker="x", ls="", ms=3.5, label="protocol: as published",
                       color=style.PROTOCOL_COLOURS[AS_PUBLISHED]),
                Line2D([], [], marker="o", ls="", ms=3.0, label="protocol: leakage-free",
                       color=style.PROTOCOL_COLOURS[LEAKAGE_FREE]),
            ],
            loc="outside upper center",
            ncols=2,
        )  # fmt: skip
        style.caption(
            figure,
            "wear depth rate of the test rows of one split; as published: 30 % of the rows for "
            "networks, 20 % for other models; leakage-free: the first split, the same rows for all "
            "models" + ("; predictions beyond a panel are drawn at its edge" if beyond else ""),
        )
    return figure
