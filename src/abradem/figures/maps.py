"""Wear maps: distribution of the wear over the plate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.figures.cases_shown import runs_shown, stacked
from abradem.figures.wear_colours import no_wear_handle, only_worn, wear_colours
from abradem.quantities import SAMPLED_NAMES
from abradem.store.tables import concatenate
from abradem.units import MM_PER_M
from abradem.wear.rates import depth_map
from abradem.words.wear import WearTarget


def draw(
    maps: Iterable[pd.DataFrame],
    runs: Iterable[pd.DataFrame],
    cases: Iterable[pd.DataFrame],
    setup: Mapping,
    shown: Sequence[int],
    target: Mapping,
) -> Figure:
    """Draw `wear_maps_figure` from the tables of the batches, see `depth_rate_maps`."""
    worn, ended, drawn = (concatenate(parts) for parts in (maps, runs, cases))
    values, explained = Setup.from_dict(setup), WearTarget(**target)
    found = depth_rate_maps(worn, ended, drawn, values, shown, explained.measure)
    return wear_maps_figure(*found, explained)


def wear_maps_figure(facets: pd.DataFrame, panels: pd.DataFrame, target: WearTarget) -> Figure:
    """Wear depth rate of every facet of the plate, one panel per case.

    Parameters
    ----------
    facets, panels : pandas.DataFrame
        From `abradem.figures.maps.depth_rate_maps`.
    target : WearTarget
        Target of the study; the caption names its measure.

    Returns
    -------
    matplotlib.figure.Figure
        Every panel has its own colour bar, as wear constants differ by decades between cases. If
        the target is a statistic over elements larger than a facet, lines show their edges.
    """
    with style.style():
        if panels.empty:
            figure, axes = style.panels(1, 1, 1.0, style.COLUMN)
            style.say_nothing_to_show(axes[0], "none of the cases was simulated")
            return figure
        figure, axes = style.panels(len(panels), 3, 2.0)
        lined = False
        for index, (panel, row) in enumerate(zip(axes, panels.to_dict("records"), strict=True)):
            style.title_case(panel, index, row)
            rows = facets[facets["case_id"] == row["case_id"]]
            if rows.empty:
                words = "no steady state" if row["status"] == "ok" else row["status"]
                style.say_nothing_to_show(panel, words)
            else:
                lined |= _map_panel(figure, panel, rows, target)
        if (facets["depth_rate"] <= 0.0).any():
            figure.legend(handles=[no_wear_handle()], loc="outside upper center")
        style.caption(
            figure,
            f"wear measure: {target.measure}; depth rate of each facet {_window_words(panels)}; "
            "places from the centre of the plate; each panel has its own colour scale, from 0 to "
            "its largest rate"
            + (f"; lines: elements of the target, {target.place}" if lined else ""),
        )
    return figure


def _map_panel(figure: Figure, panel, rows: pd.DataFrame, target: WearTarget) -> bool:
    """Draw a map; return whether the edges of the elements of the target are drawn on it."""
    grid = rows.pivot(index="z", columns="x", values="depth_rate")
    x, z = _edges(grid.columns.to_numpy()), _edges(grid.index.to_numpy())
    power = style.decade(grid.to_numpy().max())
    mesh = panel.pcolormesh(
        x, z, only_worn(grid.to_numpy() / 10.0**power), cmap=wear_colours(), vmin=0.0,
        rasterized=True,
    )  # fmt: skip
    panel.set_aspect("equal")
    panel.spines[["top", "right"]].set_visible(True)
    panel.set_xlabel("Up the slope (mm)")
    panel.set_ylabel("Across (mm)")
    bar = figure.colorbar(mesh, cax=panel.inset_axes([1.05, 0.0, 0.055, 1.0]))
    bar.outline.set_linewidth(0.6)
    bar.set_label(f"Depth rate ({style.scaled_unit(power, 'mm/s')})", fontsize=7.0)
    size = target.element_size
    if not target.has_elements or size is None or MM_PER_M * size < 1.5 * (x[1] - x[0]):
        return False
    for edges, line in ((x, panel.axvline), (z, panel.axhline)):
        count = round((edges[-1] - edges[0]) / (MM_PER_M * size))
        for place in np.linspace(edges[0], edges[-1], count + 1)[1:-1]:
            line(place, color=style.GREY, lw=0.4)
    return True


def _edges(middles: np.ndarray) -> np.ndarray:
    """Edges of equal cells with the given centres."""
    step = middles[1] - middles[0] if len(middles) > 1 else 1.0
    return np.append(middles - 0.5 * step, middles[-1] + 0.5 * step)


def _window_words(panels: pd.DataFrame) -> str:
    lengths = (panels["window_end"] - panels["window_start"]).dropna()
    if lengths.empty:
        return "in the window after the transient"
    words = list(dict.fromkeys((f"{lengths.min():.2g}", f"{lengths.max():.2g}")))
    return f"in the first {' to '.join(words)} s after the transient"


def depth_rate_maps(
    maps: pd.DataFrame,
    runs: pd.DataFrame,
    cases: pd.DataFrame,
    setup: Setup,
    shown: Sequence[int],
    measure: str,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Wear depth rate of every facet within the averaging window, for some cases.

    Parameters
    ----------
    maps, runs, cases, setup
        As for `abradem.wear.rates.wear_rates`; rows of other cases are ignored.
    shown : sequence of int
        Cases, in the desired order.
    measure : str
        One of `abradem.quantities.WEAR_MEASURES`.

    Returns
    -------
    facets : pandas.DataFrame
        case_id, facet_x, facet_z, centre of the facet ``x`` and ``z`` (mm along the slope and the
        width, from the centre of the plate), ``depth_rate`` (mm/s).
    panels : pandas.DataFrame
        One row per case of ``shown`` among the runs: case_id, status, the sampled quantities,
        window_start, window_end (s; nan without a steady state; such cases have no facets).
    """
    nx, nz = setup.facets
    facet_x, facet_z = (index.ravel() for index in np.indices((nx, nz)))
    places = {
        "facet_x": facet_x,
        "facet_z": facet_z,
        "x": MM_PER_M * setup.plate_length * ((facet_x + 0.5) / nx - 0.5),
        "z": MM_PER_M * setup.plate_width * ((facet_z + 0.5) / nz - 0.5),
    }
    constants = cases.set_index("case_id")
    facets, panels = [], []
    for run in runs_shown(runs, shown):
        key = run["case_id"]
        row = constants.loc[key]
        window = run["window_end"] - run["window_start"]
        if window > 0.0:
            wear = depth_map(maps[maps["case_id"] == key], setup.facets)[measure]
            per_joule = row["archard_constant"] * nx * nz / (setup.plate_area * window)
            rate = MM_PER_M * per_joule * wear.ravel()
            facets.append(pd.DataFrame({"case_id": key, **places, "depth_rate": rate}))
        panels.append(
            {
                **{name: run[name] for name in ("case_id", "status", "window_start", "window_end")},
                **{name: float(row[name]) for name in SAMPLED_NAMES},
            }
        )
    return stacked(facets, ("case_id", *places, "depth_rate")), pd.DataFrame(panels)
