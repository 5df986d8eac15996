"""Quality of the wear rates: standard errors, and R2 of the cumulative wear."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from abradem.dataset.relative_errors import relative_stderr
from abradem.figures import style
from abradem.words.wear import WearTarget

STOPPED_BY = "wear_total_mean"
"""The wear rate at whose standard error the stop rule aims, see `abradem.dem.simulation`."""


def draw(dataset: pd.DataFrame, target: Mapping, target_stderr: float, good_r2: float) -> Figure:
    """Draw `quality_figure` for a data set."""
    explained = WearTarget(**target)
    return quality_figure(quality_table(dataset, explained.name), explained, target_stderr, good_r2)


def quality_table(rates: pd.DataFrame, target: str) -> pd.DataFrame:
    """Quality of the wear rate of each case.

    Returns
    -------
    pandas.DataFrame
        case_id, relative_stderr (of the target, dimensionless; nan where it is not known), wear_r2
        (dimensionless), quality.
    """
    table = rates[["case_id", "wear_r2", "quality"]].copy()
    table.insert(1, "relative_stderr", relative_stderr(rates, target))
    return table


def quality_figure(
    quality: pd.DataFrame, target: WearTarget, target_stderr: float, good_r2: float = 0.95
) -> Figure:
    """Histograms of the standard errors and of R2 of the cumulative series.

    Parameters
    ----------
    quality : pandas.DataFrame
        From `abradem.figures.quality.quality_table`.
    target : WearTarget
        Target of the study, whose standard errors are shown.
    target_stderr : float
        Relative standard error at which the stop rule of the simulations aims. It is shown if the
        rule is about the target, which is `STOPPED_BY`; the median is shown otherwise.
    good_r2 : float
        Smallest R2 of a series that counts as good.

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

        if errors.size:
            line = _errors_panel(left, errors, target, 100.0 * target_stderr, len(quality))
        else:
            line = ""
            style.say_nothing_to_show(left, "the standard error of the target is not known")
        left.set_title(f"{style.letter(0)} {target.place}", loc="left")

        # R2 is close to 1, so 1 - R2 is shown on a logarithmic axis.
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
        right.set_title(f"{style.letter(1)} linearity of the cumulative wear", loc="left")
        right.set_xlabel(r"$1 - R^2$ of the cumulative series")
        right.set_ylabel("Cases")
        for panel in (left, right) if errors.size else (right,):
            panel.yaxis.get_major_locator().set_params(integer=True)
            panel.set_ylim(0.0, 1.3 * panel.get_ylim()[1])
        style.caption(
            figure,
            f"{len(quality)} cases; wear measure on the left: {target.measure}, on the right: "
            f"total; dashed: {line}stated $R^2$; $R^2$ of a cumulative series is always near 1 and "
            "only descriptive",
        )
    return figure


def _errors_panel(panel, errors: np.ndarray, target: WearTarget, aim: float, cases: int) -> str:
    """Draw the histogram of the errors, %; return the words for its line."""
    stops = target.name == STOPPED_BY
    mark = aim if stops else float(np.median(errors))
    panel.hist(errors, bins=_bins(errors.max(), mark or 1.0), color=style.BLUE)
    panel.set_xlim(0.0, None)
    panel.axvline(mark, color=style.RED, ls="--", lw=0.9)
    panel.set_xlabel("Relative standard error (%)")
    panel.set_ylabel("Cases")
    if stops:
        within = int((errors <= aim).sum())
        _in_corner(panel, f"{within} of {cases} cases\nat most {aim:g} %")
        return "target standard error, "
    _in_corner(panel, f"{errors.size} of {cases} cases,\nmedian {mark:.2g} %")
    return "median, "


_BINS_PER_DECADE = 6


def _bins(largest: float, aim: float) -> np.ndarray:
    """About 30 equal bins from 0 to the largest value, with one edge at the target."""
    reach = max(largest / aim, 2.0)
    width = aim / max(1, int(30 / reach)) * max(1, int(np.ceil(reach / 30)))
    return width * np.arange(int(np.ceil(reach * aim / width)) + 1)


def _in_corner(panel, words: str) -> None:
    panel.text(0.97, 0.97, words, transform=panel.transAxes, ha="right", va="top", fontsize=7.0)
