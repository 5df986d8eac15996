"""Sensitivity of the wear to the sampled quantities."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from abradem.dataset.variation import VARIED
from abradem.figures import style
from abradem.quantities import quantity
from abradem.words.labels import LABELS

_INDICES = ("first", "total", "total_lower", "total_upper")
_FALLS = ("fall", "fall_lower", "fall_upper")
_SMALL = 0.01
"""Total index below which a quantity has no row, if its index of ln wear is as small."""
_MOST_CURVES = 8


def sensitivity_figure(
    indices: pd.DataFrame, falls: pd.DataFrame, dependence: pd.DataFrame, table: str
) -> Figure:
    """Sobol indices of wear and log wear, permutation importance, partial dependence.

    Parameters
    ----------
    indices, falls, dependence : pandas.DataFrame
        From `abradem.learning.physical.sensitivity`.
    table : str
        Name of the data set.
    """
    wear = indices[indices["explained"] == "wear"]
    ranked = wear.assign(told=wear["variation"] == VARIED)
    ranked = ranked.sort_values(["told", "total"], ascending=False, kind="stable")
    small = _small(indices)
    ranked = ranked[~ranked["feature"].isin(small)]
    order, says = list(ranked["feature"]), list(ranked["variation"])
    indices, falls = (
        table.assign(**{name: table[name].where(table["variation"] == VARIED) for name in columns})
        for table, columns in ((indices, _INDICES), (falls, _FALLS))
    )
    with style.style():
        shown = [name for name in order if name in set(dependence["feature"])][:_MOST_CURVES]
        lines = -(-len(shown) // 4)
        tall = 0.6 + 0.16 * max(len(order), 5)
        figure = style.new_figure(style.PAGE, tall + 1.45 * lines)
        grid = figure.add_gridspec(1 + lines, 4, height_ratios=(tall, *[1.45] * lines))
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
        names = [style.short_label(name) for name in order]
        left.set_yticks(places, names)
        left.set_xlabel("Sobol index")
        left.legend(
            handles=[
                Patch(color=style.BLUE, label="total, wear"),
                Patch(color=style.ORANGE, label="total, ln wear"),
                Line2D([], [], marker="|", ls="", mew=1.2, color=style.BLACK, label="first order"),
            ],
            loc="lower right",
        )
        left.set_title(f"{style.letter(0)} Sobol indices", loc="left")
        lost = falls.set_index("feature").loc[order]
        right.barh(places, lost["fall"], 0.6, color=style.GREEN)
        right.hlines(places, lost["fall_lower"], lost["fall_upper"], color=style.BLACK, lw=0.8)
        right.set_yticks(places, [f"${LABELS[name].tex}$" for name in order])
        right.set_xlabel("Fall of $R^2$ when shuffled")
        right.set_title(f"{style.letter(1)} permutation importance", loc="left")
        for panel in (left, right):
            panel.tick_params(axis="y", length=0)
            panel.set_ylim(len(order) - 0.5, -0.5)
            panel.set_xlim(0.0, None if panel.get_xlim()[1] > 0.0 else 1.0)
            style.name_unvaried(panel, says)
        most = dependence["predicted"].max()
        power = style.decade(most)
        for place, name in enumerate(shown):
            panel = figure.add_subplot(grid[1 + place // 4, place % 4])
            rows = dependence[dependence["feature"] == name]
            row = quantity(name)
            settings = rows["setting"].to_numpy() / row.config_factor
            # Small numbers would have their power of ten beside the axis, where it is overlooked.
            largest = float(np.abs(settings).max())
            down = style.decade(largest) if largest < 1e-2 else 0
            panel.plot(settings / 10.0**down, rows["predicted"] / 10.0**power, color=style.BLUE)
            panel.set_ylim(0.0, 1.08 * most / 10.0**power)
            unit = style.scaled_unit(down, row.config_unit)
            panel.set_xlabel(f"${LABELS[row.name].tex}$" + (f" ({unit})" if unit else ""))
            panel.set_title(style.letter(2 + place), loc="left")
            if place % 4 == 0:
                panel.set_ylabel(f"Wear ({style.scaled_unit(power, 'mm/s')})")
        style.caption(
            figure,
            f"data set: {table}; Gaussian process. (a) over the ranges of the data set, all "
            "quantities that varied independent; bars: 95 % of functions drawn from the posterior. "
            "(b) mean, smallest and largest of the splits. From (c) on: geometric mean of the "
            "predicted wear depth rate over the cases, with one quantity set to the value shown"
            + (
                f". Total indices below {_SMALL:g}, not drawn: "
                f"{', '.join(LABELS[name].long_name for name in small)}"
                if small
                else ""
            ),
        )
    return figure


def _small(indices: pd.DataFrame) -> list[str]:
    """Quantities that varied and whose total indices are all small, unless all are."""
    varied = indices[indices["variation"] == VARIED]
    most = varied.groupby("feature", sort=False)["total"].max()
    small = list(most[most < _SMALL].index)
    return small if len(small) < len(most) else []
