"""Wear of each part of a surface, against the quantities that varied if any did."""

from __future__ import annotations

from collections.abc import Mapping

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


def draw_part_rates(
    parts: pd.DataFrame,
    effects: pd.DataFrame,
    cases: pd.DataFrame,
    target: Mapping,
    reference: float | None = None,
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
        figure, axes = style.panels(max(1, len(shown)), MOST_QUANTITIES, 2.2)
        if not shown:
            _draw_side_by_side(axes[0], parts, explained, reference)
            style.caption(
                figure,
                f"wear depth rate, {explained.measure}, of each part; one point per case; too few "
                "cases, or no quantity varied",
            )
            return figure
        for index, (panel, name) in enumerate(zip(axes, shown, strict=True)):
            for colour, part in zip(style.PALETTE, dict.fromkeys(parts["part_name"]), strict=False):
                rows = parts[parts["part_name"] == part]
                panel.plot(
                    known.loc[rows["case_id"], name],
                    rows[explained.name],
                    "o",
                    ms=3.0,
                    color=colour,
                    label=part.replace("_", " "),
                )
            words = LABELS[name].long_name if name in LABELS else name.replace("_", " ")
            if reference is not None:
                _draw_reference(panel, reference)
            panel.set_xlabel(style.with_unit(words, unit_of_quantity(name)))
            panel.set_title(style.letter(index), loc="left")
            if index == 0:
                panel.set_ylabel("Depth rate (mm/s)")
                panel.legend(fontsize=6.5)
        style.caption(figure, f"{explained.of_part}; one point per case and part")
    return figure


def _draw_side_by_side(
    panel: Axes, parts: pd.DataFrame, explained: WearTarget, reference: float | None
) -> None:
    """Draw the target and its 99th percentile over the cells of each part, one point per case."""
    names = list(dict.fromkeys(parts["part_name"]))
    p99 = explained._replace(name=wear_column(explained.measure, "p99"))
    columns = {one.name: one.of_cells for one in (explained, p99)}
    for marker, colour, (column, words) in zip("os", style.PALETTE, columns.items(), strict=False):
        place = parts["part_name"].map(names.index)
        panel.plot(place, parts[column], marker, ms=3.5, color=colour, label=words)
    if reference is not None:
        _draw_reference(panel, reference)
    if (parts[list(columns)] > 0.0).any(axis=None):
        panel.set_yscale("log")
    panel.set_xticks(range(len(names)), [name.replace("_", " ") for name in names])
    panel.set_xlim(-0.5, max(len(names), 1) - 0.5)
    panel.set_ylabel("Depth rate (mm/s)")
    panel.legend(fontsize=6.5)


def _draw_reference(panel: Axes, reference: float) -> None:
    panel.axhline(reference, color=style.GREY, lw=0.8, ls=(0, (4, 3)), label="reference")
