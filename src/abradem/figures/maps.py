"""Wear maps: where on the plate the wear is."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style


def wear_maps_figure(facets: pd.DataFrame, panels: pd.DataFrame, reading: str = "total") -> Figure:
    """Depth rate of every facet of the plate, one panel per case, yellow to red.

    Parameters
    ----------
    facets, panels : pandas.DataFrame
        From `abradem.wear_rate.depth_rate_maps`.
    reading : str
        Named below the panels.

    Returns
    -------
    matplotlib.figure.Figure
        Every panel has its own colour bar: wear constants differ by decades between cases.
    """
    with style.style():
        if panels.empty:
            figure, axes = style.panels(1, 1, 1.0, style.COLUMN)
            style.say_nothing_to_show(axes[0], "none of the cases was simulated")
            return figure
        figure, axes = style.panels(len(panels), 3, 2.0)
        for index, (panel, row) in enumerate(zip(axes, panels.to_dict("records"), strict=True)):
            style.title_case(panel, index, row)
            rows = facets[facets["case_id"] == row["case_id"]]
            if rows.empty:
                words = "no steady state" if row["status"] == "ok" else row["status"]
                style.say_nothing_to_show(panel, words)
            else:
                _map_panel(figure, panel, rows)
        style.caption(
            figure,
            f"reading: {reading}; depth rate of facets {_window_words(panels)}; "
            "x along the slope, z across, from the plate's centre; each panel has its own scale",
        )
    return figure


def _map_panel(figure: Figure, panel, rows: pd.DataFrame) -> None:
    grid = rows.pivot(index="z", columns="x", values="depth_rate")
    x, z = _edges(grid.columns.to_numpy()), _edges(grid.index.to_numpy())
    power = style.decade(grid.to_numpy().max())
    mesh = panel.pcolormesh(
        x, z, grid.to_numpy() / 10.0**power, cmap=style.WEAR_MAP, vmin=0.0, rasterized=True
    )
    panel.set_aspect("equal")
    panel.spines[["top", "right"]].set_visible(True)
    panel.set_xlabel("$x$ (mm)")
    panel.set_ylabel("$z$ (mm)")
    bar = figure.colorbar(mesh, cax=panel.inset_axes([1.05, 0.0, 0.055, 1.0]))
    bar.outline.set_linewidth(0.6)
    bar.set_label(f"Depth rate ({style.scaled_unit(power, 'mm/s')})", fontsize=7.0)


def _edges(middles: np.ndarray) -> np.ndarray:
    """Edges of equal cells with the given middles."""
    step = middles[1] - middles[0] if len(middles) > 1 else 1.0
    return np.append(middles - 0.5 * step, middles[-1] + 0.5 * step)


def _window_words(panels: pd.DataFrame) -> str:
    lengths = (panels["window_end"] - panels["window_start"]).dropna()
    if lengths.empty:
        return "in the window after the transient"
    words = list(dict.fromkeys((f"{lengths.min():.2g}", f"{lengths.max():.2g}")))
    return f"in the first {' to '.join(words)} s after the transient"
