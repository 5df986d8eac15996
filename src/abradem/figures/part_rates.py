"""Wear of each part of a surface against the quantities that varied."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.wear.part_effects import unit_of_quantity
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget

MOST_QUANTITIES = 3
"""Largest number of quantities shown; those with the strongest effects are."""


def draw_part_rates(
    parts: pd.DataFrame, effects: pd.DataFrame, cases: pd.DataFrame, target: Mapping
) -> Figure:
    """Draw the wear rate of each part against each quantity, one point per case.

    Parameters
    ----------
    parts : pandas.DataFrame
        From `abradem.wear.surface_cells.part_table`.
    effects : pandas.DataFrame
        From `abradem.wear.part_effects.part_effects`.
    cases : pandas.DataFrame
    target : mapping
        Arguments of `abradem.words.wear.WearTarget`.

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
            style.say_nothing_to_show(axes[0], "too few cases, or no quantity varied")
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
            panel.set_xlabel(style.with_unit(words, unit_of_quantity(name)))
            panel.set_title(style.letter(index), loc="left")
            if index == 0:
                panel.set_ylabel("Depth rate (mm/s)")
                panel.legend(fontsize=6.5)
        style.caption(figure, f"{explained.words}; one point per case and part")
    return figure
