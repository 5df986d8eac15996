"""Overview of the verification study: the share of its tolerance that every check uses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.verification.checks import HOLDS
from abradem.verification.results_page import PARTS

_LEAST = 1e-4
"""Lower end of the axis; checks that use less of their tolerance are drawn there."""


def draw(checks: pd.DataFrame) -> Figure:
    """Draw `verdicts_figure` from the checks of `make verify`."""
    return verdicts_figure(margins(checks), PARTS, HOLDS)


def verdicts_figure(margins: pd.DataFrame, parts: Mapping[int, str], holds: str) -> Figure:
    """One marker for each check, by part of the study; checks right of the line fail.

    Parameters
    ----------
    margins : pandas.DataFrame
        From `abradem.figures.verdicts.margins`.
    parts : mapping of int to str
        Names of the parts.
    holds : str
        Verdict of a check that holds.
    """
    with style.style():
        numbers = sorted(margins["part"].unique())
        figure, (panel,) = style.panels(1, 1, 0.8 + 0.26 * len(numbers))
        ticks = []
        for place, number in enumerate(numbers):
            rows = margins[margins["part"] == number].sort_values("used")
            used = rows["used"].clip(lower=_LEAST).to_numpy()
            good = (rows["verdict"] == holds).to_numpy()
            # Spread over the height of the row, so that equal values do not hide each other.
            y = place + 0.26 * ((np.arange(len(rows)) * 0.618034) % 1.0 - 0.5) * 2.0
            panel.plot(used[good], y[good], "o", ms=3.0, color=style.BLUE, alpha=0.6, mew=0)
            panel.plot(used[~good], y[~good], "X", ms=5.0, color=style.RED)
            ticks.append(f"{parts[int(number)]}: {int(good.sum())} of {len(rows)}")
        panel.axvline(1.0, color=style.BLACK, ls="--", lw=0.9)
        panel.set_xscale("log")
        panel.set_xlim(0.8 * _LEAST, max(2.0, 1.3 * float(margins["used"].max())))
        panel.set_yticks(range(len(ticks)), ticks)
        panel.set_ylim(len(ticks) - 0.5, -0.5)
        panel.tick_params(axis="y", length=0)
        panel.grid(axis="x", color=style.LIGHT_GREY, lw=0.5)
        panel.set_axisbelow(True)
        panel.set_xlabel("Share of the tolerance used")
        count = int((margins["verdict"] == holds).sum())
        style.caption(
            figure,
            f"{count} of {len(margins)} checks hold; share used: difference from the reference / "
            "tolerance, or value / bound; dashed: limit; checks that use less than "
            f"{_LEAST:g} are drawn at the left edge",
        )
    return figure


def margins(checks: pd.DataFrame) -> pd.DataFrame:
    """Share of the tolerance that each check uses; 1 is the limit.

    Parameters
    ----------
    checks : pandas.DataFrame
        From `abradem.verification.checks.checks_table`, all parts together.

    Returns
    -------
    pandas.DataFrame
        part, law, verdict and ``used`` (dimensionless): absolute difference / tolerance; for an
        upper bound value / bound, for a lower bound bound / value.
    """
    ours, bound = (checks[name].abs().to_numpy(dtype=float) for name in ("ours", "reference"))
    with np.errstate(divide="ignore", invalid="ignore"):
        used = np.select(
            [checks["kind"] == "at most", checks["kind"] == "at least"],
            [ours / bound, bound / ours],
            checks["difference"].abs() / checks["tolerance"],
        )
    # 0 / 0: an exact result with zero tolerance uses nothing.
    used = np.where(np.isnan(used) & (ours == bound), 0.0, used)
    return checks[["part", "law", "verdict"]].assign(used=used)
