"""Wear depth against time, with the fitted slopes."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.figures.cases_shown import runs_shown, stacked
from abradem.geometry.build import worn_area
from abradem.quantities import SAMPLED_NAMES
from abradem.store.tables import concatenate
from abradem.units import MM_PER_M
from abradem.wear.rates import release_interval, steady_rate
from abradem.words.wear import WearTarget


def draw(
    series: Iterable[pd.DataFrame],
    runs: Iterable[pd.DataFrame],
    cases: Iterable[pd.DataFrame],
    setup: Mapping,
    shown: Sequence[int],
    min_batches: int,
    target: Mapping,
) -> Figure:
    """Draw `series_figure` from the tables of the batches, see `depth_series`."""
    records, ended, drawn = (concatenate(parts) for parts in (series, runs, cases))
    values, explained = Setup.from_dict(setup), WearTarget(**target)
    return series_figure(
        *depth_series(records, ended, drawn, values, shown, explained.measure, min_batches),
        explained,
    )


def series_figure(curves: pd.DataFrame, fits: pd.DataFrame, target: WearTarget) -> Figure:
    """Mean wear depth of the plate against time, one panel per case.

    Parameters
    ----------
    curves, fits : pandas.DataFrame
        From `abradem.figures.series.depth_series`.
    target : WearTarget
        Target of the study; the caption names its measure, and says so if it is not the mean over
        the plate, which is all that the series hold.

    Returns
    -------
    matplotlib.figure.Figure
        Grey: excluded transient; dashed: fitted slope over the steady part. Each panel states the
        slope, its standard error and R2, which is only descriptive.
    """
    with style.style():
        if fits.empty:
            figure, axes = style.panels(1, 1, 1.0, style.COLUMN)
            style.say_nothing_to_show(axes[0], "none of the cases was simulated")
            return figure
        figure, axes = style.panels(len(fits), 3, 1.9)
        for index, (panel, row) in enumerate(zip(axes, fits.to_dict("records"), strict=True)):
            curve = curves[curves["case_id"] == row["case_id"]]
            style.title_case(panel, index, row)
            _series_panel(panel, curve, row)
        figure.legend(
            handles=[
                Line2D([], [], color=style.BLUE, lw=1.4, label="simulated"),
                Line2D([], [], color=style.BLACK, ls="--", lw=0.9, label="fitted slope"),
                Patch(color=style.LIGHT_GREY, label="transient, excluded"),
            ],
            loc="outside upper center",
            ncols=3,
        )
        style.caption(
            figure,
            f"mean wear depth of the plate, wear measure: {target.measure}; slope ± standard error "
            r"from batch means of the steady part; $R^2$ of the cumulative curve is only "
            "descriptive"
            + (
                f"; the models predict another statistic, {target.place}"
                if target.has_elements
                else ""
            ),
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
    # Space above the curve for the text.
    panel.set_ylim(0.0, 1.45 * max(curve["wear_depth"].max() / unit, 1e-300))
    panel.set_xlabel("Time (s)")
    panel.set_ylabel(f"Depth ({style.scaled_unit(power, 'mm')})")
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
    panel.text(0.99, 0.98, words, transform=panel.transAxes, ha="right", va="top", fontsize=6.5)


def depth_series(
    series: pd.DataFrame,
    runs: pd.DataFrame,
    cases: pd.DataFrame,
    setup: Setup,
    shown: Sequence[int],
    measure: str,
    min_batches: int = 20,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Mean wear depth of the plate against time for some cases, and the fitted slopes.

    Parameters
    ----------
    series, runs, cases, setup
        As for `abradem.wear.rates.wear_rates`; rows of other cases are ignored.
    shown : sequence of int
        Cases, in the desired order.
    measure : str
        One of `abradem.quantities.WEAR_MEASURES`.
    min_batches : int
        Smallest number of batches for a standard error.

    Returns
    -------
    curves : pandas.DataFrame
        case_id, time (s), wear_depth (mm).
    fits : pandas.DataFrame
        One row per case of ``shown`` among the runs: case_id, status, the sampled quantities,
        the line from (``time_from``, ``depth_from``) to (``time_to``, ``depth_to``) in s and
        mm, ``rate`` and ``rate_stderr`` in mm/s, ``r2``; nan without a steady state.
    """
    constants = cases.set_index("case_id")
    curves, fits = [], []
    for run in runs_shown(runs, shown):
        key = run["case_id"]
        rows = series[series["case_id"] == key]
        time = rows["time"].to_numpy(dtype=float)
        per_joule = MM_PER_M * float(constants.at[key, "archard_constant"]) / worn_area(setup)
        depth = per_joule * rows[f"worn_{measure}"].to_numpy(dtype=float)
        curves.append(pd.DataFrame({"case_id": key, "time": time, "wear_depth": depth}))
        start = run["steady_from"]
        interval = release_interval(run, rows["delivered_mass"].max())
        fit = steady_rate(time, depth, start, min_batches, interval)
        known = np.isfinite(fit.rate)
        from_depth = float(np.interp(start, time, depth)) if known else np.nan
        end = time[-1] if known else np.nan
        fits.append(
            {
                "case_id": key,
                "status": run["status"],
                **{name: float(constants.at[key, name]) for name in SAMPLED_NAMES},
                "time_from": start,
                "time_to": end,
                "depth_from": from_depth,
                "depth_to": from_depth + fit.rate * (end - start),
                "rate": fit.rate,
                "rate_stderr": fit.stderr,
                "r2": fit.r2,
            }
        )
    return stacked(curves, ("case_id", "time", "wear_depth")), pd.DataFrame(fits)
