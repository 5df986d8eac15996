"""Wear depth against time, and how good the wear rates are."""

from __future__ import annotations

import textwrap

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter

from abradem.figures import style


def series_figure(curves: pd.DataFrame, fits: pd.DataFrame, reading: str = "total") -> Figure:
    """Mean wear depth of the plate against time, one panel per case.

    Parameters
    ----------
    curves, fits : pandas.DataFrame
        From `abradem.wear_rate.depth_series`.
    reading : str
        Named below the panels.

    Returns
    -------
    matplotlib.figure.Figure
        Grey: the transient that was dropped; dashed: the fitted slope over the steady part,
        whose value, standard error and R2 (a description) stand in the panel.
    """
    with style.style():
        if fits.empty:
            figure, axes = style.panels(1, 1, 1.0, style.COLUMN)
            style.say_nothing_to_show(axes[0], "none of the cases was simulated")
            return figure
        figure, axes = style.panels(len(fits), 3, 1.85)
        for index, (panel, row) in enumerate(zip(axes, fits.to_dict("records"), strict=True)):
            curve = curves[curves["case_id"] == row["case_id"]]
            style.title_case(panel, index, row)
            _series_panel(panel, curve, row)
        figure.legend(
            handles=[
                Line2D([], [], color=style.BLUE, lw=1.4, label="simulated"),
                Line2D([], [], color=style.BLACK, ls="--", lw=0.9, label="fitted slope"),
                Patch(color=style.LIGHT_GREY, label="transient, dropped"),
            ],
            loc="outside upper center",
            ncols=3,
        )
        style.caption(
            figure,
            f"reading: {reading}; slope ± standard error from equal batches of the steady part; "
            r"$R^2$ of the cumulative curve only describes",
        )
    return figure


def _series_panel(panel, curve: pd.DataFrame, row: dict) -> None:
    if curve.empty:
        style.say_nothing_to_show(panel, row["status"])
        return
    power = style.decade(curve["wear_depth"].max())
    unit = 10.0**power
    panel.plot(curve["time"], curve["wear_depth"] / unit, color=style.BLUE, lw=1.4)
    panel.set_xlim(0.0, curve["time"].max())
    # Room above the curve for the words.
    panel.set_ylim(0.0, 1.45 * max(curve["wear_depth"].max() / unit, 1e-300))
    panel.set_xlabel("Time (s)")
    panel.set_ylabel(f"Mean depth ({style.scaled_unit(power, 'mm')})")
    if np.isfinite(row["rate"]):
        panel.axvspan(0.0, row["time_from"], color=style.LIGHT_GREY, lw=0, zorder=0)
        panel.plot(
            [row["time_from"], row["time_to"]],
            [row["depth_from"] / unit, row["depth_to"] / unit],
            color=style.BLACK,
            ls="--",
            lw=0.9,
        )
        words = style.with_error(row["rate"], row["rate_stderr"], "mm/s")
        words += f"\n$R^2$ = {row['r2']:.4f}"
    else:
        words = "no steady state" if row["status"] == "ok" else textwrap.fill(row["status"], 30)
    panel.text(
        0.04 + row["time_from"] / curve["time"].max() if np.isfinite(row["rate"]) else 0.04, 0.97,
        words, transform=panel.transAxes, va="top",
        fontsize=6.5,
    )  # fmt: skip


def quality_figure(quality: pd.DataFrame, target_stderr: float, good_r2: float = 0.95) -> Figure:
    """How well the wear rates are known: standard errors, and R2 of the cumulative series.

    Parameters
    ----------
    quality : pandas.DataFrame
        From `abradem.wear_rate.quality_table`.
    target_stderr : float
        Relative standard error that the simulations aim at.
    good_r2 : float
        R2 from which a series counts as good.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style.style():
        figure, (left, right) = style.panels(2, 2, 2.0)
        errors = 100.0 * quality["relative_stderr"].to_numpy(dtype=float)
        errors = errors[np.isfinite(errors)]
        scores = quality["wear_r2"].to_numpy(dtype=float)
        scores = scores[np.isfinite(scores)]

        aim = 100.0 * target_stderr
        left.hist(errors, bins=_bins(errors.max(initial=0.0), aim), color=style.BLUE)
        left.set_xlim(0.0, None)
        within = int((errors <= aim).sum())
        left.axvline(aim, color=style.RED, ls="--", lw=0.9)
        _in_corner(left, f"{within} of {len(quality)} cases\nat most {aim:g} %")
        left.set_title(f"{style.letter(0)} standard error of the plate mean", loc="left")
        left.set_xlabel("Relative standard error (%)")
        left.set_ylabel("Cases")

        # R2 crowds below 1: its distance from 1 shows on a logarithmic axis.
        distance = np.clip(1.0 - scores, 1e-8, None)
        limit = max(1.0 - good_r2, 1e-8)
        ends = [min(distance.min(initial=limit), limit), max(distance.max(initial=limit), limit)]
        low, high = (np.log10(end / limit) * _BINS_PER_DECADE for end in ends)
        steps = np.arange(np.floor(low), np.ceil(high) + 1.5)
        right.hist(distance, bins=limit * 10.0 ** (steps / _BINS_PER_DECADE), color=style.BLUE)
        right.set_xscale("log")
        bounds = (np.floor(np.log10(min(ends))), np.ceil(np.log10(max(ends))))
        right.set_xlim(*(10.0**bound for bound in bounds))
        right.xaxis.set_minor_formatter(NullFormatter())
        right.axvline(limit, color=style.RED, ls="--", lw=0.9)
        good = int((scores >= good_r2).sum())
        right.text(
            0.03, 0.97, f"{good} of {len(quality)} cases\nwith $R^2 \\geq$ {good_r2:g}",
            transform=right.transAxes, va="top", fontsize=7.0,
        )  # fmt: skip
        right.set_title(f"{style.letter(1)} straightness of the cumulative wear", loc="left")
        right.set_xlabel(r"$1 - R^2$ of the cumulative series")
        right.set_ylabel("Cases")
        for panel in (left, right):
            panel.yaxis.get_major_locator().set_params(integer=True)
            panel.set_ylim(0.0, 1.3 * panel.get_ylim()[1])
        style.caption(
            figure,
            f"{len(quality)} cases; dashed: standard error aimed at, stated $R^2$; "
            r"$R^2$ of a cumulative series is near 1 whatever happens: it only describes",
        )
    return figure


_BINS_PER_DECADE = 6


def _bins(largest: float, aim: float) -> np.ndarray:
    """About 30 equal bins from 0 to the largest value, one edge at the value aimed at."""
    reach = max(largest / aim, 2.0)
    width = aim / max(1, int(30 / reach)) * max(1, int(np.ceil(reach / 30)))
    return width * np.arange(int(np.ceil(reach * aim / width)) + 1)


def _in_corner(panel, words: str) -> None:
    panel.text(0.97, 0.97, words, transform=panel.transAxes, ha="right", va="top", fontsize=7.0)
