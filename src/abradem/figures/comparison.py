"""Comparison of all models under both protocols."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from abradem.figures import style
from abradem.figures.score_axis import LEAST, MOST, label_scores, unexplained
from abradem.learning.number_text import score_number
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.words.labels import MODELS, PROTOCOLS

SPLITS, FIXED = "repeated splits", "fixed split"


def comparison_figure(comparison: pd.DataFrame, beside_paper: pd.DataFrame, table: str) -> Figure:
    """R2 of every model: printed in the paper, reproduced as published, and leakage-free.

    Parameters
    ----------
    comparison, beside_paper : pandas.DataFrame
        From `abradem.learning.comparison`.
    table : str
        Name of the data set.

    Returns
    -------
    matplotlib.figure.Figure
        The scale is logarithmic in 1 - R2 and ends at R2 = -1, where arrowheads stand for what is
        below. At the right: leakage-free R2.
    """
    models = list(beside_paper["model"])
    with style.style():
        figure, (panel,) = style.panels(1, 1, 0.9 + 0.27 * len(models))
        places = np.arange(len(models))
        shown, below = [1.0], False
        for shift, protocol, marker in ((-0.16, AS_PUBLISHED, "o"), (0.16, LEAKAGE_FREE, "s")):
            rows = _of_protocol(comparison, protocol)
            for place, model in zip(places, models, strict=True):
                if model in rows.index:
                    row, colour = rows.loc[model], style.PROTOCOL_COLOURS[protocol]
                    below |= _interval(panel, row, place + shift, colour, marker)
                    shown += [float(unexplained(row[name])) for name in ("r2", "r2_upper")]
        printed = beside_paper["printed_r2"].to_numpy(dtype=float)
        panel.plot(
            unexplained(printed), places - 0.16, "|", ms=8.0, mew=1.6, color=style.BLACK, zorder=3
        )
        ends = [MOST, max(0.7 * float(np.nanmin([*shown, *unexplained(printed)])), LEAST)]
        panel.set_xscale("log")
        panel.set_xlim(1.06 * ends[0], ends[1])
        label_scores(panel.xaxis, ends[1], ends[0])
        panel.axvline(1.0, color=style.BLACK, lw=0.5)
        panel.set_yticks(places, [MODELS.get(model, model) for model in models])
        panel.tick_params(axis="y", length=0)
        panel.set_ylim(len(models) - 0.45, -0.55)
        for place, score in zip(places, beside_paper["leakage_free_r2"], strict=True):
            panel.text(
                1.01, place + 0.16, style.minus(score_number(score, missing="")), ha="left",
                transform=panel.get_yaxis_transform(), va="center", fontsize=7.0,
                color=style.PROTOCOL_COLOURS[LEAKAGE_FREE],
            )  # fmt: skip
        panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
        panel.set_axisbelow(True)
        panel.set_xlabel("$R^2$ on held-out rows (log scale of $1 - R^2$)")
        figure.legend(handles=_handles(), loc="outside upper center", ncols=3)
        style.caption(
            figure,
            f"data set: {table}. As published: one split, choices made on all rows or on the test "
            f"rows ({optimistic(beside_paper)}the wrong target is the last component, not the "
            "wear); interval: bootstrap of the test rows. Leakage-free, with numbers: median and "
            "central share of the repeated splits, which are the same for all models"
            + ("; arrowheads: below the axis" if below else ""),
        )
    return figure


def _of_protocol(comparison: pd.DataFrame, protocol: str) -> pd.DataFrame:
    """Scores by model: on the repeated splits where there are any, otherwise on the first one."""
    rows = comparison[comparison["protocol"] == protocol]
    rows = rows[rows["basis"].isin((SPLITS, FIXED))].sort_values(
        "basis", key=lambda basis: basis != SPLITS, kind="stable"
    )
    return rows.drop_duplicates("model").set_index("model")


def _interval(panel, row: pd.Series, y: float, colour: str, marker: str) -> bool:
    """Draw a score and its interval; return whether something is below the axis."""
    ends = row[["r2_lower", "r2_upper"]].to_numpy(dtype=float)
    if np.isfinite(ends).all() and ends[1] > 1.0 - MOST:
        panel.plot(unexplained(ends), [y, y], color=colour, lw=1.2)
    if row["r2"] >= 1.0 - MOST:
        panel.plot(unexplained(row["r2"]), y, marker, ms=4.0, color=colour)
    below = bool((np.array([row["r2"], *ends], dtype=float) < 1.0 - MOST).any())
    if below:
        panel.plot(MOST, y, "<", ms=4.0, color=colour, clip_on=False)
    return below


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
               label="leakage-free"),
    ]  # fmt: skip


def predictions_figure(predictions: pd.DataFrame, comparison: pd.DataFrame) -> Figure:
    """Predicted against simulated wear on the test rows of a fixed split, for each model.

    Parameters
    ----------
    predictions, comparison : pandas.DataFrame
        From `abradem.learning.comparison`.

    Returns
    -------
    matplotlib.figure.Figure
        Both axes have the same scale, logarithmic if all simulated wear is positive. Triangles at
        the edges stand for predictions beyond them, such as negative ones.
    """
    fixed = predictions[(predictions["repeat"] == 0) & (predictions["split"] == "test")]
    models = [model for model in MODELS if model in set(fixed["model"])]
    with style.style():
        figure, axes = style.panels(len(models), 4, 2.15)
        ends, logarithmic = _parity_ends(fixed["actual"].to_numpy(dtype=float))
        power = 0 if logarithmic else style.decade(ends[1])
        beyond = False
        for index, (panel, model) in enumerate(zip(axes, models, strict=True)):
            words = []
            for protocol, marker in ((AS_PUBLISHED, "x"), (LEAKAGE_FREE, "o")):
                rows = fixed[(fixed["model"] == model) & (fixed["protocol"] == protocol)]
                if rows.empty:
                    continue
                colour = style.PROTOCOL_COLOURS[protocol]
                beyond |= _parity(panel, rows, ends, 10.0**power, marker, colour)
                found = comparison[
                    (comparison["model"] == model)
                    & (comparison["protocol"] == protocol)
                    & (comparison["basis"] == FIXED)
                ]["r2"]
                score = style.minus(score_number(found.iloc[0], 3, "undefined"))
                words.append(f"{PROTOCOLS[protocol]}: $R^2$ {score}")
            if logarithmic:
                panel.set_xscale("log")
                panel.set_yscale("log")
            shown = np.array(ends) / 10.0**power
            panel.plot(shown, shown, color=style.BLACK, ls="--", lw=0.7, zorder=0)
            panel.set_xlim(shown)
            panel.set_ylim(shown)
            panel.set_box_aspect(1.0)
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
            "models; dashed: predicted equals simulated"
            + ("; triangles: predictions beyond the axis" if beyond else "")
            + (", also those that are not positive" if beyond and logarithmic else ""),
        )
    return figure


def _parity_ends(actual: np.ndarray) -> tuple[tuple[float, float], bool]:
    """Common ends of both axes, and whether these are logarithmic."""
    low, high = float(actual.min()), max(float(actual.max()), 1e-300)
    if low > 0.0:
        return (low / 2.0, 2.0 * high), True
    return (-0.4 * high, 1.4 * high), False


def _parity(panel, rows: pd.DataFrame, ends, unit: float, marker: str, colour: str) -> bool:
    """Draw the rows of a model; return whether predictions are beyond the ends."""
    actual, predicted = (rows[name].to_numpy(dtype=float) for name in ("actual", "predicted"))
    inside = (predicted >= ends[0]) & (predicted <= ends[1])
    panel.plot(
        actual[inside] / unit, predicted[inside] / unit, marker, ms=2.6, mew=0.7, color=colour,
        alpha=0.7,
    )  # fmt: skip
    for end, shape in ((ends[0], "v"), (ends[1], "^")):
        out = (predicted < end) if shape == "v" else (predicted > end)
        # A line without points and without clipping would have no place in the layout.
        if out.any():
            panel.plot(
                actual[out] / unit, np.full(out.sum(), end / unit), shape, ms=3.0, mew=0.0,
                color=colour, alpha=0.7, clip_on=False,
            )  # fmt: skip
    return not inside.all()
