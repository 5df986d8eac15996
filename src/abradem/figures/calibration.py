"""Calibration: simulated against given wear rates, what is left, and profiles of the unknowns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from abradem.figures import style
from abradem.learning.number_text import score_number
from abradem.quantities import quantity
from abradem.words.labels import LABELS, STATISTIC_WORDS

LEFT_AGAINST = (
    "particle_radius", "particle_density", "particle_velocity_y", "static_friction",
    "restitution", "plate_angle", "factory_angle",
)  # fmt: skip
"""Quantities against which the ratio of given and simulated rates is drawn."""

FEW_DECADES = 30.0
"""Ratio of the ends of an axis below which more than its decades are labelled."""

SPEED = "particle_velocity_y"
"""The exponent of the squared impact speed is written at this quantity."""

SHOWN_SPAN = 0.35
"""Range of R2 below the best one that a profile shows."""


def draw_agreement(predicted: pd.DataFrame, summary: Mapping, slopes: pd.DataFrame) -> Figure:
    """Simulated against given wear rates, and their ratio against each quantity.

    Parameters
    ----------
    predicted, slopes : pandas.DataFrame
        From `abradem.calibration.outcome.outcome`.
    summary : mapping
        From the same.
    """
    with style.style():
        figure = style.new_figure(style.PAGE, 4.5)
        grid = figure.add_gridspec(2, 5, width_ratios=(1.1, 1.1, 1.0, 1.0, 1.0))
        _parity(figure.add_subplot(grid[:, :2]), predicted, summary)
        ratio = (predicted["given"] / predicted["simulated"]).to_numpy()
        span = float(np.exp(np.abs(np.log(ratio)).max())) * 1.1
        places = [grid[row, column] for row in range(2) for column in range(2, 5)]
        spare = figure.add_subplot(places[-1])
        panels = [figure.add_subplot(place) for place in places[:-1]]
        # The two angles share the last panel.
        for index, (panel, name) in enumerate(zip(panels, LEFT_AGAINST, strict=False)):
            _left(panel, predicted, ratio, name, span)
            words = f"{style.letter(index + 1)}{_left_words(slopes, name)}"
            panel.set_title(words, loc="left", fontsize=6.5)
            if index in (0, 3):
                panel.set_ylabel("given / simulated")
            else:
                panel.set_yticklabels([])
        for name, colour in (("plate_angle", style.BLUE), ("factory_angle", style.ORANGE)):
            spare.scatter(predicted[name], ratio, s=7, color=colour, lw=0, alpha=0.7,
                          label=style.short_label(name))  # fmt: skip
        _ratio_axis(spare, span)
        spare.set_yticklabels([])
        spare.set_xlabel("Angle (°)", fontsize=7.0)
        spare.legend(loc="lower left", fontsize=6.5, handletextpad=0.1, borderpad=0.0)
        spare.set_title(style.letter(len(panels) + 1), loc="left", fontsize=6.5)
        reading = _reading(summary)
        style.caption(
            figure,
            f"Simulated: {reading}, mean of {summary['replicates']} replicates of trial "
            f"{summary['trial']}; no constant is fitted. Bars: standard errors of the replicates. "
            "Open: rows held out of the search. (b) to (g): the ratio of given to simulated rates; "
            "b: exponent that is left in it, in (d) that of the squared impact speed, with its "
            "standard error",
        )
    return figure


def draw_profiles(profiles: pd.DataFrame, summary: Mapping) -> Figure:
    """The best score for each value of each unknown, whatever the others are.

    Parameters
    ----------
    profiles : pandas.DataFrame
        From `abradem.calibration.outcome.profiles`.
    summary : mapping
        From `abradem.calibration.outcome.outcome`.
    """
    names = list(dict.fromkeys(profiles["unknown"]))
    with style.style():
        figure, panels = style.panels(len(names), 3, 1.55)
        top = float(np.nanmax(profiles["score"]))
        low = max(top - SHOWN_SPAN, float(np.nanmin(profiles["score"])) - 0.02)
        for index, (panel, name) in enumerate(zip(panels, names, strict=True)):
            rows = profiles[profiles["unknown"] == name].reset_index(drop=True)
            _profile(panel, rows, low, top)
            panel.set_title(f"{style.letter(index)} {_short(name)}", loc="left", fontsize=7.0)
            if index % 3 == 0:
                panel.set_ylabel("$R^2$ of ln y")
        style.caption(
            figure,
            f"{_score_words(summary['by'])} of the best set-up with each value, on the rows of the "
            "first rung; bars: two standard errors of the replicates. Blue: not told apart from "
            "the best value; grey: worse by more than two standard errors; missing: below the "
            "range shown, or without a score",
        )
    return figure


def _parity(panel: Axes, predicted: pd.DataFrame, summary: Mapping) -> None:
    given, simulated = predicted["given"].to_numpy(), predicted["simulated"].to_numpy()
    error = np.nan_to_num(predicted["simulated_stderr"].to_numpy())
    for part, face in (("used", style.BLUE), ("held out", "white")):
        rows = (predicted["part"] == part).to_numpy()
        panel.errorbar(
            given[rows], simulated[rows], yerr=error[rows], fmt="o", ms=3.5, mfc=face,
            mec=style.BLUE, ecolor=style.BLUE, elinewidth=0.5, mew=0.7,
            label=f"{part} ({rows.sum()} rows)",
        )  # fmt: skip
    ends = (min(given.min(), simulated.min()) / 1.3, max(given.max(), simulated.max()) * 1.3)
    panel.plot(ends, ends, color=style.BLACK, ls="--", lw=0.8)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(ends)
    panel.set_ylim(ends)
    panel.set_aspect("equal", anchor="N")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(
            LogLocator(subs=(1.0, 2.0, 5.0) if ends[1] < FEW_DECADES * ends[0] else (1.0,))
        )
        axis.set_minor_formatter(NullFormatter())
        if ends[1] < FEW_DECADES * ends[0]:
            axis.set_major_formatter(lambda value, _: f"{value:g}")
    panel.set_xlabel("Wear depth rate in the table (mm/s)")
    panel.set_ylabel("Simulated wear depth rate (mm/s)")
    lines = [
        f"{name}: $R^2$ of ln y {_score(of['log_r2'])}, of y {_score(of['r2'])}\n"
        f"  rank correlation {_score(of['spearman'])}, constant {_score(of['constant'])}"
        for name, of in sorted(summary["scores"].items(), reverse=True)
        if name != "both"
    ]
    panel.text(
        0.0, -0.24, "\n".join(lines), transform=panel.transAxes, ha="left", va="top", fontsize=6.5
    )
    panel.legend(loc="upper left")
    panel.set_title(f"{style.letter(0)} agreement", loc="left")


def _left(
    panel: Axes,
    predicted: pd.DataFrame,
    ratio: np.ndarray,
    name: str,
    span: float,
) -> None:
    factor = 1e3 if name == "particle_radius" else 1.0
    for part, face in (("used", style.BLUE), ("held out", "white")):
        rows = (predicted["part"] == part).to_numpy()
        panel.scatter(
            factor * predicted.loc[rows, name], ratio[rows], s=8, facecolor=face,
            edgecolor=style.BLUE, lw=0.5,
        )  # fmt: skip
    _ratio_axis(panel, span)
    tex, long_name = LABELS[name]
    words = long_name.removeprefix("coefficient of ").removeprefix("particle ")
    words = words.removesuffix(" (vertical)")
    unit = "mm" if factor != 1.0 else quantity(name).unit
    panel.set_xlabel(style.with_unit(f"{words[0].upper()}{words[1:]} ${tex}$", unit), fontsize=7.0)


def _left_words(slopes: pd.DataFrame, name: str) -> str:
    """The exponent of a quantity that is left in the ratio, "" if it is not determined."""
    slope = slopes[slopes["quantity"] == ("impact_speed" if name == SPEED else name)]
    if slope.empty:
        return ""
    value, error = slope[["ratio_exponent", "ratio_stderr"]].iloc[0]
    return style.minus(f" b = {value:+.2f} ± {error:.2f}")


def _ratio_axis(panel: Axes, span: float) -> None:
    panel.axhline(1.0, color=style.BLACK, ls="--", lw=0.7, zorder=0)
    panel.set_yscale("log")
    panel.set_ylim(1.0 / span, span)
    fine = (0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5)
    coarse = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
    ticks = [tick for tick in (fine if span < 2.0 else coarse) if 1.0 / span <= tick <= span]
    panel.set_yticks(ticks, [f"{t:g}" for t in ticks])
    panel.minorticks_off()


def _profile(panel: Axes, rows: pd.DataFrame, low: float, top: float) -> None:
    places = np.arange(len(rows))
    colours = [style.GREY if apart else style.BLUE for apart in rows["told_apart"]]
    for place, row, colour in zip(places, rows.itertuples(), colours, strict=True):
        if not np.isfinite(row.score) or row.score < low:
            continue
        error = 0.0 if not np.isfinite(row.noise) else 2.0 * row.noise
        panel.errorbar(place, row.score, yerr=error, fmt="o", ms=3.5, color=colour, elinewidth=0.8)
    panel.set_xlim(-0.5, len(rows) - 0.5)
    panel.set_ylim(low, min(1.0, top + 0.1 * (top - low)) + 0.01)
    turned = max(len(value) for value in rows["value"]) * len(rows) > 28
    panel.set_xticks(places, rows["value"], fontsize=6.5, rotation=30 if turned else 0,
                     ha="right" if turned else "center")  # fmt: skip


def _short(name: str) -> str:
    """The last parts of the keys of an unknown."""
    words = [key.strip().rpartition(".")[2] for key in name.split(",")]
    for suffix, unit in (("_kg_s", "kg/s"), ("_per_s", "1/s"), ("_mm", "mm"), ("_s", "s")):
        if all(word.endswith(suffix) for word in words):
            words = [word.removesuffix(suffix) for word in words]
            return f"{', '.join(words).replace('_', ' ')} ({unit})"
    return ", ".join(words).replace("_", " ")


def _reading(summary: Mapping) -> str:
    words = f"{summary['measure']} measure, {STATISTIC_WORDS[summary['statistic']]}"
    size = summary["element_size"]
    return words if size is None else f"{words} of {1e3 * size:g} mm"


def _score(value: float | None) -> str:
    return style.minus(score_number(value, 3))


def _score_words(by: str) -> str:
    return {
        "log_r2": "R² of ln y without a constant",
        "log_r2_constant": "R² of ln y with a constant",
    }[by]
