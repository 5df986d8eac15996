"""The models of the wear number on one page: how good, how sure, from how many cases, and why."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from abradem.figures import style
from abradem.figures.words import HONEST, MODELS, minus
from abradem.parameters import quantity

COLOURS = {
    "power_law": style.GREEN,
    "networks": style.PURPLE,
    "boosting": style.ORANGE,
    "gaussian_process": style.BLUE,
    "surrogate": style.SKY,
}
"""The models on dimensionless groups."""

PHYSICAL = {name: MODELS[name] for name in COLOURS}
SHOWN_OTHERS = ("linear", "ridge", "tree", "forest", "ga_ann")
LEAST = 1e-4
"""Unexplained share at which axes end."""

MOST_INDICES = 8


def models_figure(
    comparison: pd.DataFrame,
    calibration: pd.DataFrame,
    curve: pd.DataFrame,
    indices: pd.DataFrame,
    exponents: pd.DataFrame,
    noise: Mapping | None,
    table: str,
) -> Figure:
    """Comparison, calibration, learning curve, sensitivity and power law.

    Parameters
    ----------
    comparison : pandas.DataFrame
        From `abradem.learning.comparison.compare`, all models.
    calibration : pandas.DataFrame
        From `abradem.learning.intervals.calibrate`.
    curve : pandas.DataFrame
        From `abradem.learning.reach.learning_curve`.
    indices : pandas.DataFrame
        From `abradem.learning.sensitivity.sobol`.
    exponents : pandas.DataFrame
        From `abradem.learning.power_law.PowerLaw.exponents`.
    noise : mapping or None
        From `abradem.learning.noise_floor.noise_floor`; None without simulations.
    table : str
        Name of the table learned from.
    """
    with style.style():
        figure = style.new_figure(style.PAGE, 7.6)
        grid = figure.add_gridspec(3, 2, height_ratios=(1.0, 1.0, 0.92))
        places = [grid[0, 0], grid[0, 1], grid[1, 0], grid[1, 1], grid[2, :]]
        panels = [figure.add_subplot(place) for place in places]
        _comparison(panels[0], comparison, noise)
        _calibration(panels[1], calibration)
        _curve(panels[2], curve, noise)
        _indices(panels[3], indices)
        _exponents(panels[4], exponents)
        rows = int(calibration["tested"].iloc[0])
        words = (
            f"table: {table}. (a) test rows of repeated splits, honest protocol: median, central "
            "95 % of the splits (surrogate: the first of them). "
        )
        if noise is not None:
            words += (
                f"Noise floor: {noise['cases']} cases, {noise['replicates']} simulations with "
                "other seeds; band of 95 %. "
            )
        words += (
            f"(b) every one of {rows} rows held out once; grey: binomial band of 95 %. (c) median "
            "over splits and central 95 %. (d) Gaussian process over the ranges of the table, "
            "bootstrap intervals of 95 %. (e) dot: exponent of a quantity, from the groups' "
            "exponents; bar: 95 %, HC3"
        )
        style.caption(figure, words)
    return figure


def _unexplained_axis(axis, low: float, high: float) -> None:
    """Ticks of a logarithmic axis of 1 - R2, labelled with R2."""
    ticks = [0.5, 0.1, 0.01, 0.001, 0.0001]
    kept = [tick for tick in ticks if low <= tick <= high]
    axis.set_ticks(kept, [f"{1.0 - tick:.4g}" for tick in kept])
    axis.set_ticks([], minor=True)


def _comparison(panel: Axes, comparison: pd.DataFrame, noise: Mapping | None) -> None:
    honest = comparison[comparison["protocol"] == HONEST].drop_duplicates("model")
    honest = honest.set_index("model")
    names = [*(name for name in SHOWN_OTHERS if name in honest.index),
             *(name for name in PHYSICAL if name in honest.index)]  # fmt: skip
    shown = []
    for place, name in enumerate(names):
        row = honest.loc[name]
        ends = 1.0 - np.array([row["r2_upper"], row["r2_lower"]], dtype=float)
        middle = 1.0 - float(row["r2"])
        colour = COLOURS.get(name, style.GREY)
        panel.plot(np.clip(ends, LEAST, 1.0), [place, place], color=colour, lw=1.4)
        panel.plot(np.clip(middle, LEAST, 1.0), place, "o", ms=4.0, color=colour)
        panel.annotate(
            f"{1.0 - middle:.4f}" if middle < 0.1 else f"{1.0 - middle:.2f}",
            (np.clip(ends.min(), LEAST, 1.0), place), xytext=(4.0, 0.0),
            textcoords="offset points",
            fontsize=6.5, ha="left", va="center", color=colour,
        )  # fmt: skip
        shown += [middle, *ends]
    if noise is not None and np.isfinite(noise["r2_floor"] or np.nan):
        low, high = (1.0 - value for value in noise["r2_floor_band"])
        panel.axvspan(max(high, LEAST / 2), max(low, LEAST / 2), color=style.LIGHT_GREY, zorder=0)
        panel.axvline(1.0 - noise["r2_floor"], color=style.BLACK, lw=0.8, ls="--", zorder=0)
        panel.text(
            1.0 - noise["r2_floor"], -0.55, "noise floor ", fontsize=6.5, ha="right",
            va="center", rotation=0,
        )  # fmt: skip
        shown.append(1.0 - noise["r2_floor"])
    finite = [value for value in shown if np.isfinite(value)]
    low = max(0.6 * min(finite, default=LEAST), LEAST / 2)
    panel.set_xscale("log")
    panel.set_xlim(1.05, low)
    _unexplained_axis(panel.xaxis, low, 1.0)
    panel.set_yticks(
        range(len(names)), [PHYSICAL.get(name, MODELS.get(name, name)) for name in names]
    )
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(names) - 0.1, -0.8)
    panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
    panel.set_axisbelow(True)
    panel.set_xlabel("$R^2$ on held-out rows (scale of $1 - R^2$)")
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
    words = [f"{100.0 * level:g} %: +{100.0 * widths[level]:.1f} %" for level in (0.5, 0.8, 0.95)]
    panel.text(
        102.0, 3.0, "\n".join(["median upper end", "over prediction", *words]), fontsize=6.5,
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
        colour = COLOURS[name]
        middle = np.clip(1.0 - rows["r2"], LEAST, 1.0)
        panel.plot(rows["trained"], middle, marker="o", ms=3.5, color=colour, label=PHYSICAL[name])
        panel.fill_between(
            rows["trained"], np.clip(1.0 - rows["r2_upper"], LEAST, 1.0),
            np.clip(1.0 - rows["r2_lower"], LEAST, 1.0), color=colour, alpha=0.15, lw=0.0,
        )  # fmt: skip
        lows += list(np.clip(1.0 - rows["r2_upper"], LEAST, 1.0))
    if noise is not None and np.isfinite(noise["r2_floor"] or np.nan):
        panel.axhline(1.0 - noise["r2_floor"], color=style.BLACK, lw=0.8, ls="--")
        panel.text(
            curve["trained"].min(), 1.0 - noise["r2_floor"], "noise floor", fontsize=6.5,
            va="bottom",
        )  # fmt: skip
        lows.append(1.0 - noise["r2_floor"])
    panel.set_xscale("log")
    panel.set_yscale("log")
    low = max(0.6 * min((v for v in lows if np.isfinite(v)), default=LEAST), LEAST / 2)
    high = float(np.nanmax(np.clip(1.0 - curve["r2_lower"], LEAST, 1.0)))
    panel.set_ylim(min(1.3 * high, 1.05), low)
    _unexplained_axis(panel.yaxis, low, min(1.3 * high, 1.0))
    ticks = sorted(set(curve["trained"]))
    panel.set_xticks(ticks, [str(tick) for tick in ticks])
    panel.set_xticks([], minor=True)
    panel.grid(axis="y", color=style.LIGHT_GREY, lw=0.5)
    panel.set_xlabel("Training rows")
    panel.set_ylabel("$R^2$ on held-out rows")
    panel.legend(loc="upper right", bbox_to_anchor=(1.0, 0.93))
    panel.set_title(f"{style.letter(2)} learning curve", loc="left")


def _indices(panel: Axes, indices: pd.DataFrame) -> None:
    rows = indices[indices["explained"] == "wear"].sort_values("total", ascending=False)
    rows = rows.iloc[:MOST_INDICES]
    places = np.arange(len(rows))
    for shift, column, colour, words in (
        (-0.2, "total", style.BLUE, "total"), (0.2, "first", style.SKY, "alone"),
    ):  # fmt: skip
        values = rows[column].clip(lower=0.0).to_numpy()
        panel.barh(places + shift, values, 0.36, color=colour, label=words)
        ends = rows[[f"{column}_lower", f"{column}_upper"]].clip(lower=0.0).to_numpy()
        panel.hlines(places + shift, ends[:, 0], ends[:, 1], color=style.BLACK, lw=0.8)
    names = [_short(name) for name in rows["feature"]]
    panel.set_yticks(places, names)
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(rows) - 0.5, -0.5)
    panel.set_xlim(0.0, None)
    panel.set_xlabel("Sobol index of the wear rate")
    panel.legend(loc="lower right")
    panel.set_title(f"{style.letter(3)} sensitivity", loc="left")


def _short(name: str) -> str:
    """Words and symbol of a quantity, short enough for a tick."""
    row = quantity(name)
    words = row.long_name.removeprefix("coefficient of ").removesuffix(" (vertical)")
    return f"{words}  ${row.tex}$"


def _exponents(panel: Axes, exponents: pd.DataFrame) -> None:
    """Exponents of quantities, and the law in dimensionless groups."""
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
        reach = 1.96 * row.standard_error
        if np.isfinite(reach):
            panel.plot([place] * 2, [row.exponent - reach, row.exponent + reach], color=colour)
        panel.plot(place, row.exponent, "o", ms=3.5, color=colour)
        text = minus(f"{row.exponent:.2f}")
        panel.annotate(
            text, (place, row.exponent), xytext=(5.0, 4.0), textcoords="offset points",
            fontsize=6.5, va="center", color=colour,
        )  # fmt: skip
    symbols = [
        {"log_static_friction": r"\mu_s", "log_rolling_friction": r"\mu_r",
         "log_rebound": "1+e", "jet_width": r"e^{\cos\theta}"}.get(row.term, row.tex)
        for row in shown.itertuples(index=False)
    ]  # fmt: skip
    panel.set_xticks(places, [f"${symbol}$" for symbol in symbols])
    panel.set_xlim(-0.6, len(shown) - 0.2)
    panel.set_ylabel("Exponent")
    panel.margins(y=0.12)
    panel.legend(
        handles=[
            Line2D([], [], marker="o", ms=3.5, color=style.GREEN, label="quantity, all else fixed"),
            Line2D([], [], marker="o", ms=3.5, color=style.GREY, label="group"),
        ],
        loc="upper right",
    )
    panel.set_title(f"{style.letter(4)} power law\n{_law(known)}", loc="left", linespacing=1.6)


def _law(known: pd.DataFrame) -> str:
    """The law in mathematical text, two lines."""
    value = known["exponent"]
    powers = [
        (r"Fr", "log_froude"), (r"(R/H)", "log_size"), (r"L", "log_loading"),
        (r"Ca", "log_cauchy"), (r"(G^*/E^*)", "log_stiffness_ratio"),
        (r"\mu_s", "log_static_friction"), (r"\mu_r", "log_rolling_friction"),
        (r"(1+e)", "log_rebound"),
    ]  # fmt: skip
    first, second = (
        r"\;".join(f"{base}^{{\\,{value[term]:.2f}}}" for base, term in part)
        for part in (powers[:5], powers[5:])
    )
    terms = ((r"\cos\theta", "jet_width"), (r"\varphi", "plate_angle"),
             (r"\varphi^2", "plate_angle_squared"))  # fmt: skip
    total = "".join(f"{value[term]:+.2f}{symbol}" for symbol, term in terms)
    scale = r"\frac{W \dot m v^2}{2A}"
    constant = np.exp(value["constant"])
    return (
        rf"$\dot h = {scale} \cdot {constant:.2g}\;{first}$"
        "\n"
        rf"$\quad\;\; {second}\;\exp({total})$"
    )


def sensitivity_figure(
    indices: pd.DataFrame, falls: pd.DataFrame, dependence: pd.DataFrame, table: str
) -> Figure:
    """Sobol indices of wear and log wear, permutation importance, partial dependence.

    Parameters
    ----------
    indices, falls, dependence : pandas.DataFrame
        From `abradem.learning.sensitivity`.
    table : str
        Name of the table learned from.
    """
    wear = indices[indices["explained"] == "wear"].sort_values("total", ascending=False)
    order = list(wear["feature"])
    with style.style():
        figure = style.new_figure(style.PAGE, 5.9)
        grid = figure.add_gridspec(3, 4, height_ratios=(1.9, 1.0, 1.0))
        left, right = figure.add_subplot(grid[0, :2]), figure.add_subplot(grid[0, 2:])
        places = np.arange(len(order))
        for shift, explained, colour in (
            (-0.2, "wear", style.BLUE), (0.2, "log wear", style.ORANGE),
        ):  # fmt: skip
            rows = indices[indices["explained"] == explained].set_index("feature").loc[order]
            left.barh(places + shift, rows["total"].clip(lower=0.0), 0.36, color=colour)
            left.hlines(
                places + shift, rows["total_lower"].clip(lower=0.0), rows["total_upper"],
                color=style.BLACK, lw=0.7,
            )  # fmt: skip
            left.plot(
                rows["first"].clip(lower=0.0), places + shift, "|", ms=5.5, mew=1.2,
                color=style.BLACK,
            )  # fmt: skip
        names = [_short(name) for name in order]
        left.set_yticks(places, names)
        left.set_xlabel("Sobol index")
        left.legend(
            handles=[
                Patch(color=style.BLUE, label="total, wear"),
                Patch(color=style.ORANGE, label="total, ln wear"),
                Line2D([], [], marker="|", ls="", mew=1.2, color=style.BLACK, label="alone"),
            ],
            loc="lower right",
        )
        left.set_title(f"{style.letter(0)} Sobol indices", loc="left")
        lost = falls.set_index("feature").loc[order]
        right.barh(places, lost["fall"], 0.6, color=style.GREEN)
        right.hlines(places, lost["fall_lower"], lost["fall_upper"], color=style.BLACK, lw=0.8)
        right.set_yticks(places, [f"${quantity(name).tex}$" for name in order])
        right.set_xlabel("Fall of $R^2$ when shuffled")
        right.set_title(f"{style.letter(1)} permutation importance", loc="left")
        for panel in (left, right):
            panel.tick_params(axis="y", length=0)
            panel.set_ylim(len(order) - 0.5, -0.5)
            panel.set_xlim(0.0, None)
        most = dependence["predicted"].max()
        power = style.decade(most)
        for place, name in enumerate(order[:8]):
            panel = figure.add_subplot(grid[1 + place // 4, place % 4])
            rows = dependence[dependence["feature"] == name]
            row = quantity(name)
            panel.plot(
                rows["setting"] / row.config_factor, rows["predicted"] / 10.0**power,
                color=style.BLUE,
            )  # fmt: skip
            panel.set_ylim(0.0, 1.08 * most / 10.0**power)
            unit = "" if row.config_unit == "1" else row.config_unit
            panel.set_xlabel(style.with_unit(f"${row.tex}$", unit or "1"), fontsize=7.0)
            panel.set_title(style.letter(2 + place), loc="left")
            if place % 4 == 0:
                panel.set_ylabel(f"Wear ({style.scaled_unit(power, 'mm/s')})")
        style.caption(
            figure,
            f"table: {table}; Gaussian process. (a) over the ranges of the table, all 14 sampled "
            "quantities independent; bootstrap intervals of 95 %. (b) mean, least and largest of "
            "the splits. From (c) on: geometric mean of the predicted wear depth rate over the "
            "cases with one quantity set",
        )
    return figure


def reach_figure(extrapolation: pd.DataFrame, targets: pd.DataFrame, table: str) -> Figure:
    """Beyond the ranges learned from, and every target.

    Parameters
    ----------
    extrapolation, targets : pandas.DataFrame
        From `abradem.learning.reach.extrapolate` and `abradem.learning.physical.all_targets`.
    table : str
        Name of the table learned from.
    """
    with style.style():
        figure = style.new_figure(style.PAGE, 2.9)
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.05))
        _beyond(left, extrapolation)
        _targets(right, targets)
        style.caption(
            figure,
            f"table: {table}. (a) filled: rows beyond the bound, models trained on the others; "
            "open: the same rows by cross-validation over all rows; number: share of the rows "
            "beyond inside the process's 95 % intervals. (b) Gaussian process, median over splits "
            "of $R^2$ on the raw target (in brackets: of its logarithm)",
        )
    return figure


def _beyond(panel: Axes, extrapolation: pd.DataFrame) -> None:
    panel.set_title(f"{style.letter(0)} extrapolation", loc="left")
    if extrapolation.empty:
        style.say_nothing_to_show(panel, "too few rows to hold a range out")
        return
    tests = list(dict.fromkeys(extrapolation["test"]))
    models = list(dict.fromkeys(extrapolation["model"]))
    labels = []
    for place, test in enumerate(tests):
        rows = extrapolation[extrapolation["test"] == test].set_index("model")
        for step, model in enumerate(models):
            y = place + 0.22 * (step - 0.5 * (len(models) - 1))
            beyond, within = (max(rows.loc[model, key], -0.5) for key in ("r2", "within_r2"))
            colour = COLOURS[model]
            panel.plot([beyond, within], [y, y], color=colour, lw=0.8)
            panel.plot(within, y, "o", ms=4.0, mfc="white", mec=colour)
            panel.plot(beyond, y, "o", ms=4.0, color=colour)
            if np.isfinite(rows.loc[model, "coverage"]):
                panel.annotate(
                    f"{100.0 * rows.loc[model, 'coverage']:.0f} %",
                    (min(beyond, within), y), xytext=(-6.0, 0.0), textcoords="offset points",
                    ha="right", va="center", fontsize=6.5, color=colour,
                )  # fmt: skip
        first = rows.iloc[0]
        rows_of_all = f"{first['tested']} of {first['trained'] + first['tested']}"
        labels.append(f"{first['words']}\n({rows_of_all})")
    panel.set_yticks(range(len(tests)), labels)
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(tests) - 0.4, -0.6)
    low = min(extrapolation["r2"].min(), extrapolation["within_r2"].min())
    span = max(1.0 - max(low, -0.5), 0.02)
    panel.set_xlim(1.0 - 1.25 * span, 1.0 + 0.02 * span)
    panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
    panel.set_axisbelow(True)
    panel.set_xlabel("$R^2$")
    panel.legend(
        handles=[
            Line2D([], [], marker="o", ms=4.0, color=COLOURS[m], label=PHYSICAL[m]) for m in models
        ],
        loc="upper center", bbox_to_anchor=(0.4, -0.22), ncols=3, columnspacing=1.0,
    )  # fmt: skip


def _targets(panel: Axes, targets: pd.DataFrame) -> None:
    panel.set_title(f"{style.letter(1)} every target", loc="left")
    rows = targets[targets["model"] == "gaussian_process"].set_index("target")
    readings = [r for r in ("total", "sliding", "friction") if f"wear_{r}_mean" in rows.index]
    statistics = [
        s for s in ("mean", "footprint", "p99", "max")
        if any(f"wear_{r}_{s}" in rows.index for r in readings)
    ]  # fmt: skip
    values = np.full((len(readings), len(statistics)), np.nan)
    for i, reading in enumerate(readings):
        for j, statistic in enumerate(statistics):
            name = f"wear_{reading}_{statistic}"
            if name not in rows.index:
                continue
            values[i, j] = rows.loc[name, "r2"]
            dark = values[i, j] > 0.6
            panel.text(
                j, i, f"{rows.loc[name, 'r2']:.3f}\n({rows.loc[name, 'r2_log']:.2f})",
                ha="center", va="center", fontsize=7.0, color="white" if dark else "black",
            )  # fmt: skip
    panel.imshow(values, cmap="viridis_r", vmin=0.0, vmax=1.0, aspect="auto")
    words = {"mean": "plate", "footprint": "footprint", "p99": "99th perc.", "max": "worst facet"}
    panel.set_xticks(range(len(statistics)), [words[s] for s in statistics])
    panel.set_yticks(range(len(readings)), readings)
    panel.tick_params(length=0)
    for side in panel.spines.values():
        side.set_visible(False)
