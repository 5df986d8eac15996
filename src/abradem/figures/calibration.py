"""Calibration: simulated against given wear rates, what is left, and profiles of the unknowns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.learning.number_text import score_number
from abradem.words.labels import STATISTIC_WORDS

LEFT_AGAINST = (
    "particle_radius", "particle_density", "particle_velocity_y", "static_friction",
    "restitution", "plate_angle", "factory_angle",
)  # fmt: skip
"""Quantities against which the ratio of given and simulated rates is drawn."""

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
        figure = style.new_figure(style.PAGE, 4.2)
        grid = figure.add_gridspec(2, 5, width_ratios=(1.0, 1.0, 1.0, 1.0, 1.0))
        _parity(figure.add_subplot(grid[:, :2]), predicted, summary)
        ratio = (predicted["given"] / predicted["simulated"]).to_numpy()
        span = float(np.exp(np.abs(np.log(ratio)).max())) * 1.1
        places = [grid[row, column] for row in range(2) for column in range(2, 5)]
        spare = figure.add_subplot(places[-1])
        panels = [figure.add_subplot(place) for place in places[:-1]]
        # The two angles share the last panel.
        for index, (panel, name) in enumerate(zip(panels, LEFT_AGAINST, strict=False)):
            _left(panel, predicted, ratio, name, slopes, span)
            panel.set_title(style.letter(index + 1), loc="left")
            if index in (0, 3):
                panel.set_ylabel("given / simulated")
        for name, colour in (("plate_angle", style.BLUE), ("factory_angle", style.ORANGE)):
            spare.scatter(predicted[name], ratio, s=7, color=colour, lw=0, alpha=0.7,
                          label=style.short_label(name))  # fmt: skip
        _ratio_axis(spare, span)
        spare.set_xlabel("Angle (°)")
        spare.legend(loc="lower left", fontsize=5.5, handletextpad=0.1, borderpad=0.0)
        spare.set_title(style.letter(len(panels) + 1), loc="left")
        reading = _reading(summary)
        style.caption(
            figure,
            f"Simulated: {reading}, mean of {summary['replicates']} replicates of trial "
            f"{summary['trial']}; no constant is fitted. Bars: standard errors of the replicates. "
            "Open: rows held out of the search. (b) to (g): the ratio of given to simulated rates; "
            "b: exponent that is left in it, with its standard error",
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
        for index, (panel, name) in enumerate(zip(panels, names, strict=True)):
            rows = profiles[profiles["unknown"] == name].reset_index(drop=True)
            _profile(panel, rows, top)
            panel.set_title(f"{style.letter(index)} {_short(name)}", loc="left", fontsize=7.0)
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
    panel.set_aspect("equal")
    panel.set_xlabel("Wear depth rate in the table (mm/s)")
    panel.set_ylabel("Simulated wear depth rate (mm/s)")
    lines = [
        f"{name}: $R^2$ of ln y {_score(of['log_r2'])}, of y {_score(of['r2'])}\n"
        f"  rank correlation {_score(of['spearman'])}, constant {_score(of['constant'])}"
        for name, of in summary["scores"].items()
        if name != "both"
    ]
    panel.text(
        0.97, 0.03, "\n".join(lines), transform=panel.transAxes, ha="right", va="bottom",
        fontsize=6.0,
    )  # fmt: skip
    panel.legend(loc="upper left")
    panel.set_title(f"{style.letter(0)} agreement", loc="left")


def _left(
    panel: Axes,
    predicted: pd.DataFrame,
    ratio: np.ndarray,
    name: str,
    slopes: pd.DataFrame,
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
    label = "Particle radius $R$ (mm)" if factor != 1.0 else style.axis_label(name)
    panel.set_xlabel(label.replace("Coefficient of ", "").replace(" (vertical)", ""), fontsize=7.0)
    term = "impact_speed" if name == "particle_velocity_y" else name
    slope = slopes[slopes["quantity"] == term]
    if len(slope):
        value, error = slope[["ratio_exponent", "ratio_stderr"]].iloc[0]
        panel.text(
            0.97, 0.95, style.minus(f"b = {value:+.2f} ± {error:.2f}"), transform=panel.transAxes,
            ha="right", va="top", fontsize=6.0,
        )  # fmt: skip


def _ratio_axis(panel: Axes, span: float) -> None:
    panel.axhline(1.0, color=style.BLACK, ls="--", lw=0.7, zorder=0)
    panel.set_yscale("log")
    panel.set_ylim(1.0 / span, span)
    ticks = [t for t in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0) if 1.0 / span <= t <= span]
    panel.set_yticks(ticks, [f"{t:g}" for t in ticks])
    panel.minorticks_off()


def _profile(panel: Axes, rows: pd.DataFrame, top: float) -> None:
    places = np.arange(len(rows))
    colours = [style.GREY if apart else style.BLUE for apart in rows["told_apart"]]
    for place, row, colour in zip(places, rows.itertuples(), colours, strict=True):
        if not np.isfinite(row.score) or row.score < top - SHOWN_SPAN:
            continue
        error = 0.0 if not np.isfinite(row.noise) else 2.0 * row.noise
        panel.errorbar(place, row.score, yerr=error, fmt="o", ms=3.5, color=colour, elinewidth=0.8)
    panel.set_xlim(-0.5, len(rows) - 0.5)
    panel.set_ylim(top - SHOWN_SPAN, min(1.0, top + 0.1 * SHOWN_SPAN) + 0.01)
    turned = max(len(value) for value in rows["value"]) * len(rows) > 28
    panel.set_xticks(places, rows["value"], fontsize=6.0, rotation=30 if turned else 0,
                     ha="right" if turned else "center")  # fmt: skip


def _short(name: str) -> str:
    """The last parts of the keys of an unknown."""
    words = [key.strip().rpartition(".")[2] for key in name.split(",")]
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
