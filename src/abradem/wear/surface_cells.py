"""Wear of the cells and of the named parts of a surface, as tables."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.dem.surface import Surface
from abradem.geometry.build import case_surface, shape_of
from abradem.geometry.shape import centres, unit_normals
from abradem.quantities import STATISTICS, WEAR_MEASURES, wear_column
from abradem.units import MM_PER_M
from abradem.wear.rates import element_rates

SUMS = (
    "impacts", "impact_speed", "impact_angle", "normal_work", "tangential_work", "normal_impulse",
)  # fmt: skip


def cell_table(
    maps: pd.DataFrame, runs: pd.DataFrame, cases: pd.DataFrame, setup: Setup
) -> pd.DataFrame:
    """Return the wear of every cell of every case with a complete window.

    Parameters
    ----------
    maps, runs : pandas.DataFrame
        Tables written by the simulations of a geometry.
    cases : pandas.DataFrame
        The cases, with the sampled quantities of the geometry.
    setup : Setup
        With a geometry.

    Returns
    -------
    pandas.DataFrame
        case_id, cell, part_name; x, y, z of the centre, m, and unit normal; cell_area, m2;
        ``depth_rate_<measure>``, mm/s; impacts, their mean speed, m/s, and angle, deg; work of
        the normal and of the tangential force, J, and impulse of the normal force, N s, in the
        window.
    """
    known = cases.set_index("case_id")
    frames = []
    for run in runs[runs["status"] == "ok"].to_dict("records"):
        window = run["window_end"] - run["window_start"]
        if window > 0.0:
            key = run["case_id"]
            rows = maps[maps["case_id"] == key].sort_values("facet_x")
            values = known.loc[key].to_dict()
            frames.append(_cells_of(rows, values, window, case_surface(setup, values)))
    return pd.concat(frames, ignore_index=True) if frames else _no_cells()


def _cells_of(rows: pd.DataFrame, values: Mapping, window: float, surface: Surface) -> pd.DataFrame:
    shape = shape_of(surface)
    centre = centres(shape.vertices, shape.triangles)
    normal = unit_normals(shape.vertices, shape.triangles)
    area = rows["cell_area"].to_numpy()
    per_joule = MM_PER_M * values["archard_constant"] / (area * window)
    return pd.DataFrame(
        {
            "case_id": rows["case_id"].to_numpy(),
            "cell": rows["facet_x"].to_numpy().astype(np.int64),
            "part_name": rows["part_name"].to_numpy(),
            **{axis: centre[:, k] for k, axis in enumerate("xyz")},
            **{f"normal_{axis}": normal[:, k] for k, axis in enumerate("xyz")},
            "cell_area": area,
            **{
                f"depth_rate_{measure}": per_joule * rows[f"wear_{measure}"].to_numpy()
                for measure in WEAR_MEASURES
            },
            **{name: rows[name].to_numpy() for name in SUMS},
        }
    )


def _no_cells() -> pd.DataFrame:
    floats = (
        "x", "y", "z", "normal_x", "normal_y", "normal_z", "cell_area",
        *(f"depth_rate_{measure}" for measure in WEAR_MEASURES), *SUMS,
    )  # fmt: skip
    kinds = {"case_id": "int64", "cell": "int64", "part_name": "str"}
    names = [*kinds, *floats]
    return pd.DataFrame({name: pd.Series(dtype=kinds.get(name, "float64")) for name in names})


def part_table(cells: pd.DataFrame, footprint_share: float = 0.95) -> pd.DataFrame:
    """Return the wear rates of every named part of every case.

    Parameters
    ----------
    cells : pandas.DataFrame
        From `cell_table`.
    footprint_share : float
        Share of the wear in a footprint.

    Returns
    -------
    pandas.DataFrame
        case_id, part_name, area (m2), ``wear_<measure>_<statistic>`` (mm/s): the mean over the
        part in the window and the statistics over its cells, weighted by their areas; impacts in
        the window.
    """
    rows = []
    for (case, part), group in cells.groupby(["case_id", "part_name"], sort=False):
        area = group["cell_area"].to_numpy()
        row = {"case_id": case, "part_name": part, "area": float(area.sum())}
        for measure in WEAR_MEASURES:
            worn = group[f"depth_rate_{measure}"].to_numpy() * area
            found = {
                "mean": float(worn.sum() / area.sum()),
                **element_rates(worn, area, 1.0, footprint_share),
            }
            row |= {wear_column(measure, name): found[name] for name in STATISTICS}
        rows.append({**row, "impacts": float(group["impacts"].sum())})
    names = [wear_column(measure, name) for measure in WEAR_MEASURES for name in STATISTICS]
    columns = ["case_id", "part_name", "area", *names, "impacts"]
    kinds = {"case_id": "int64", "part_name": "str"}
    return pd.DataFrame(rows, columns=columns).astype(
        {name: kinds.get(name, "float64") for name in columns}
    )
