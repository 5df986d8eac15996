"""Wear maps over the parameter space: a grid of cases over two quantities."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.figures.maps import depth_rate_maps
from abradem.figures.wear_colours import no_wear_handle, only_worn, wear_colours
from abradem.store.tables import concatenate
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget


def draw(
    cases: pd.DataFrame,
    maps: Iterable[pd.DataFrame],
    runs: Iterable[pd.DataFrame],
    setup: Mapping,
    grid: Mapping,
    target: Mapping,
) -> Figure:
    """Draw `gallery_figure` for cases that represent the parameter space.

    Parameters
    ----------
    cases : pandas.DataFrame
        All cases.
    maps, runs : iterable of pandas.DataFrame
        Tables of the batches. Only the maps of the chosen cases are kept, as those of all cases of
        a large study do not fit into memory.
    setup : mapping
        Plain values of the `Setup`.
    grid : mapping
        Arguments of `chosen_cases`.
    target : mapping
        Arguments of the `WearTarget` of the study, whose measure is shown.
    """
    joined = concatenate(runs)
    places = chosen_cases(cases, joined, **grid)
    chosen = list(places["case_id"])
    kept = concatenate(part[part["case_id"].isin(chosen)] for part in maps)
    measure = WearTarget(**target).measure
    shown = depth_rate_maps(kept, joined, cases, Setup.from_dict(setup), chosen, measure)
    return gallery_figure(*shown, places, grid["across"], grid["down"], measure)


def gallery_figure(
    facets: pd.DataFrame,
    panels: pd.DataFrame,
    places: pd.DataFrame,
    across: str,
    down: str,
    measure: str,
) -> Figure:
    """Wear maps of cases, each with its own colour scale, ordered by two quantities.

    Parameters
    ----------
    facets, panels : pandas.DataFrame
        From `abradem.figures.maps.depth_rate_maps`.
    places : pandas.DataFrame
        case_id, row, column from `abradem.figures.gallery.chosen_cases`.
    across, down : str
        Quantities by which columns and rows are ordered.
    measure : str
        Wear measure, named in the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Above each map the two quantities and the radius of the case, below it the largest depth
        rate, at which the colours end.
    """
    with style.style():
        if places.empty:
            figure, axes = style.panels(1, 1, 1.0, style.COLUMN)
            style.say_nothing_to_show(axes[0], "no case has a wear map")
            return figure
        columns, rows = int(places["column"].max()) + 1, int(places["row"].max()) + 1
        figure = style.new_figure(style.PAGE, 0.75 + rows * (0.86 * style.PAGE / columns + 0.36))
        grid = figure.subplots(rows, columns, squeeze=False)
        for panel in grid.ravel():
            panel.set_axis_off()
        known = panels.set_index("case_id")
        mesh = None
        for place in places.to_dict("records"):
            panel = grid[place["row"], place["column"]]
            key = place["case_id"]
            mesh = _map(panel, facets[facets["case_id"] == key], known.loc[key])
        if mesh is not None:
            bar = figure.colorbar(mesh, ax=grid, shrink=0.5, aspect=30, pad=0.015)
            bar.outline.set_linewidth(0.6)
            bar.set_label("Depth rate / largest depth rate of the map")
        figure.supxlabel(f"{style.axis_label(across)}, larger to the right", fontsize=8.0)
        figure.supylabel(f"{style.axis_label(down)}, larger downwards", fontsize=8.0)
        if (facets["depth_rate"] <= 0.0).any():
            figure.legend(handles=[no_wear_handle()], loc="outside upper right")
        style.caption(
            figure,
            f"wear measure: {measure}; columns: {LABELS[across].long_name}, rows: "
            f"{LABELS[down].long_name}; shown is the case nearest to the centre of each cell of "
            "the sampled ranges; above each map: these two quantities and the radius; below: its "
            "largest depth rate, the end of its colour scale; in every map the slope rises to the "
            "right",
        )
    return figure


def _map(panel, rows: pd.DataFrame, case: pd.Series):
    wear = rows.pivot(index="z", columns="x", values="depth_rate")
    depth = wear.to_numpy()
    top = float(depth.max())
    step = [
        (axis[1] - axis[0]) if len(axis) > 1 else 1.0
        for axis in (wear.columns.to_numpy(), wear.index.to_numpy())
    ]
    edges = [
        np.append(axis - 0.5 * width, axis[-1] + 0.5 * width)
        for axis, width in zip((wear.columns.to_numpy(), wear.index.to_numpy()), step, strict=True)
    ]
    panel.set_axis_on()
    mesh = panel.pcolormesh(
        *edges, only_worn(depth / top if top > 0.0 else depth), cmap=wear_colours(),
        vmin=0.0, vmax=1.0, rasterized=True,
    )  # fmt: skip
    panel.set_aspect("equal")
    panel.set_xticks([])
    panel.set_yticks([])
    panel.spines[["top", "right"]].set_visible(True)
    panel.set_title(
        f"{style.number(case['plate_angle'], 2)}°, "
        f"{style.number(case['particle_velocity_y'], 2)} m/s,\n"
        f"{1e3 * case['particle_radius']:.0f} mm",
        fontsize=6.5, pad=2.0,
    )  # fmt: skip
    panel.set_xlabel(f"max {style.number(top, 2)} mm/s", fontsize=6.5, labelpad=1.5)
    return mesh


def chosen_cases(
    cases: pd.DataFrame, runs: pd.DataFrame, across: str, down: str, columns: int, rows: int
) -> pd.DataFrame:
    """The case nearest to the centre of each cell of a grid over two quantities.

    Parameters
    ----------
    cases, runs : pandas.DataFrame
        Cases without a wear map are not chosen.
    across, down : str
        Quantities that increase from left to right and from top to bottom.
    columns, rows : int
        Numbers of cells; the ranges of the quantities are divided evenly.

    Returns
    -------
    pandas.DataFrame
        case_id, row, column; cells without a case are left out.
    """
    good = runs[(runs["status"] == "ok") & (runs["window_end"] > runs["window_start"])]
    known = cases[cases["case_id"].isin(good["case_id"])].reset_index(drop=True)
    if known.empty:
        return pd.DataFrame({"case_id": [], "row": [], "column": []}, dtype=int)
    place = {}
    for name, count in ((across, columns), (down, rows)):
        low, high = cases[name].min(), cases[name].max()
        place[name] = count * (known[name] - low) / ((high - low) or 1.0)
    cell = {
        name: np.clip(place[name].astype(int), 0, count - 1)
        for name, count in ((across, columns), (down, rows))
    }
    off = sum((place[name] - cell[name] - 0.5) ** 2 for name in (across, down))
    table = pd.DataFrame(
        {"case_id": known["case_id"], "row": cell[down], "column": cell[across], "off": off}
    )
    nearest = table.sort_values(["off", "case_id"]).drop_duplicates(["row", "column"])
    return nearest.sort_values(["row", "column"], ignore_index=True)[["case_id", "row", "column"]]
