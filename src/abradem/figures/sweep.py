"""Wear depth rate against the quantities of a sweep."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.quantities import quantity
from abradem.words.labels import LABELS

MOST_CURVES = 14
"""Curves that colours and dashes tell apart."""

LARGEST_RATIO = 30.0
"""Ratio of the largest to the smallest rate above which the axis is logarithmic."""

_DASHES = ("-", "--")


def curve_count(swept: Mapping[str, Sequence[float]]) -> int:
    """Return the number of curves of a sweep: the values of all quantities but the one along x."""
    along = _along(swept)
    return int(np.prod([len(values) for name, values in swept.items() if name != along] or [1]))


def sweep_figure(
    table: pd.DataFrame,
    swept: Mapping[str, Sequence[float]],
    rate: str,
    low: np.ndarray,
    high: np.ndarray,
    words: str,
    caption: str,
) -> Figure:
    """Wear depth rate against the quantity with the most values, a curve for each of the others.

    Parameters
    ----------
    table : pandas.DataFrame
        n rows: the quantities and ``rate``, which may be nan.
    swept : mapping of str to sequence of float
        The quantities with several values; of equally many values the first is along x.
    rate : str
        Column, mm/s.
    low, high : ndarray, shape (n,)
        Ends of the bars, mm/s.
    words : str
        What rate it is, for the axis.
    caption : str
        What the bars are, and what was held fixed.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there are more than `MOST_CURVES`.
    """
    count = curve_count(swept)
    if count > MOST_CURVES:
        raise ValueError(f"{count} curves are too many to tell apart (allowed {MOST_CURVES})")
    along = _along(swept)
    others = {name: values for name, values in swept.items() if name != along}
    rates = table[rate].to_numpy(dtype=float)
    with style.style():
        figure = style.new_figure(0.75 * style.PAGE, 3.0)
        panel = figure.subplots()
        known = np.isfinite(rates)
        if not known.any():
            style.say_nothing_to_show(panel, "no case has a wear rate")
            return figure
        power = style.decade(np.nanmax(high[known]) if np.isfinite(high[known]).any() else 0.0)
        unit = 10.0**power
        spread = rates[known].max() / rates[known].min() if rates[known].min() > 0.0 else 1.0
        log = bool(spread > LARGEST_RATIO)
        for place, values in enumerate(itertools.product(*others.values())):
            rows = known.copy()
            for name, value in zip(others, values, strict=True):
                rows &= table[name].to_numpy() == value
            x = _in_config_unit(along, table.loc[rows, along].to_numpy())
            y = rates[rows] / unit
            bars = np.abs(np.array([low[rows], high[rows]]) / unit - y)
            order = np.argsort(x)
            panel.errorbar(
                x[order], y[order], yerr=np.nan_to_num(bars[:, order]),
                color=style.PALETTE[place % len(style.PALETTE)],
                ls=_DASHES[place // len(style.PALETTE)], marker="o", ms=2.5, lw=1.0,
                elinewidth=0.7, capsize=1.5,
                label=", ".join(_value(name, value) for name, value in
                                zip(others, values, strict=True)),
            )  # fmt: skip
        if log:
            panel.set_yscale("log")
        else:
            panel.set_ylim(bottom=0.0)
        row = quantity(along)
        tex, long_name = LABELS[along]
        panel.set_xlabel(
            style.with_unit(f"{long_name[0].upper()}{long_name[1:]} ${tex}$", row.config_unit)
        )
        panel.set_ylabel(f"Wear depth rate ({style.scaled_unit(power, 'mm/s')})")
        panel.set_title(words, loc="left", fontsize=7.0)
        if others:
            figure.legend(loc="outside right upper", fontsize=6.5)
        style.write_below(figure, caption)
    return figure


def _along(swept: Mapping[str, Sequence[float]]) -> str:
    return max(swept, key=lambda name: len(swept[name]))


def _in_config_unit(name: str, values: np.ndarray) -> np.ndarray:
    return values / quantity(name).config_factor


def _value(name: str, value: float) -> str:
    row = quantity(name)
    unit = style.unit_text(row.config_unit)
    space = "" if unit in ("", "°") else " "
    shown = style.number(value / row.config_factor, 4)
    return f"${LABELS[name].tex}$ = {shown}{space}{unit}"
