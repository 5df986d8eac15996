"""The physics-informed models: scores, calibration, learning curve, power law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from abradem.dataset.variation import NOT_IDENTIFIED, VARIED
from abradem.figures import style
from abradem.figures.score_axis import LEAST, label_scores, unexplained
from abradem.learning.number_text import UNDETERMINED, number_or_words, percentage, score_number
from abradem.learning.physical.power_law import factor_of
from abradem.learning.protocols import LEAKAGE_FREE
from abradem.words.labels import GROUP_LABELS, LABELS, MODELS, Label

SHOWN_OTHERS = ("linear", "ridge", "tree", "forest", "ga_ann")
SHOWN_LEVELS = (0.5, 0.8, 0.95)
"""Levels of the intervals whose width is written."""


def models_figure(
    comparison: pd.DataFrame,
    calibration: pd.DataFrame,
    curve: pd.DataFrame,
    noise: Mapping | None,
    table: str,
) -> Figure:
    """Comparison, calibration of the intervals, and learning curve.

    Parameters
    ----------
    comparison : pandas.DataFrame
        From `abradem.learning.comparison.compare`, all models.
    calibration : pandas.DataFrame
        From `abradem.learning.physical.intervals.calibrate`.
    curve : pandas.DataFrame
        From `abradem.learning.physical.reach.learning_curve`.
    noise : mapping or None
        From `abradem.learning.physical.noise_floor.noise_floor`; None without simulations.
    table : str
        Name of the data set.
    """
    with style.style():
        figure = style.new_figure(style.PAGE, 5.0)
        grid = figure.add_gridspec(2, 2)
        top = figure.add_subplot(grid[0, :])
        left, right = (figure.add_subplot(grid[1, column]) for column in (0, 1))
        _comparison(top, comparison, noise)
        _calibration(left, calibration)
        _curve(right, curve, noise)
        rows = int(calibration["tested"].iloc[0])
        words = (
            f"data set: {table}. (a) test rows of repeated splits, leakage-free protocol: median "
            "and central 95 % of the splits, which are the same for all models. "
        )
        if noise is not None:
            words += (
                f"Noise floor: {noise['cases']} cases, {noise['replicates']} simulations with "
                "other seeds; grey: 95 % band. "
            )
        words += (
            f"(b) each of {rows} rows held out once; grey: 95 % binomial band. (c) median over the "
            "splits and central 95 %"
        )
        style.caption(figure, words)
    return figure


def _comparison(panel: Axes, comparison: pd.DataFrame, noise: Mapping | None) -> None:
    leakage_free = comparison[comparison["protocol"] == LEAKAGE_FREE].drop_duplicates("model")
    leakage_free = leakage_free.set_index("model")
    names = [*(name for name in SHOWN_OTHERS if name in leakage_free.index),
             *(name for name in style.MODEL_COLOURS if name in leakage_free.index)]  # fmt: skip
    shown = [1.0]
    for place, name in enumerate(names):
        row = leakage_free.loc[name]
        colour = style.MODEL_COLOURS.get(name, style.GREY)
        ends = unexplained(row[["r2_lower", "r2_upper"]], most=1.0)
        middle = float(unexplained(row["r2"], most=1.0))
        panel.plot(ends, [place, place], color=colour, lw=1.4)
        panel.plot(middle, place, "o", ms=4.0, color=colour)
        panel.text(
            1.01, place, style.minus(score_number(row["r2"])), fontsize=7.0, va="center",
            transform=panel.get_yaxis_transform(), color=colour,
        )  # fmt: skip
        shown += [middle, ends[1]]
    if noise is not None and np.isfinite(noise["r2_floor"] or np.nan):
        panel.axvspan(
            *unexplained(noise["r2_floor_band"], most=1.0), color=style.LIGHT_GREY, zorder=0
        )
        floor = float(unexplained(noise["r2_floor"], most=1.0))
        panel.axvline(floor, color=style.BLACK, lw=0.8, ls="--", zorder=0)
        panel.text(floor, -0.95, "noise floor", fontsize=6.5, ha="center", va="center")
        shown.append(floor)
    low = max(0.6 * min(value for value in shown if np.isfinite(value)), LEAST)
    panel.set_xscale("log")
    panel.set_xlim(1.05, low)
    label_scores(panel.xaxis, low, 1.0)
    panel.set_yticks(range(len(names)), [MODELS.get(name, name) for name in names])
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(names) - 0.3, -0.7)
    panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
    panel.set_axisbelow(True)
    panel.set_xlabel("$R^2$ on held-out rows (log scale of $1 - R^2$)")
    panel.set_title(f"{style.letter(0)} comparison", loc="left")


def _calibration(panel: Axes, calibration: pd.DataFrame) -> None:
    for method, colour, marker in (
        ("gaussian process", style.ORANGE, "^"), ("conformal", style.BLUE, "o"),
    ):  # fmt: skip
        rows = calibration[calibration["method"] == method]
        panel.plot(
            100.0 * rows["level"], 100.0 * rows["coverage"], marker=marker, ms=3.5, lw=0.9,
            color=colour, label="normal quantiles" if method != "conformal" else "conformal",
        )  # fmt: skip
    rows = calibration[calibration["method"] == "conformal"]
    panel.fill_between(
        100.0 * rows["level"], 100.0 * rows["band_lower"], 100.0 * rows["band_upper"],
        color=style.LIGHT_GREY, lw=0.0, zorder=0,
    )  # fmt: skip
    panel.plot([0.0, 100.0], [0.0, 100.0], color=style.BLACK, ls="--", lw=0.7, zorder=1)
    widths = rows.set_index("level")["width"]
    words = [
        f"{100.0 * level:g} %: "
        + (percentage(widths[level], "+.1f") if level in widths else "too few rows")
        for level in SHOWN_LEVELS
    ]
    panel.text(
        102.0, 3.0, "\n".join(["median upper end", "above prediction", *words]), fontsize=6.5,
        ha="right", va="bottom", color=style.BLUE,
    )  # fmt: skip
    panel.set_xlim(0.0, 104.0)
    panel.set_ylim(0.0, 104.0)
    panel.set_xlabel("Nominal level of the interval (%)")
    panel.set_ylabel("Held-out rows inside (%)")
    panel.legend(loc="upper left")
    panel.set_title(f"{style.letter(1)} calibration", loc="left")


def _curve(panel: Axes, curve: pd.DataFrame, noise: Mapping | None) -> None:
    lows = []
    for name, rows in curve.groupby("model", sort=False):
        colour = style.MODEL_COLOURS[name]
        middle = unexplained(rows["r2"], most=1.0)
        panel.plot(rows["trained"], middle, marker="o", ms=3.5, color=colour, label=MODELS[name])
        panel.fill_between(
            rows["trained"], unexplained(rows["r2_upper"], most=1.0),
            unexplained(rows["r2_lower"], most=1.0), color=colour, alpha=0.15, lw=0.0,
        )  # fmt: skip
        lows += list(unexplained(rows["r2_upper"], most=1.0))
    if noise is not None and np.isfinite(noise["r2_floor"] or np.nan):
        floor = float(unexplained(noise["r2_floor"], most=1.0))
        panel.axhline(floor, color=style.BLACK, lw=0.8, ls="--")
        panel.text(curve["trained"].min(), 1.03 * floor, "noise floor", fontsize=6.5, va="top")
        lows.append(floor)
    panel.set_xscale("log")
    panel.set_yscale("log")
    low = max(0.6 * min((v for v in lows if np.isfinite(v)), default=LEAST), LEAST)
    highs = unexplained(curve["r2_lower"].dropna(), most=1.0)
    high = float(highs.max()) if len(highs) else 1.0
    if curve["r2"].isna().all():
        panel.text(0.5, 0.5, f"$R^2$ {UNDETERMINED}", transform=panel.transAxes, ha="center",
                   va="center", fontsize=7.0, color=style.GREY)  # fmt: skip
    panel.set_ylim(min(1.3 * high, 1.05), low)
    label_scores(panel.yaxis, low, min(1.3 * high, 1.0))
    ticks = sorted(set(curve["trained"]))
    panel.set_xticks(ticks, [str(tick) for tick in ticks])
    panel.set_xticks([], minor=True)
    panel.grid(axis="y", color=style.LIGHT_GREY, lw=0.5)
    panel.set_xlabel("Training rows")
    panel.set_ylabel("$R^2$ on held-out rows")
    panel.legend(loc="lower right")
    panel.set_title(f"{style.letter(2)} learning curve", loc="left")


def power_law_figure(exponents: pd.DataFrame, table: str) -> Figure:
    """Exponents of quantities and groups, and the equation of the power law.

    Parameters
    ----------
    exponents : pandas.DataFrame
        From `abradem.learning.physical.power_law.PowerLaw.exponents`.
    table : str
        Name of the data set.
    """
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.3)
        _exponents(panel, exponents)
        words = (
            f"data set: {table}; power law of all rows. Exponents of quantities, computed from "
            "those of the groups; bars: 95 % intervals, HC3"
        )
        if (exponents["variation"] == NOT_IDENTIFIED).any():
            words += "; not identified: the rows do not tell it from others, nor C"
        style.caption(figure, words)
    return figure


def _exponents(panel: Axes, exponents: pd.DataFrame) -> None:
    known = exponents.set_index("term")
    quantities = exponents[exponents["kind"] == "quantity"]
    groups = exponents[
        (exponents["kind"] == "group")
        & exponents["term"].isin(
            ["log_static_friction", "log_rolling_friction", "log_rebound", "jet_width"]
        )
    ]
    shown = pd.concat([quantities, groups])
    places = np.arange(len(shown))
    panel.axhline(0.0, color=style.BLACK, lw=0.5)
    for place, row in zip(places, shown.itertuples(index=False), strict=True):
        colour = style.GREEN if row.kind == "quantity" else style.GREY
        if row.variation != VARIED:
            continue
        reach = 1.96 * row.standard_error
        if np.isfinite(reach):
            panel.plot([place] * 2, [row.exponent - reach, row.exponent + reach], color=colour)
        panel.plot(place, row.exponent, "o", ms=3.5, color=colour)
        text = style.minus(number_or_words(row.exponent, ".2f"))
        panel.annotate(
            text, (place, row.exponent), xytext=(5.0, 4.0), textcoords="offset points",
            fontsize=6.5, va="center", color=colour,
        )  # fmt: skip
    symbols = [
        {"log_static_friction": r"\mu_s", "log_rolling_friction": r"\mu_r",
         "log_rebound": "1+e", "jet_width": r"e^{\cos\theta}"}.get(row.term, _label_of(row).tex)
        for row in shown.itertuples(index=False)
    ]  # fmt: skip
    panel.set_xticks(places, [f"${symbol}$" for symbol in symbols])
    panel.set_xlim(-0.6, len(shown) - 0.2)
    panel.set_ylabel("Exponent")
    panel.margins(y=0.12)
    style.name_unvaried(panel, shown["variation"], upright=True)
    panel.legend(
        handles=[
            Line2D([], [], marker="o", ms=3.5, color=style.GREEN, label="quantity, all else fixed"),
            Line2D([], [], marker="o", ms=3.5, color=style.GREY, label="group"),
        ],
        loc="upper right",
    )
    panel.set_title(_law(known), loc="left", linespacing=1.6)


def _label_of(row) -> Label:
    """Label of a term of the power law."""
    return (LABELS if row.kind == "quantity" else GROUP_LABELS)[row.term]


LOGARITHM = r"\ln "
"""What the symbol of a group begins with that is a logarithm."""


def _law(known: pd.DataFrame) -> str:
    """The equation of the power law in mathematical text, in two lines.

    Groups that were held fixed, or that the rows do not tell apart, are left out.
    """
    value = known.loc[known["variation"] == VARIED, "exponent"]
    powers = [
        (r"Fr", "log_froude"), (r"(R/H)", "log_size"), (r"L", "log_loading"),
        (r"Ca", "log_cauchy"), (r"(G^*/E^*)", "log_stiffness_ratio"),
        (r"\mu_s", "log_static_friction"), (r"\mu_r", "log_rolling_friction"),
        (r"(1+e)", "log_rebound"),
    ]  # fmt: skip
    terms = [(r"\cos\theta", "jet_width"), (r"\varphi", "plate_angle"),
             (r"\varphi^2", "plate_angle_squared")]  # fmt: skip
    of_plate = {"constant", *(term for _, term in (*powers, *terms))}
    for term in (one for one in value.index if one in GROUP_LABELS and one not in of_plate):
        tex = GROUP_LABELS[term].tex
        if term.startswith("log_"):
            powers.append((f"({tex.removeprefix(LOGARITHM)})", term))
        else:
            terms.append((rf"\,{tex}", term))
    first, second = (
        r"\;".join(
            f"{base}^{{\\,{number_or_words(value[term], '.2f')}}}"
            for base, term in part
            if term in value
        )
        for part in (powers[:5], powers[5:])
    )
    total = "".join(f"{value[term]:+.2f}{symbol}" for symbol, term in terms if term in value)
    scale = r"\frac{W \dot m v^2}{2A}"
    constant = (
        style.number(factor_of(value["constant"]), 2).replace("$", "")
        if "constant" in value
        else "C"
    )
    lines = [rf"$\dot h = {scale} \cdot {constant}\;{first}$"]
    if second or total:
        factor = rf"\;\exp({total})" if total else ""
        lines.append(rf"$\quad\;\; {second}{factor}$")
    return "\n".join(lines)
