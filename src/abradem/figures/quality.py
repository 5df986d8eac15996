"""Quality of the wear rates: standard errors, and R2 of the cumulative wear."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from abradem.figures import style


def draw(dataset: pd.DataFrame, target_stderr: float, good_r2: float) -> Figure:
    """Draw `quality_figure` for a data set."""
    return quality_figure(quality_table(dataset), target_stderr, good_r2)


def quality_table(rates: pd.DataFrame) -> pd.DataFrame:
    """Quality of the wear rate of each case.

    Returns
    -------
    pandas.DataFrame
        case_id, relative_stderr (of the plate mean, dimensionless), wear_r2 (dimensionless),
        quality.
    """
    table = rates[["case_id", "wear_r2", "quality"]].copy()
    table.insert(1, "relative_stderr", rates["wear_total_mean_stderr"] / rates["wear_total_mean"])
    return table


def quality_figure(quality: pd.DataFrame, target_stderr: float, good_r2: float = 0.95) -> Figure:
    """Histograms of the standard errors and of R2 of the cumulative series.

    Parameters
    ----------
    quality : pandas.DataFrame
        From `abradem.figures.quality.quality_table`.
    target_stderr : float
        Target of the relative standard error of the simulations.
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

        aim = 100.0 * target_stderr
        left.hist(errors, bins=_bins(errors.max(initial=0.0), aim), color=style.BLUE)
        left.set_xlim(0.0, None)
        within = int((errors <= aim).sum())
        left.axvline(aim, color=style.RED, ls="--", lw=0.9)
        _in_corner(left, f"{within} of {len(quality)} cases\nat most {aim:g} %")
        left.set_title(f"{style.letter(0)} standard error of the plate mean", loc="left")
        left.set_xlabel("Relative standard error (%)")
        left.set_ylabel("Cases")

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
        for panel in (left, right):
            panel.yaxis.get_major_locator().set_params(integer=True)
            panel.set_ylim(0.0, 1.3 * panel.get_ylim()[1])
        style.caption(
            figure,
            f"{len(quality)} cases; dashed: target standard error, stated $R^2$; "
            r"$R^2$ of a cumulative series is always near 1 and only descriptive",
        )
    return figure


_BINS_PER_DECADE = 6


def _bins(largest: float, aim: float) -> np.ndarray:
    """About 30 equal bins from 0 to the largest value, with one edge at the target."""
    reach = max(largest / aim, 2.0)
    width = aim / max(1, int(30 / reach)) * max(1, int(np.ceil(reach / 30)))
    return width * np.arange(int(np.ceil(reach * aim / width)) + 1)


def _in_corner(panel, words: str) -> None:
    panel.text(0.97, 0.97, words, transform=panel.transAxes, ha="right", va="top", fontsize=7.0)
