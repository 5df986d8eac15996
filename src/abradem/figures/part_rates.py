"""Wear of each part of a surface, against the quantities that varied if any did."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.quantities import wear_column
from abradem.wear.part_effects import unit_of_quantity
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget

MOST_QUANTITIES = 3
"""Largest number of quantities shown; those with the strongest effects are."""

MARKERS = "os^Dv"
"""Markers of the parts, so that colour is not all that tells them apart."""

WIDE_RANGE = 10.0
"""Rates are on a logarithmic axis if the largest is more than this times the smallest."""

SINGLE = 0.62
"""Width of a figure of one panel, as a share of the page."""


def draw_part_rates(
    parts: pd.DataFrame,
    effects: pd.DataFrame,
    cases: pd.DataFrame,
    target: Mapping,
    reference: float | None = None,
    source: str | None = None,
) -> Figure:
    """Draw the wear rate of each part against each quantity, one point per case.

    Where none varied, the rates of the parts are drawn side by side.

    Parameters
    ----------
    parts : pandas.DataFrame
        From `abradem.wear.surface_cells.part_table`.
    effects : pandas.DataFrame
        From `abradem.wear.part_effects.part_effects`.
    cases : pandas.DataFrame
    target : mapping
        Arguments of `abradem.words.wear.WearTarget`.
    reference : float, optional
        Rate from elsewhere, mm/s.
    source : str, optional
        Who states it.

    Returns
    -------
    matplotlib.figure.Figure
    """
    explained = WearTarget(**target)
    strength = effects.groupby("quantity", sort=False)["rank_correlation"].agg(
        lambda found: found.abs().max()
    )
    shown = list(strength.sort_values(ascending=False).index[:MOST_QUANTITIES])
    known = cases.set_index("case_id")
    with style.style():
        width = style.PAGE * (1.0 if len(shown) > 1 else SINGLE)
        figure, axes = style.panels(max(1, len(shown)), MOST_QUANTITIES, 2.2, width)
        if not shown:
            _draw_side_by_side(axes[0], parts, explained)
            _finish(axes[0], parts[list(_columns(explained))], reference, source)
            style.caption(
                figure,
                f"wear depth rate, {explained.measure}, of each part; one point per case; too few "
                "cases, or no quantity varied",
            )
            return figure
        for index, (panel, name) in enumerate(zip(axes, shown, strict=True)):
            for place, part in enumerate(dict.fromkeys(parts["part_name"])):
                rows = parts[parts["part_name"] == part]
                panel.plot(
                    known.loc[rows["case_id"], name],
                    rows[explained.name],
                    MARKERS[place % len(MARKERS)],
                    ms=3.0,
                    color=style.PALETTE[place % len(style.PALETTE)],
                    label=part.replace("_", " "),
                )
            words = LABELS[name].long_name if name in LABELS else name.replace("_", " ")
            panel.set_xlabel(style.with_unit(words, unit_of_quantity(name)))
            if len(shown) > 1:
                panel.set_title(style.letter(index), loc="left")
            _finish(panel, parts[explained.name], reference, source, first=index == 0)
        style.caption(figure, f"{explained.of_part}; one point per case and part")
    return figure


def _draw_side_by_side(panel: Axes, parts: pd.DataFrame, explained: WearTarget) -> None:
    """Draw the target and its 99th percentile over the cells of each part, one point per case."""
    names = list(dict.fromkeys(parts["part_name"]))
    for place, (column, words) in enumerate(_columns(explained).items()):
        panel.plot(
            parts["part_name"].map(names.index), parts[column], MARKERS[place], ms=4.0, mfc="none",
            color=style.PALETTE[place], label=words,
        )  # fmt: skip
    panel.set_xticks(range(len(names)), [name.replace("_", " ") for name in names])
    panel.set_xlim(-0.5, max(len(names), 1) - 0.5)


def _columns(explained: WearTarget) -> dict[str, str]:
    """Columns of the target and of its 99th percentile over the cells, with their words."""
    p99 = explained._replace(name=wear_column(explained.measure, "p99"))
    return {one.name: one.of_cells for one in (explained, p99)}


def _finish(
    panel: Axes,
    drawn: pd.DataFrame | pd.Series,
    reference: float | None,
    source: str | None,
    first: bool = True,
) -> None:
    """Draw the reference, choose the scale of the rates drawn, mm/s, and name axis and marks."""
    rates = drawn.to_numpy().ravel()
    if reference is not None:
        panel.axhline(
            reference, color=style.GREY, lw=0.8, ls=(0, (4, 3)), label=source or "reference"
        )
        rates = np.append(rates, reference)
    if rates.size and rates.min() > 0.0 and rates.max() > WIDE_RANGE * rates.min():
        panel.set_yscale("log")
    if first:
        panel.set_ylabel("Depth rate (mm/s)")
        handles, labels = panel.get_legend_handles_labels()
        panel.figure.legend(
            handles,
            labels,
            loc="outside upper center",
            ncols=min(len(labels), 4),
            columnspacing=1.2,
        )
