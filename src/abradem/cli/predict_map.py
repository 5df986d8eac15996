"""`abradem predict --map`: the wear map of a case by the map surrogate of a study."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from abradem.quantities import wear_column
from abradem.surrogate.maps import STEM, MapSurrogate
from abradem.surrogate.model import PredictionError, Surrogate
from abradem.units import MM_PER_M

PICTURES, TABLES = (".png", ".pdf", ".svg"), (".parquet", ".csv")


def check_map_path(path: Path) -> None:
    """Raise `PredictionError` if the name is not that of a map, before anything is computed."""
    if path.suffix.lower() not in (*PICTURES, *TABLES):
        raise PredictionError(
            f"--map {path}: the name must end in one of {', '.join((*PICTURES, *TABLES))}"
        )


def predict_map(
    model: str | Path, surrogate: Surrogate, values: Mapping[str, float], path: Path
) -> str:
    """Write the predicted wear map of a case, and return a line on it.

    Parameters
    ----------
    model : path
        Stem of the surrogate; the map surrogate is in the same folder.
    surrogate : Surrogate
        If it predicts the mean over the plate, the map is scaled to it.
    values : mapping of str to float
        The sampled quantities, checked.
    path : Path
        .png, .pdf or .svg for a picture, .parquet or .csv for a table.

    Raises
    ------
    PredictionError
        If the map surrogate cannot be read.
    """
    found = MapSurrogate.load(Path(model).parent / f"{STEM}.json")
    measure = found.description["target"]["measure"]
    mean = wear_column(measure, "mean")
    level = surrogate.predict(values, target=mean).rate if mean in surrogate.models else None
    maps = found.predict(values, level)
    rate = maps.rate[0]
    if path.suffix.lower() in PICTURES:
        from abradem.figures.predicted_map import predicted_map_figure
        from abradem.figures.style import save

        plate = {side: MM_PER_M * size for side, size in found.description["plate"].items()}
        figure = predicted_map_figure(rate, plate, values, measure)
        save(figure, path.with_suffix(""), [path.suffix.lower().removeprefix(".")])
    else:
        import pandas as pd

        from abradem.cli.case_files import write_with_units
        from abradem.store.columns import PREDICTED_MAP

        x, z = (grid.ravel() for grid in np.meshgrid(maps.x, maps.z, indexing="ij"))
        frame = pd.DataFrame({"x": x, "z": z, "depth_rate": rate.ravel()})
        write_with_units(frame, path, PREDICTED_MAP)
    place, across = np.unravel_index(rate.argmax(), rate.shape)
    return (
        f"{path}: wear map ({measure}), mean {rate.mean():.4g} mm/s, worst element "
        f"{rate.max():.4g} mm/s at x = {maps.x[place]:.3g} mm, z = {abs(maps.z[across]):.3g} mm "
        "to either side"
    )
