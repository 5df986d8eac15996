"""Wear depth against time for several plate angles and factory angles."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.quantities import SAMPLED_NAMES
from abradem.words.labels import LABELS

SHADES = "viridis"
_ORDER = ("plate_angle", "factory_angle")


def angles_figure(
    curves: pd.DataFrame,
    rates: pd.DataFrame,
    case: Mapping[str, float],
    duration: float,
    measure: str,
) -> Figure:
    """Wear depth against time and its steady slope, for plate angles and for factory angles.

    Parameters
    ----------
    curves, rates : pandas.DataFrame
        From `abradem.wear.angles.depth_by_angle`.
    case : mapping
        Arguments of `abradem.Case`.
    duration : float
        Simulated time, s.
    measure : str
        Wear measure, named in the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Top: curves; bottom: slopes with standard errors.
    """
    with style.style():
        figure, axes = style.panels(4, 2, 2.1)
        depth_power = style.decade(float(curves["wear_depth"].max()))
        rate_power = style.decade(float(rates["rate"].max()))
        for column, varied in enumerate(_ORDER):
            _curves_panel(
                axes[column], column, curves[curves["varied"] == varied], varied, depth_power
            )
            _rates_panel(
                axes[2 + column], 2 + column, rates[rates["varied"] == varied], varied, rate_power
            )
        # The panels of a row share the vertical axis.
        for row in (axes[:2], axes[2:]):
            top = max(panel.get_ylim()[1] for panel in row)
            for panel in row:
                panel.set_ylim(0.0, top)
        symbol = {name: f"${LABELS[name].tex}$" for name in SAMPLED_NAMES}
        radius, speed = 1e3 * case["particle_radius"], case["particle_velocity_y"]
        style.caption(
            figure,
            f"wear measure: {measure}, mean over the plate; "
            f"{symbol['particle_radius']} = {radius:g} mm, "
            f"{symbol['particle_velocity_y']} = {style.number(speed)} m/s; unless varied, "
            f"{symbol['plate_angle']} = {style.number(case['plate_angle'])}° and "
            f"{symbol['factory_angle']} = {style.number(case['factory_angle'])}°; "
            "all other quantities in the middle of their ranges; "
            f"{duration:g} s simulated each; bars: standard error of the steady slope",
        )
    return figure


def _curves_panel(panel, index, curves, varied, power) -> None:
    angles = sorted(set(curves["angle"]))
    shades = mpl.colormaps[SHADES](np.linspace(0.0, 0.9, len(angles)))
    tex = LABELS[varied].tex
    most = 1e-300
    for shade, angle in zip(shades, angles, strict=True):
        rows = curves[curves["angle"] == angle]
        depth = rows["wear_depth"].to_numpy() / 10.0**power
        panel.plot(rows["time"], depth, color=shade, lw=1.2, label=f"{style.number(angle)}°")
        most = max(most, depth[-1])
    panel.set_xlim(0.0, curves["time"].max())
    panel.set_ylim(0.0, 1.08 * most)
    panel.set_xlabel("Time (s)")
    panel.set_ylabel(f"Wear depth ({style.scaled_unit(power, 'mm')})")
    panel.legend(title=f"${tex}$", loc="upper left", ncols=1 + len(angles) // 5, handlelength=1.4)
    panel.set_title(f"{style.letter(index)} {LABELS[varied].long_name}", loc="left")


def _rates_panel(panel, index, rates, varied, power) -> None:
    ordered = rates.sort_values("angle")
    panel.errorbar(
        ordered["angle"], ordered["rate"] / 10.0**power, ordered["rate_stderr"] / 10.0**power,
        fmt="o-", ms=3.0, lw=1.0, capsize=2.0, color=style.BLUE,
    )  # fmt: skip
    panel.set_ylim(0.0, 1.1 * max(float(ordered["rate"].max()) / 10.0**power, 1e-300))
    panel.set_xlabel(style.axis_label(varied))
    panel.set_ylabel(f"Wear depth rate ({style.scaled_unit(power, 'mm/s')})")
    panel.set_title(f"{style.letter(index)} steady slope", loc="left")
