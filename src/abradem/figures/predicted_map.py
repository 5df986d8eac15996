"""The wear map that the map surrogate predicts for a case."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.figures.wear_colours import WEAR_MAP


def predicted_map_figure(
    rate: np.ndarray, plate: Mapping[str, float], row: Mapping, measure: str
) -> Figure:
    """Draw the predicted wear depth rate of the elements of a plate.

    Parameters
    ----------
    rate : ndarray, shape (nx, nz)
        mm/s.
    plate : mapping
        ``length`` and ``width``, mm.
    row : mapping
        The sampled quantities, for the title.
    measure : str
        Wear measure, for the caption.
    """
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.4, style.COLUMN)
        power = style.decade(rate.max())
        x, z = (np.linspace(-0.5, 0.5, count + 1) for count in rate.shape)
        mesh = panel.pcolormesh(
            plate["length"] * x,
            plate["width"] * z,
            rate.T / 10.0**power,
            cmap=WEAR_MAP,
            vmin=0.0,
            rasterized=True,
        )
        panel.set_aspect("equal")
        panel.spines[["top", "right"]].set_visible(True)
        panel.set_xlabel("Up the slope (mm)")
        panel.set_ylabel("Across (mm)")
        style.title_own_case(panel, row)
        bar = figure.colorbar(mesh, cax=panel.inset_axes([1.05, 0.0, 0.055, 1.0]))
        bar.outline.set_linewidth(0.6)
        bar.set_label(f"Depth rate ({style.scaled_unit(power, 'mm/s')})", fontsize=7.0)
        style.write_below(
            figure,
            f"Predicted by the map surrogate; wear measure: {measure}; without the scatter of a "
            "simulation.",
        )
    return figure
