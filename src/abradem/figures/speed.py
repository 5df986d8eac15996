"""Performance of the engine: cost of simulations, and when each particle is stepped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from abradem.figures import style

_CODES = {
    "islands": (style.BLUE, "o"),
    "synchronous": (style.ORANGE, "s"),
    "LIGGGHTS": (style.RED, "^"),
    "LAMMPS": (style.GREEN, "v"),
}
"""Colour and marker of each stepping method of this engine and of each other code."""

_MEANING = (
    "A, M, B: 500 particles of 10 mm per second on plates at 45°, 20°, 0°; "
    "D: 4 kg/s of 5 mm particles on a level plate; "
    "E, F: 42 kg/s of 10 mm particles on plates at 35°, 10°"
)
"""Definition of the scenarios."""

_SCENARIOS = (style.BLUE, style.GREEN, style.ORANGE, style.RED, style.PURPLE, style.SKY)


def _code_label(code: str) -> str:
    return f"abradem, {code}" if code in ("islands", "synchronous") else code


def cost_figure(counts: pd.DataFrame, times: pd.DataFrame) -> Figure:
    """Cost against the number of particles by code, and against simulated time by scenario.

    Parameters
    ----------
    counts : DataFrame
        ``plate_angle`` (deg), ``particles`` (mean number present), ``code``, ``cost`` (s per
        simulated second).
    times : DataFrame
        ``scenario``, ``simulated`` (s), ``spent`` (s).
    """
    with style.style():
        angles = sorted(counts["plate_angle"].unique(), reverse=True)
        figure, panels = style.panels(len(angles) + 1, len(angles) + 1, 2.3)
        for panel, angle in zip(panels, angles, strict=False):
            part = counts[counts["plate_angle"] == angle]
            for code, one in part.groupby("code", sort=False):
                colour, marker = _CODES[code]
                one = one.sort_values("particles")
                panel.loglog(one["particles"], one["cost"], f"{marker}-", color=colour, ms=3.0,
                             label=_code_label(code))  # fmt: skip
            panel.set_title(f"plate at {angle:.0f}°", loc="left")
            panel.set_xlabel("Particles present")
        low = min(panel.get_ylim()[0] for panel in panels[:-1])
        high = max(panel.get_ylim()[1] for panel in panels[:-1])
        for panel in panels[:-1]:
            panel.set_ylim(low, high)
        panels[0].set_ylabel("Cost (s per simulated s)")
        last = panels[-1]
        for colour, (name, one) in zip(
            _SCENARIOS, times.groupby("scenario", sort=False), strict=False
        ):
            one = one[one["spent"] > 0.0]
            last.loglog(one["simulated"], one["spent"], color=colour, label=name)
        last.set_title("scenarios (islands)", loc="left")
        last.set_xlabel("Simulated time (s)")
        last.set_ylabel("Computing time (s)")
        last.legend(title="scenario", title_fontsize=7.0, loc="upper left")
        for index, panel in enumerate(panels):
            panel.set_title(f"{style.letter(index)} {panel.get_title(loc='left')}", loc="left")
            panel.grid(True, which="major", color=style.LIGHT_GREY, lw=0.5)
            panel.xaxis.set_minor_formatter(NullFormatter())
            panel.yaxis.set_minor_formatter(NullFormatter())
        handles: dict[str, Any] = {}
        for panel in panels[:-1]:
            for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
                handles.setdefault(label, handle)
        figure.legend(
            list(handles.values()), list(handles), loc="outside upper center", ncols=len(handles)
        )
        style.caption(
            figure,
            "(a, b) 10 mm particles at 3 m/s, first second of jets of 30 to 3000 particles per "
            "second; abradem with wear, other codes without wear and only their run loop; one "
            f"core. (c) {_MEANING}",
        )
        return figure


def rates_figure(rates: pd.DataFrame) -> Figure:
    """Particle steps and contact steps per second, and share of the limit, by scenario.

    Parameters
    ----------
    rates : DataFrame
        ``scenario``, ``stepping``, ``particle_steps`` and ``contact_steps`` (1/s),
        ``share_of_limit``.
    """
    shown = (
        ("particle_steps", "particles", "Particle-steps per second", 1.0),
        ("contact_steps", "contacts", "Contact-steps per second", 1.0),
        ("share_of_limit", "share of the limit", "Share of the limit (%)", 100.0),
    )
    with style.style():
        figure, panels = style.panels(len(shown), len(shown), 2.1)
        scenarios = list(dict.fromkeys(rates["scenario"]))
        place = np.arange(len(scenarios))
        for index, (panel, (column, title, words, scale)) in enumerate(
            zip(panels, shown, strict=True)
        ):
            for shift, (stepping, one) in zip(
                (-0.12, 0.12), rates.groupby("stepping", sort=False), strict=False
            ):
                values = one.set_index("scenario")[column].reindex(scenarios) * scale
                colour, marker = _CODES[stepping]
                panel.plot(place + shift, values, marker, color=colour, ms=4.5,
                           label=_code_label(stepping))  # fmt: skip
            panel.set_yscale("log")
            if column == "share_of_limit":
                panel.axhline(100.0, color=style.BLACK, lw=0.8, ls="--")
            panel.set_xticks(place, scenarios)
            panel.set_xlim(-0.5, len(scenarios) - 0.5)
            panel.set_xlabel("Scenario")
            panel.set_ylabel(words)
            panel.set_title(f"{style.letter(index)} {title}", loc="left")
            panel.grid(True, axis="y", which="major", color=style.LIGHT_GREY, lw=0.5)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
        style.caption(
            figure,
            "limit: steps in contact only, each at its cost when nothing else is computed. "
            f"{_MEANING}",
        )
        return figure


_TOUCH = {
    "asleep": (style.SKY, 0.7, "asleep"),
    "plate": (style.BLUE, 4.0, "plate contact"),
    "particle": (style.RED, 4.0, "particle contact"),
}
"""Colour, line width and label of each state of a particle."""


def islands_figure(spans: pd.DataFrame, contacts: pd.DataFrame, zooms) -> Figure:
    """State of each particle of a small scene over time: asleep or in contact.

    Parameters
    ----------
    spans : DataFrame
        ``particle``, ``begin``, ``end`` (s), ``does`` (asleep, plate, particle): state of the
        particle from begin to end.
    contacts : DataFrame
        ``particle``, ``partner``, ``begin``, ``end`` (s): contacts between particles.
    zooms : sequence of tuple of float
        Begin and end (s) of each panel, each within the previous one.
    """
    with style.style():
        figure = style.new_figure(style.PAGE, 0.9 + 1.6 * len(zooms))
        panels = figure.subplots(len(zooms), 1, squeeze=False)[:, 0]
        for index, (panel, (begin, end)) in enumerate(zip(panels, zooms, strict=True)):
            # Contacts shorter than a point on the page are drawn with the length of a point.
            least = 1e3 * (end - begin) / (72.0 * style.PAGE)
            present = spans[(spans["begin"] < end) & (spans["end"] > begin)]
            count = int(present["particle"].max()) + 1
            for does, (colour, width, _) in _TOUCH.items():
                part = present[present["does"] == does]
                starts = 1e3 * part["begin"].to_numpy()
                ends = np.maximum(1e3 * part["end"].to_numpy(), starts + least)
                panel.hlines(part["particle"], starts, ends, colors=colour, linewidths=width)
            during = contacts[(contacts["begin"] < end) & (contacts["end"] > begin)]
            middle = 0.5e3 * (during["begin"].clip(begin) + during["end"].clip(upper=end))
            panel.vlines(
                middle, during["particle"], during["partner"], colors=style.RED, linewidths=0.6
            )
            panel.set_xlim(1e3 * begin, 1e3 * end)
            panel.set_ylim(count - 0.3, -0.7)
            panel.set_yticks(range(0, count, 1 if count <= 12 else 2))
            panel.set_ylabel("Particle")
            panel.set_title(style.letter(index), loc="left")
            if index + 1 < len(zooms):
                panel.axvspan(
                    1e3 * zooms[index + 1][0], 1e3 * zooms[index + 1][1],
                    color=style.LIGHT_GREY, lw=0.0, zorder=0,
                )  # fmt: skip
        panels[-1].set_xlabel("Time (ms)")
        handles = [
            Line2D([], [], color=colour, lw=width, label=words)
            for colour, width, words in _TOUCH.values()
        ]
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
        return figure
