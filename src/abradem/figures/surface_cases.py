"""Wear map of the surface of a case of a study."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from abradem.dem.model import Setup
from abradem.figures.surface_map import surface_map_figure
from abradem.geometry.build import prepared


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
    surface = prepared(Setup.from_dict(setup), values).surface
    return surface_map_figure(surface, cells[cells["case_id"] == shown], measure)
