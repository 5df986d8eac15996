"""Files of a simulated case: its map and its series, as a table or a picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from abradem.dem.model import Setup
from abradem.geometry.build import case_surface, prepared
from abradem.quantities import WEAR_MEASURES, wear_column
from abradem.store.columns import CELL_TABLE, COLUMNS, MAP_RATES, Column
from abradem.store.files import write_csv, write_text
from abradem.store.tables import write_table
from abradem.words.wear import WearTarget


def write_map(
    tables: Mapping, row: Mapping, setup: Mapping, target: WearTarget, path: Path, numbered: bool
) -> None:
    """Write the wear depth rate of every facet in the window, mm/s.

    Parameters
    ----------
    tables : mapping
        Of `abradem.simulation.batch.run_case`.
    row : mapping
        The case.
    setup : mapping
        Plain values of the `Setup`.
    target : WearTarget
        A picture shows its measure; a table holds all.
    path : Path
        .parquet, .csv, .png, .pdf or .svg.
    numbered : bool
        Whether the case has a number in a study, which a picture names.
    """
    from abradem.figures.maps import depth_rate_maps, wear_maps_figure

    given = tables["maps"], tables["runs"], pd.DataFrame([row]), Setup.from_dict(setup)
    shown = [row["case_id"]]
    if _is_picture(path):
        figure = wear_maps_figure(*depth_rate_maps(*given, shown, target.measure), target)
        _save(figure, row, path, numbered)
        return
    places = ["facet_x", "facet_z", "x", "z"]
    facets = {one: depth_rate_maps(*given, shown, one)[0] for one in WEAR_MEASURES}
    frame = facets[target.measure][places].assign(
        **{f"depth_rate_{one}": found["depth_rate"] for one, found in facets.items()}
    )
    write_with_units(frame, path, MAP_RATES)


def write_surface_map(
    tables: Mapping, row: Mapping, setup: Mapping, target: WearTarget, path: Path
) -> None:
    """Write the wear depth rate of every cell of a surface in the window, mm/s.

    Parameters
    ----------
    tables, row, setup, target
        As for `write_map`; the set-up has a geometry.
    path : Path
        .parquet, .csv, .vtp, .png, .pdf or .svg.
    """
    from abradem.wear.surface_cells import cell_table

    built = Setup.from_dict(setup)
    cells = cell_table(tables["maps"], tables["runs"], pd.DataFrame([row]), built)
    surface = case_surface(built, row)
    if path.suffix.lower() == ".vtp":
        from abradem.report.vtk import surface_vtp

        write_text(surface_vtp(surface, cells), path)
    elif _is_picture(path):
        from abradem.figures.style import save
        from abradem.figures.surface_map import surface_map_figure

        figure = surface_map_figure(surface, cells, target.measure)
        save(figure, path.with_suffix(""), [path.suffix.lower().removeprefix(".")])
    else:
        write_with_units(cells, path, CELL_TABLE)


def write_series(
    tables: Mapping, row: Mapping, setup: Mapping, target: WearTarget, path: Path, numbered: bool
) -> None:
    """Write the worn volume over time (table), or the wear depth of the plate (picture).

    Parameters
    ----------
    tables, row, setup, target, path, numbered
        As for `write_map`.
    """
    if not _is_picture(path):
        write_with_units(tables["series"], path)
        return
    from abradem.figures.series import depth_series, series_figure

    found = depth_series(
        tables["series"],
        tables["runs"],
        pd.DataFrame([row]),
        prepared(Setup.from_dict(setup), row),
        [row["case_id"]],
        target.measure,
    )
    # The series hold the wear of the whole plate alone.
    mean = WearTarget(wear_column(target.measure, "mean"))
    _save(series_figure(*found, mean), row, path, numbered)


def write_with_units(
    frame: pd.DataFrame, path: Path, extra: Mapping[str, Column] | None = None
) -> None:
    """Write a table as Parquet, with units in the metadata, or as CSV, with units in the header.

    Parameters
    ----------
    frame : pandas.DataFrame
    path : Path
        .csv, or any other name for Parquet.
    extra : mapping of str to Column, optional
        Columns that override those of `abradem.store.columns.COLUMNS`.
    """
    if path.suffix.lower() != ".csv":
        write_table(frame, path, extra)
        return
    write_csv(frame.rename(columns=unit_headers(frame, extra)), path)


def unit_headers(frame: pd.DataFrame, extra: Mapping[str, Column] | None = None) -> dict[str, str]:
    """Return the header with a unit in brackets for each column that has one."""
    known = {**COLUMNS, **(extra or {})}
    return {
        name: name if known[name].unit == "1" else f"{name} [{known[name].unit}]"
        for name in frame.columns
    }


def _is_picture(path: Path) -> bool:
    return path.suffix.lower() not in (".parquet", ".csv")


def _save(figure, row: Mapping, path: Path, numbered: bool) -> None:
    from abradem.figures.style import save, title_own_case

    if not numbered:
        title_own_case(figure.axes[0], row)
    save(figure, path.with_suffix(""), [path.suffix.lower().removeprefix(".")])
