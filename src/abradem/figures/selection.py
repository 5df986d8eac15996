"""Selection of the features of the networks."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE


def selection_figure(selection: pd.DataFrame, summary: dict) -> Figure:
    """Features chosen by weight and by loading, compared with the list of the paper.

    Parameters
    ----------
    selection : pandas.DataFrame
    summary : dict
        From `abradem.learning.baselines.selection.fit_selection`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style.style():
        figure, axes = style.panels(3, 3, 3.3)
        published = selection[selection["protocol"] == AS_PUBLISHED]
        places = np.arange(len(published))
        largest = published[["lasso_weight", "ridge_weight"]].abs().max(axis=1)
        for panel, index, values, words in (
            (axes[0], 0, largest, "Largest absolute weight"),
            (axes[1], 1, published["leading_share"], "Share in leading components"),
        ):
            by = ("weight", "loading")[index]
            chosen = published["chosen_by"] == by
            colours = np.where(chosen, style.PROTOCOL_COLOURS[AS_PUBLISHED], style.LIGHT_GREY)
            panel.barh(places, values, height=0.66, color=colours)
            style.feature_rows(panel, published["feature"])
            style.name_fixed(panel, published["variation"])
            panel.set_xlabel(words)
            panel.set_title(
                f"{style.letter(index)} chosen by {by}, as published", loc="left", fontsize=7.0
            )
        _survival(axes[2], selection[selection["protocol"] == LEAKAGE_FREE])
        shared = {name: summary[name]["shared_with_paper"] for name in (AS_PUBLISHED, LEAKAGE_FREE)}
        style.caption(
            figure,
            f"{summary['count']} features, half by weight (larger of lasso and ridge), half by "
            "squared loadings on the components that explain half of the variance; grey in (a, b): "
            f"not chosen. In common with the paper's 12: {shared[AS_PUBLISHED]} as published (all "
            f"rows, min-max scaling), {shared[LEAKAGE_FREE]} leakage-free (training rows of the "
            "first split)" + style.sharing(selection),
        )
    return figure


def _survival(panel, leakage_free) -> None:
    places = np.arange(len(leakage_free))
    panel.barh(
        places, leakage_free["survives"], height=0.66, color=style.PROTOCOL_COLOURS[LEAKAGE_FREE]
    )
    listed = leakage_free["in_paper"].to_numpy(dtype=bool)
    panel.plot(np.full(listed.sum(), 1.06), places[listed], "o", color=style.BLACK, ms=3.0)
    panel.set_xlim(0.0, 1.12)
    style.feature_rows(panel, leakage_free["feature"])
    style.name_fixed(panel, leakage_free["variation"])
    panel.set_xlabel("Share of splits that select it")
    panel.set_title(f"{style.letter(2)} leakage-free; dot: paper's list", loc="left", fontsize=7.0)
