"""Wear map of a surface: a view in space, and its curved and flat parts laid out."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from abradem.dem.model import Setup
from abradem.dem.surface import Surface
from abradem.figures import style
from abradem.figures.wear_colours import WEAR_MAP
from abradem.geometry.build import case_surface
from abradem.geometry.outline import outline
from abradem.geometry.shape import cross_products
from abradem.geometry.unrolled import FlatPart, unrolled_part
from abradem.units import MM_PER_M

ELEVATION = 22.0
"""Elevation of the view, degrees."""

AZIMUTHS = (-60.0, -120.0)
"""Azimuths of the view, degrees; the one from which more of the wear faces the reader is taken."""

BARE = (0.55, 0.58, 0.62, 0.14)
"""Colour of cells without wear: transparent, so that walls do not hide what is worn."""

BARE_FLAT = (0.92, 0.925, 0.93, 1.0)
"""The same on a flat map, where neither hides the other."""

MOST_FLAT = 4
"""Largest number of parts that are laid out; the most worn are."""

LETTERS_PER_INCH = 22
"""Length of a line of the caption."""

TOP = 0.995
"""Share of the worn area up to whose depth rate the colours go, so that one cell does not hide the
others."""


def draw_surface(
    cells: pd.DataFrame, cases: pd.DataFrame, setup: Mapping, shown: int, measure: str
) -> Figure:
    """Draw `surface_map_figure` for a case; the first with a map if that case has none.

    Parameters
    ----------
    cells : pandas.DataFrame
        From `abradem.wear.surface_cells.cell_table`.
    cases : pandas.DataFrame
    setup : mapping
        Plain values of the `Setup`.
    shown : int
        Case.
    measure : str
        Wear measure.
    """
    if not (cells["case_id"] == shown).any():
        shown = int(cells["case_id"].iloc[0])
    values = cases.set_index("case_id").loc[shown].to_dict()
    surface = case_surface(Setup.from_dict(setup), values)
    return surface_map_figure(surface, cells[cells["case_id"] == shown], measure)


def surface_map_figure(surface: Surface, cells: pd.DataFrame, measure: str) -> Figure:
    """Draw the wear depth rate of every cell of a surface.

    Parameters
    ----------
    surface : Surface
    cells : pandas.DataFrame
        Rows of one case of `abradem.wear.surface_cells.cell_table`.
    measure : str
        One of `abradem.quantities.WEAR_MEASURES`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    rate = cells[f"depth_rate_{measure}"].to_numpy()
    area = cells["cell_area"].to_numpy()
    top, power = _top(rate, area), style.decade(rate.max())
    colours = ScalarMappable(
        Normalize(0.0, top / 10.0**power or 1.0), matplotlib.colormaps[WEAR_MAP]
    )
    faces = colours.to_rgba(rate / 10.0**power)
    bare = (rate <= 0.0)[:, None]
    flat = _flat_parts(surface, rate * area)
    with style.style():
        width = style.PAGE if flat else 0.7 * style.PAGE
        figure = style.new_figure(width, 3.4)
        figure.set_layout_engine("none")
        share = 0.44 if flat else 0.8
        space = figure.add_axes((0.0, 0.1, share, 0.9), projection="3d")
        _space(space, surface, np.where(bare, BARE, faces), _azimuth(surface, rate))
        if flat:
            _flat(figure, surface, np.where(bare, BARE_FLAT, faces), flat)
        bar_place = (0.92, 0.2, 0.015, 0.62) if flat else (0.84, 0.22, 0.02, 0.6)
        bar = figure.colorbar(
            colours, cax=figure.add_axes(bar_place), extend="max" if top < rate.max() else "neither"
        )
        bar.outline.set_linewidth(0.6)
        # Short labels leave room for the words.
        bar.locator = matplotlib.ticker.MaxNLocator(7, steps=[1, 2, 5, 10])
        bar.set_label(f"Depth rate ({style.scaled_unit(power, 'mm/s')})", fontsize=7.0)
        words = (
            f"wear measure: {measure}; grey: cells without wear; largest depth rate "
            f"{style.number(float(rate.max()))} mm/s"
        )
        if flat:
            words += "; right: parts laid out, $s$ from the higher end"
            words += ", $w$ level" if any(one.across == "w" for _, one in flat) else ""
        lines = "\n".join(textwrap.wrap(words, int(LETTERS_PER_INCH * width)))
        figure.text(0.01, 0.015, lines, fontsize=6.0, color=style.GREY)
    return figure


def _top(rate: np.ndarray, area: np.ndarray) -> float:
    """Depth rate that `TOP` of the worn area does not exceed, mm/s."""
    order = np.argsort(rate)
    worn = np.cumsum(np.where(rate[order] > 0.0, area[order], 0.0))
    if not worn[-1] > 0.0:
        return 0.0
    return float(rate[order][np.searchsorted(worn, TOP * worn[-1])])


def _azimuth(surface: Surface, rate: np.ndarray) -> float:
    """The one of `AZIMUTHS` from which most of the worn volume is seen, if nothing hides it."""
    across = cross_products(surface.vertices, surface.triangles)

    def seen(azimuth: float) -> float:
        up, turn = np.radians([ELEVATION, azimuth])
        # Axes x, -z and y of the view.
        towards = np.array([np.cos(up) * np.cos(turn), np.sin(up), -np.cos(up) * np.sin(turn)])
        return float(rate @ np.abs(across @ towards))

    return max(AZIMUTHS, key=seen)


def _space(panel, surface: Surface, faces: np.ndarray, azimuth: float) -> None:
    """Draw the surface in space; y points up on the page."""
    places = MM_PER_M * surface.vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    drawn = Poly3DCollection(places[surface.triangles], facecolors=faces, edgecolors="none")
    panel.add_collection3d(drawn)
    lines = MM_PER_M * outline(surface, surface.vertices[surface.triangles])
    if len(lines):
        drawn_lines = lines[..., [0, 2, 1]] * (1.0, -1.0, 1.0)
        panel.add_collection3d(Line3DCollection(drawn_lines, colors=style.GREY, linewidths=0.4))
    low, high = places.min(axis=0), places.max(axis=0)
    middle = 0.5 * (low + high)
    half = 0.5 * np.maximum(high - low, 0.05 * (high - low).max())
    for limits, at, reach in zip(
        (panel.set_xlim, panel.set_ylim, panel.set_zlim), middle, half, strict=True
    ):
        limits(at - reach, at + reach)
    panel.set_box_aspect(half, zoom=0.92)
    panel.view_init(ELEVATION, azimuth)
    for label, words, away in (
        (panel.set_xlabel, "$x$", -6.0),
        (panel.set_ylabel, "$-z$", -6.0),
        # Its numbers stand between the label and the axis.
        (panel.set_zlabel, "$y$", -2.0),
    ):
        label(f"{words} (mm)", fontsize=6.5, labelpad=away)
    for axis in (panel.xaxis, panel.yaxis, panel.zaxis):
        axis.set_major_locator(matplotlib.ticker.MaxNLocator(3))
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis._axinfo["grid"].update(color=(0.0, 0.0, 0.0, 0.08), linewidth=0.4)
    panel.tick_params(labelsize=5.5, pad=-2.0)
    panel.tick_params(axis="x", pad=-0.5)
    panel.tick_params(axis="z", pad=1.0)


def _flat_parts(surface: Surface, worn: np.ndarray) -> list[tuple[int, FlatPart]]:
    """Parts that can be laid out, with their corners, from the higher part to the lower."""
    found = []
    for part in range(len(surface.part_names)):
        laid = unrolled_part(surface, part)
        if laid is not None:
            chosen = surface.part == part
            height = surface.vertices[surface.triangles[chosen], 1].max()
            found.append((float(worn[chosen].sum()), height, part, laid))
    most = sorted(found, key=lambda one: -one[0])[:MOST_FLAT]
    return [one[2:] for one in sorted(most, key=lambda one: -one[1])]


def _flat(
    figure: Figure, surface: Surface, faces: np.ndarray, flat: Sequence[tuple[int, FlatPart]]
) -> None:
    """Draw the parts that are laid out beside each other, on one scale."""
    left, right, bottom, top = 0.48, 0.88, 0.16, 0.88
    extents = [
        (float(np.ptp(laid.corners[..., 1])), float(np.ptp(laid.corners[..., 0])))
        for _, laid in flat
    ]
    gap = 0.045
    room = right - left - gap * (len(flat) - 1)
    wide, high = figure.get_size_inches()
    scale = min(
        room * wide / sum(extent[0] for extent in extents),
        (top - bottom) * high / max(extent[1] for extent in extents),
    )
    used = scale * sum(extent[0] for extent in extents) / wide + gap * (len(flat) - 1)
    at = left + 0.5 * (right - left - used)
    for place, ((part, laid), (across, along)) in enumerate(zip(flat, extents, strict=True)):
        corners = laid.corners
        size = scale * across / wide, scale * along / high
        panel = figure.add_axes((at, top - size[1], *size))
        at += size[0] + gap
        panel.add_collection(
            PolyCollection(
                list(MM_PER_M * corners[..., ::-1]),
                facecolors=faces[surface.part == part],
                edgecolors="face",
                linewidths=0.2,
                rasterized=True,
            )
        )
        z, s = corners[..., 1], corners[..., 0]
        panel.set_xlim(MM_PER_M * z.min(), MM_PER_M * z.max())
        panel.set_ylim(MM_PER_M * s.max(), MM_PER_M * s.min())
        panel.spines[["top", "right"]].set_visible(True)
        panel.set_title(surface.part_names[part].replace("_", " "), fontsize=7.0)
        panel.tick_params(labelsize=5.5)
        panel.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(2))
        panel.set_xlabel(f"${laid.across}$ (mm)", fontsize=6.5)
        if place == 0:
            panel.set_ylabel("$s$ (mm)", fontsize=6.5)
        else:
            panel.set_yticklabels([])
