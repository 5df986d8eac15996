"""What the table of maps holds of the cells of a surface, beside their wear."""

from __future__ import annotations

from typing import Any

import numpy as np

from abradem.dem.surface import CELL_SUMS, Surface, cell_areas

CELL_TYPES = {
    "part_name": "str",
    "cell_area": "float64",
    "impacts": "float64",
    "impact_speed": "float64",
    "impact_angle": "float64",
    "normal_work": "float64",
    "tangential_work": "float64",
    "normal_impulse": "float64",
}
"""Columns of the cells of a surface, and their types."""


def cell_columns(surface: Surface, sums: np.ndarray) -> dict[str, Any]:
    """Return the columns `CELL_TYPES` of a surface.

    Parameters
    ----------
    surface : Surface
    sums : ndarray, shape (6, t)
        In the order of `abradem.dem.surface.CELL_SUMS`.

    Returns
    -------
    dict
        ``impact_speed`` (m/s) and ``impact_angle`` (deg from the normal) are means over the
        impacts of a cell, nan without any; the rest are sums.
    """
    import pandas as pd

    found = dict(zip(CELL_SUMS, sums, strict=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        means = {name: found[name] / found["impacts"] for name in ("impact_speed", "impact_angle")}
    names = pd.array(surface.part_names, dtype="str")
    columns = {**found, **means, "cell_area": cell_areas(surface), "part_name": names[surface.part]}
    return {name: columns[name] for name in CELL_TYPES}
