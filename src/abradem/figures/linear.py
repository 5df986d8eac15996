"""Figures of the linear regression: coefficients, and predictions for held-out cases."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from abradem.dataset.variation import HELD_FIXED, NOT_IDENTIFIED, VARIED
from abradem.figures import style
from abradem.learning.number_text import is_number, score_number, score_range
from abradem.words.labels import LABELS, PROTOCOLS
from abradem.words.wear import WearTarget

LOG_SPAN = 30.0
"""Ratio of largest to smallest value above which axes are logarithmic."""


def coefficients_figure(
    coefficients: pd.DataFrame,
    model: dict,
    element_size: float | None = None,
    known: bool = True,
    cells: bool = False,
    part: str | None = None,
) -> Figure:
    """Standardised coefficients with intervals as bars: X1 to X10, X11 to X20.

    Parameters
    ----------
    coefficients : pandas.DataFrame
        From `abradem.learning.baselines.linear.fit_linear`.
    model : dict
        Summary of the model.
    element_size, known, cells, part
        Of the target, see `abradem.words.wear.WearTarget`.

    Returns
    -------
    matplotlib.figure.Figure
        The axis includes all bars. Intervals that exceed it end in an arrowhead, because nearly
        dependent features, such as E and G of one body, have very wide intervals.
    """
    with style.style():
        figure, axes = style.panels(2, 1, 2.2)
        half = (len(coefficients) + 1) // 2
        words = _target_words(model, element_size, known, cells, part)
        # Both panels have the same vertical axis.
        limit = _coefficient_limit(coefficients)
        parts = (coefficients.iloc[:half], coefficients.iloc[half:])
        for index, (panel, half_of) in enumerate(zip(axes, parts, strict=True)):
            _coefficient_panel(panel, half_of, limit)
            first, last = half_of["symbol"].iloc[0], half_of["symbol"].iloc[-1]
            panel.set_title(f"{style.letter(index)} {first} to {last}", loc="left")
            panel.set_ylabel("Standardised coefficient")
        handles: list = [*style.feature_handles()]
        if _clipped(coefficients, limit):
            handles.append(
                Line2D([], [], marker="^", ms=4.0, color=style.BLACK, lw=0.9,
                       label="interval, clipped at the axis")
            )  # fmt: skip
        figure.legend(handles=handles, loc="outside upper center", ncols=3)
        style.caption(figure, "; ".join(_coefficient_words(coefficients, model, limit, words)))
    return figure


def predicted_figure(
    predictions: pd.DataFrame,
    model: dict,
    element_size: float | None = None,
    known: bool = True,
    cells: bool = False,
    part: str | None = None,
) -> Figure:
    """Predicted against simulated wear of held-out cases, with the 1:1 line.

    Parameters
    ----------
    predictions : pandas.DataFrame
        protocol, case_id, repeat, actual, predicted (mm/s) of held-out rows; the rows of the
        protocol of the model are shown.
    model : dict
        Summary of the model.
    element_size, known, cells, part
        Of the target, see `abradem.words.wear.WearTarget`.

    Returns
    -------
    matplotlib.figure.Figure
        The axes are logarithmic if the wear spans decades and all predictions are positive.
    """
    with style.style():
        figure, (panel,) = style.panels(1, 1, 3.0, style.COLUMN)
        unit = model["target"]["unit"]
        predictions = predictions[predictions["protocol"] == model["protocol"]]
        actual = predictions["actual"].to_numpy(dtype=float)
        predicted = predictions["predicted"].to_numpy(dtype=float)
        low = min(actual.min(), predicted.min())
        high = max(actual.max(), predicted.max())
        logarithmic = low > 0.0 and high > LOG_SPAN * low
        power = 0 if logarithmic else style.decade(max(abs(low), abs(high)))
        scale = 10.0**power
        alpha = float(np.clip(8.0 / np.sqrt(len(actual)), 0.15, 0.9))
        panel.scatter(
            actual / scale, predicted / scale, s=9, color=style.BLUE, alpha=alpha, lw=0,
            rasterized=len(actual) > 5000,
        )  # fmt: skip
        if logarithmic:
            ends = (low / 1.2, high * 1.2)
            panel.set_xscale("log")
            panel.set_yscale("log")
            panel.set_xlim(ends)
        else:
            # Predictions of a constant differ in the last digits alone.
            pad = max(0.04 * (high - low), 1e-3 * max(abs(low), abs(high))) or 1.0
            ends = ((low - pad) / scale, (high + pad) / scale)
            panel.set_xlim(min(0.0, actual.min() / scale) - pad / scale, ends[1])
            span = ends[1] - ends[0]
            wide = panel.get_xlim()[1] - panel.get_xlim()[0]
            # Both axes have the same ticks, unless the wear is nearly constant.
            for axis, length in (
                (panel.xaxis, wide if wide > 10.0 * span else span), (panel.yaxis, span)
            ):  # fmt: skip
                axis.set_major_locator(MultipleLocator(_tick_step(length)))
            if low < 0.0:
                panel.axhline(0.0, color=style.GREY, lw=0.5, zorder=0)
        panel.set_ylim(ends)
        panel.plot(ends, ends, color=style.BLACK, ls="--", lw=0.9)
        at = np.sqrt(ends[0] * ends[1]) if logarithmic else 0.1 * ends[0] + 0.9 * ends[1]
        panel.annotate("1:1", (at, at), xytext=(4, -9), textcoords="offset points", fontsize=7.0)
        label = style.scaled_unit(power, unit)
        panel.set_xlabel(f"Simulated wear depth rate ({label})")
        panel.set_ylabel(f"Predicted wear depth rate ({label})")
        panel.set_title(_score_words(model), loc="left", fontsize=7.0)
        splits = model["splits"]
        style.caption(
            figure,
            f"{_target_words(model, element_size, known, cells, part)}; {model['model']} model, "
            f"{PROTOCOLS[model['protocol']]} protocol, {splits['rows']} cases; held-out cases of "
            f"{splits['repeats']} random splits ({splits['train']} train, {splits['test']} test), "
            "one fit per split",
        )
    return figure


def _coefficient_panel(panel, part: pd.DataFrame, limit: float) -> None:
    # A coefficient that the rows do not determine is arbitrary.
    values = part["coefficient"].where(part["variation"] == VARIED).to_numpy(dtype=float)
    lower, upper = (part[end].to_numpy(dtype=float) for end in ("lower", "upper"))
    places = np.arange(len(part))
    panel.bar(places, values, width=0.62, color=style.feature_colours(part["feature"]))
    panel.axhline(0.0, color=style.BLACK, lw=0.6)
    for place, low, high in zip(places, lower, upper, strict=True):
        if not np.isfinite(low + high):
            continue
        panel.vlines(place, max(low, -limit), min(high, limit), color=style.BLACK, lw=0.9)
        for end, beyond, marker in ((high, high > limit, "^"), (low, low < -limit, "v")):
            if beyond:
                edge = np.sign(end) * limit
                panel.plot(place, edge, marker, color=style.BLACK, ms=4, clip_on=False)
            else:
                panel.plot(place, end, "_", color=style.BLACK, ms=5, mew=0.9)
    panel.set_ylim(-limit, limit)
    panel.set_xlim(-0.6, len(part) - 0.4)
    panel.set_xticks(
        places,
        [
            f"{symbol}\n${LABELS[name].tex}$\n"
            + (style.minus(f"{value:+.2f}") if np.isfinite(value) else "")
            for symbol, name, value in zip(part["symbol"], part["feature"], values, strict=True)
        ],
    )
    panel.tick_params(axis="x", length=0)
    style.name_unvaried(panel, part["variation"], upright=True)


def _coefficient_limit(coefficients: pd.DataFrame) -> float:
    """Half the height of the axis: fits all bars, and intervals up to 1.5 times the longest bar."""
    known = coefficients[coefficients["variation"] == VARIED]
    bars = float(known["coefficient"].abs().max()) if len(known) else 0.0
    ends = known[["lower", "upper"]].abs().to_numpy(dtype=float)
    ends = ends[np.isfinite(ends)]
    most = max(1.15 * bars, 1.05 * min(ends.max(initial=0.0), 1.5 * bars))
    return most if most > 0.0 else 1.0


def _clipped(coefficients: pd.DataFrame, limit: float) -> bool:
    """Whether an interval extends beyond the axis."""
    ends = coefficients[["lower", "upper"]].to_numpy(dtype=float)
    return bool((np.abs(ends[np.isfinite(ends)]) > limit).any())


def _coefficient_words(
    coefficients: pd.DataFrame, model: dict, limit: float, target: str
) -> list[str]:
    share = 100.0 * model["confidence"]
    rows = model["splits"]["rows"]
    protocol = PROTOCOLS[model["protocol"]]
    first = f"{target}; protocol: {protocol}; least squares on all {rows} cases"
    ends = coefficients[["lower", "upper"]].to_numpy(dtype=float)
    if not np.isfinite(ends).any():
        free = int((coefficients["variation"] != HELD_FIXED).sum())
        return [first, f"{rows} cases do not determine {free} coefficients; no intervals"]
    second = f"numbers: coefficients; lines: {share:g} % intervals (HC3)"
    if _clipped(coefficients, limit):
        second += "; arrowheads: the interval is clipped at the end of the axis"
    if (coefficients["variation"] == NOT_IDENTIFIED).any():
        second += "; not identified: the cases do not tell these features apart"
    return [first, second]


def _target_words(model: dict, *place) -> str:
    words = WearTarget(model["target"]["name"], *place).explained
    return words[0].upper() + words[1:]


def _score_words(model: dict) -> str:
    """Held-out R2 and its interval as text."""
    score = model["scores"]["test"]["R2"]
    if not is_number(score["median"]):
        return "held-out $R^2$ is not determined"
    middle = style.minus(score_number(score["median"], 2))
    ends = style.minus(score_range((score["lower"], score["upper"]), 2))
    share = 100.0 * model["confidence"]
    return f"held-out $R^2$: {middle} (median of splits)\n{share:g} % of splits: {ends}"


def _tick_step(span: float) -> float:
    """Distance of ticks: 1, 2 or 5 times a power of ten, four to ten of them in the span."""
    power = 10.0 ** np.floor(np.log10(span / 4.0))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= span / 4.0))
