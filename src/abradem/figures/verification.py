"""Figures of the verification study: results of this engine, closed forms and references."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

from abradem.figures import style
from abradem.figures.chute_verification import chute_figure

_EXACT = {"color": style.BLACK, "ls": "--", "lw": 0.9, "label": "exact", "zorder": 3}
_SMALL = {"ms": 2.5, "lw": 0.8}


def _finish(figure: Figure, panels, caption: str, legend_of=None) -> Figure:
    if len(panels) > 1:
        for index, panel in enumerate(panels):
            panel.set_title(f"{style.letter(index)} {panel.get_title(loc='left')}", loc="left")
    shown = panels if legend_of is None else [legend_of]
    handles: dict[str, Any] = {}
    for panel in shown:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    if handles:
        figure.legend(
            list(handles.values()), list(handles), loc="outside upper center",
            ncols=min(len(handles), 4 if figure.get_figwidth() > style.COLUMN + 0.1 else 2),
        )  # fmt: skip
    style.write_below(figure, caption)
    return figure


def restitution_figure(restitution: pd.DataFrame) -> Figure:
    """Damping and rebound against the restitution e for the three normal laws."""
    with style.style():
        figure, (left, right) = style.panels(2, 2, 2.2)
        e = restitution["restitution"]
        left.plot(e, restitution["exact_beta"], color=style.BLUE, label="exact restitution")
        left.plot(e, restitution["nominal_beta"], color=style.RED, label="textbook")
        left.set_title("damping", loc="left")
        left.set_xlabel("Restitution $e$")
        left.set_ylabel(r"$\beta$")
        for name, words, colour, marker in (
            ("exact", "exact restitution", style.BLUE, "o"),
            ("clipped", "textbook, not attractive", style.GREEN, "s"),
            ("attractive", "textbook, attractive", style.PURPLE, "^"),
        ):
            right.plot(
                e, restitution[f"rebound_{name}"], marker, color=colour, label=words, **_SMALL
            )
        right.plot([0, 1], [0, 1], **_EXACT)
        right.set_title("rebound of a normal impact", loc="left")
        right.set_xlabel("Restitution $e$")
        right.set_ylabel("Rebound / approach speed")
        for panel in (left, right):
            panel.set_xlim(0, 1)
            panel.set_ylim(0, None)
        return _finish(figure, (left, right), "converged single impacts, 500 steps per contact")


def slip_figure(angles: pd.DataFrame) -> Figure:
    """Elastic impacts against the angle, with the closed form for slip throughout."""
    labels = {
        "total": r"total / $m v^2$", "tangential": "$v_t'$ / $v$", "spin": r"$\omega' R$ / $v$",
    }  # fmt: skip
    with style.style():
        figure, panels = style.panels(3, 3, 2.0)
        for panel, (quantity, words) in zip(panels, labels.items(), strict=True):
            part = angles[angles["quantity"] == quantity]
            for colour, (mu, one) in zip(
                style.PALETTE, part.groupby("static_friction"), strict=False
            ):
                panel.plot(one["angle"], one["ours"], "o", color=colour, label=f"µ = {mu:g}",
                           **_SMALL)  # fmt: skip
                panel.plot(one["angle"], one["exact"], **_EXACT)
            panel.set_xlabel("Angle from the normal (°)")
            panel.set_ylabel(words)
            panel.set_xlim(0, 90)
            panel.set_title(quantity, loc="left")
        return _finish(figure, panels, "e = 1; dashed: closed form for slip throughout the impact")


def convergence_figure(convergence: pd.DataFrame) -> Figure:
    """Mean absolute error of each wear measure against the number of steps per contact."""
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.6, style.COLUMN)
        absolute = convergence.assign(error=convergence["error"].abs())
        for colour, (measure, part) in zip(
            style.PALETTE, absolute.groupby("measure", sort=False), strict=False
        ):
            mean = part.groupby("steps")["error"].mean()
            panel.loglog(mean.index, mean, "o-", color=colour, label=measure, **_SMALL)
        steps = np.array([16.0, 256.0])
        panel.loglog(steps, 0.01 * (16.0 / steps), color=style.GREY, lw=0.7, ls=":",
                     label="first order")  # fmt: skip
        panel.set_xlabel("Steps per contact")
        panel.set_ylabel("Mean error / mean of the measure")
        panel.set_title("convergence", loc="left")
        return _finish(
            figure, [panel], "e = 0.2, 0.5, 0.8 and four angles, mean over the phase of entry"
        )


_AXES = {
    "1": "Time / contact duration", "2": "", "3": "Restitution $e$",
    "4": "Impact angle (°)", "5": r"$v_t$ / ($\mu v_n$)", "6": "Initial spin (rad/s)",
    "7": "Initial spin (rad/s)", "8": "Initial spin (rad/s)",
}  # fmt: skip
_WORDS = {
    "force over time": "Force / exact maximum", "force": "Maximum force (N)",
    "duration": "Duration (s)", "rebound": "Rebound / approach speed", "velocity":
    "Final tangential velocity (m/s)", "spin": "Final spin (rad/s)",
    "tangential restitution": "$v_t'$ / $v_t$", "rebound angle": "Rebound angle (°)",
}  # fmt: skip


def chung_ooi_figure(tests: pd.DataFrame, measured: pd.DataFrame, number: str) -> Figure:
    """One of the eight tests: results by material, the exact branch, and the experiment."""
    with style.style():
        part = tests[tests["test"].str.split().str[0] == number]
        quantities = list(dict.fromkeys(part["quantity"]))
        count = len(quantities)
        width = style.COLUMN if count == 1 else style.PAGE
        figure, panels = style.panels(count, min(count, 3), 2.2, width)
        for panel, quantity in zip(panels, quantities, strict=True):
            rows = part[part["quantity"] == quantity]
            for colour, marker, (test, one) in zip(
                (style.BLUE, style.RED, style.GREEN),
                ("o", "s", "^"),
                rows.groupby("test", sort=False),
                strict=False,
            ):
                material = test.partition(" ")[2] or "abradem"
                if number == "2":
                    panel.bar(material, one["ours"].iloc[0], color=colour, width=0.5)
                    panel.hlines(one["exact"], *_slot(panel), color=style.BLACK, ls="--",
                                 lw=0.9, label="exact")  # fmt: skip
                    continue
                # Later series have hollow markers, so that coinciding points remain visible.
                hollow = {"mfc": "none", "ms": 4.0} if marker != "o" else {}
                panel.plot(one["value"], one["ours"], marker, color=colour, label=material,
                           **(_SMALL | hollow))  # fmt: skip
                panel.plot(one["value"], one["exact"], **_EXACT)
            points = measured[(measured["test"] == number) & (measured["quantity"] == quantity)]
            if len(points):
                panel.plot(points["angle"], points["value"], "x", color=style.BLACK, ms=4,
                           label=points["source"].iloc[0])  # fmt: skip
            panel.set_title(quantity, loc="left")
            panel.set_xlabel(_AXES[number])
            words = _WORDS[quantity]
            if number == "5":
                words = r"Final surface velocity / ($\mu v_n$)"
            panel.set_ylabel(words)
        return _finish(
            figure, panels, f"test {number} of Chung & Ooi (2011); dashed: exact branch"
            + ("; experiment: Kharaz et al. (2001)" if number == "4" else "")
        )  # fmt: skip


def _slot(panel) -> tuple[float, float]:
    place = len(panel.patches) - 1
    return place - 0.35, place + 0.35


def codes_figure(impacts: pd.DataFrame) -> Figure:
    """Other codes as points, this engine with the same options as lines: total, spin and v_t'."""
    shown = {"total": "total (J)", "spin": "Spin (rad/s)", "tangential_velocity": "$v_t'$ (m/s)"}
    with style.style():
        figure, panels = style.panels(3, 3, 2.4)
        half = impacts[impacts["restitution"] == 0.5]
        groups = list(half.groupby(["code", "variant"], sort=False))
        markers = "os^vDPX*<>"
        for panel, (quantity, words) in zip(panels, shown.items(), strict=True):
            for index, ((code, variant), part) in enumerate(groups):
                one = part[part["quantity"] == quantity].sort_values("angle")
                colour = style.PALETTE[index % len(style.PALETTE)]
                panel.plot(one["angle"], one["ours"], color=colour, lw=0.8)
                panel.plot(one["angle"], one["reference"], markers[index % len(markers)],
                           color=colour, label=f"{code}: {variant}", ms=2.8)  # fmt: skip
            panel.set_xlabel("Angle from the normal (°)")
            panel.set_ylabel(words)
            panel.set_title(quantity.replace("_", " "), loc="left")
        handles, labels = panels[0].get_legend_handles_labels()
        for index, panel in enumerate(panels):
            panel.set_title(f"{style.letter(index)} {panel.get_title(loc='left')}", loc="left")
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
        style.write_below(
            figure, "e = 0.5, µ = 0.45, 3.9 m/s; lines: abradem with the same options"
        )
        return figure


def forces_figure(forces: pd.DataFrame) -> Figure:
    """Tangential force against time: other codes as points, this engine as lines."""
    with style.style():
        groups = list(forces.groupby(["code", "variant", "angle"], sort=False))
        figure, panels = style.panels(len(groups), 4, 1.75)
        for panel, ((code, variant, angle), part) in zip(panels, groups, strict=True):
            time = 1e6 * part["time"]
            panel.plot(time, part["our_tangential"], color=style.BLUE, label="abradem")
            panel.plot(time, part["their_tangential"], color=style.RED, ls="--", lw=0.8,
                       label="law with the choices of the other code")  # fmt: skip
            panel.plot(time, part["tangential_force"], ".", color=style.BLACK, ms=2,
                       label="other code")  # fmt: skip
            low, high = panel.get_ylim()
            panel.set_ylim(low - 0.3 * (high - low), high)
            panel.text(0.98, 0.04, variant.replace(", ", "\n"), transform=panel.transAxes,
                       fontsize=5.5, ha="right", va="bottom", color=style.GREY)  # fmt: skip
            panel.set_title(f"{code.split()[0]}, {angle:g}°", loc="left")
            panel.set_xlabel("Time (µs)")
            panel.set_ylabel("$F_t$ (N)")
        return _finish(figure, panels, "e = 0.5, µ = 0.45, 3.9 m/s, same options")


def jets_figure(jets: pd.DataFrame) -> Figure:
    """Impulse of whole jets on the plate: difference from other codes."""
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.0)
        names = (jets["code"].str.split().str[0] + ": " + jets["variant"]).unique()
        for shift, colour, (quantity, part) in zip(
            (-0.1, 0.1), style.PALETTE, jets.groupby("quantity", sort=False), strict=False
        ):
            difference = 100.0 * (part["ours"] / part["reference"] - 1.0)
            panel.errorbar(
                difference, np.arange(len(part)) + shift, xerr=200.0 * part["bias_stderr"],
                fmt="o", color=colour, label=quantity.replace("_", " "), **_SMALL,
            )  # fmt: skip
        panel.axvspan(-1.5, 1.5, color=style.LIGHT_GREY, lw=0, zorder=0)
        panel.set_yticks(range(len(names)), names)
        panel.invert_yaxis()
        panel.set_xlabel("Difference of abradem from the other code (%)")
        panel.set_title("impulse of a jet on the plate", loc="left")
        return _finish(
            figure,
            [panel],
            "80 particles, plate at 40°; bars: twice the spread of perturbed jets; grey: ±1.5 %",
        )


def time_step_figure(mean: pd.DataFrame, jets: pd.DataFrame) -> Figure:
    """Bias of the wear measures against the time step, for single impacts and jets."""
    with style.style():
        figure, panels = style.panels(3, 3, 2.3)
        left, middle, right = panels
        # Longer steps, which show where the method fails, would dominate the axes.
        mean, jets = (frame[frame["fraction"] <= 0.2] for frame in (mean, jets))
        total = mean[mean["measure"] == "total"]
        for colour, (e, part) in zip(style.PALETTE, total.groupby("restitution"), strict=False):
            for ls, (speed, one) in zip(("-", ":"), part.groupby("speed"), strict=False):
                one = one.sort_values("fraction")
                left.plot(one["fraction"], 100.0 * one["bias"], marker="o", ls=ls, color=colour,
                          label=f"e = {e:g}, {speed:g} m/s", **_SMALL)  # fmt: skip
        total = jets[jets["measure"] == "total"]
        for colour, (angle, one) in zip(
            (*style.PALETTE[3:6], style.GREY, style.BLACK),
            total.groupby("plate_angle", dropna=False),
            strict=False,
        ):
            one = one.sort_values("fraction")
            words = "all four plates" if np.isnan(angle) else f"plate {angle:g}°"
            middle.errorbar(one["fraction"], 100.0 * one["bias"], 100.0 * one["bias_stderr"],
                            color=colour, marker="s", label=words, **_SMALL)  # fmt: skip
        others = mean[mean["measure"] != "total"]
        for ls, (measure, part) in zip(("-", "--"), others.groupby("measure"), strict=True):
            worst = part.assign(bias=part["bias"].abs()).groupby("fraction")["bias"].max()
            right.plot(worst.index, 100.0 * worst, color=style.GREY, ls=ls, marker="^",
                       label=measure, **_SMALL)  # fmt: skip
        left.set_title("total, single impacts", loc="left")
        middle.set_title("total, jets", loc="left")
        right.set_title("other wear measures, maximum", loc="left")
        for panel in panels:
            panel.axhspan(-1.0, 1.0, color=style.LIGHT_GREY, lw=0, zorder=0)
            panel.set_xlabel("Time step / Rayleigh time")
            panel.set_ylabel("Bias (%)")
        return _finish(
            figure, panels, "grey: ±1 %; single impacts: all phases of entry, summed over angles"
        )


def coverage_figure(replicates: pd.DataFrame) -> Figure:
    """Rates of replicates with their intervals, and those that miss the mean."""
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.2, style.PAGE)
        ordered = replicates.sort_values("value").reset_index(drop=True)
        for held, colour in ((1.0, style.BLUE), (0.0, style.RED)):
            one = ordered[ordered["covered"] == held]
            panel.errorbar(
                one.index, one["value"], 2.093 * one["relative_stderr"], fmt=".",
                color=colour, ms=2, lw=0.5,
                label=f"interval {'contains' if held else 'misses'} the mean ({len(one)})",
            )  # fmt: skip
        panel.axhline(1.0, color=style.BLACK, lw=0.7)
        panel.set_xlabel("Replicate, sorted by rate")
        panel.set_ylabel("Rate / mean rate of the case")
        panel.set_title("95 % intervals of batch means", loc="left")
        return _finish(figure, [panel], "twelve jets; replicates differ in the seed")


_SHOWN_ANGLES = (0.0, 10.0, 20.0, 30.0, 45.0)


def steady_figure(rates: pd.DataFrame, series: pd.DataFrame) -> Figure:
    """Wear depth against time, and its slope against plate angle and factory angle."""
    with style.style():
        figure, panels = style.panels(3, 3, 2.3)
        first = series[series["scene"] == series["scene"].iloc[0]]
        power = style.decade(first["depth"].max())
        shown = [angle for angle in first["plate_angle"].unique() if angle in _SHOWN_ANGLES]
        for colour, angle in zip(style.PALETTE, shown, strict=False):
            one = first[first["plate_angle"] == angle]
            panels[0].plot(one["time"], one["depth"] / 10.0**power, lw=0.9, color=colour)
            panels[0].annotate(f" {angle:g}°", (one["time"].iloc[-1],
                               one["depth"].iloc[-1] / 10.0**power), fontsize=6,
                               va="center", color=colour)  # fmt: skip
        panels[0].set_xlabel("Time (s)")
        panels[0].set_ylabel(f"Mean depth ({style.scaled_unit(power, 'mm')})")
        panels[0].set_title("plate angles", loc="left")
        power = style.decade(rates["depth_rate"].max())
        plate = rates[rates["scene"].str.startswith("plate")]
        for colour, (factory, one) in zip(
            (style.BLUE, style.RED), plate.groupby("factory_angle"), strict=False
        ):
            panels[1].errorbar(
                one["plate_angle"], one["depth_rate"] / 10.0**power,
                one["depth_stderr"] / 10.0**power, color=colour, marker="o",
                label=style.minus(f"factory {factory:+g}°"), **_SMALL,
            )  # fmt: skip
        panels[1].set_xlabel("Plate angle (°)")
        one = rates[rates["scene"].str.startswith("factory")]
        panels[2].errorbar(
            one["factory_angle"], one["depth_rate"] / 10.0**power,
            one["depth_stderr"] / 10.0**power, color=style.GREEN, marker="o", label="plate 45°",
            **_SMALL,
        )  # fmt: skip
        panels[2].set_xlabel("Factory angle (°)")
        for panel, words in zip(panels[1:], ("plate varied", "factory varied"), strict=True):
            panel.set_ylabel(f"Depth rate ({style.scaled_unit(power, 'mm/s')})")
            panel.set_ylim(0, None)
            panel.set_title(words, loc="left")
        return _finish(
            figure, panels, "particles released at rest, $W = 10^{-10}$ 1/Pa; bars: standard error"
        )


def conveyor_figure(rates: pd.DataFrame) -> Figure:
    """Wear depth rates for the assumed loads, and the published order of magnitude."""
    with style.style():
        figure, (panel,) = style.panels(1, 1, 3.4, style.PAGE)
        panel.barh(rates["scene"], rates["depth_rate"], color=style.BLUE, height=0.6)
        panel.set_xscale("log")
        panel.axvline(1e-6, color=style.RED, ls="--", lw=0.9, label="published order of magnitude")
        panel.set_xlabel("Depth rate (mm/s)")
        panel.invert_yaxis()
        panel.set_title("screw conveyor", loc="left")
        return _finish(figure, [panel], "W = 1e-11 1/Pa; tests only the order of magnitude")


def trends_figure(measurements: pd.DataFrame, exponents: pd.DataFrame) -> Figure:
    """Wear against each quantity on logarithmic axes, with the expected slope."""
    with style.style():
        figure, panels = style.panels(len(exponents), 3, 1.9)
        for panel, row in zip(panels, exponents.to_dict("records"), strict=True):
            part = measurements[measurements["quantity"] == row["quantity"]]
            mean = part.groupby("factor")["value"].mean()
            panel.loglog(part["factor"], part["value"], ".", color=style.BLUE, ms=2)
            base = mean.iloc[0] * (mean.index / mean.index[0]) ** row["expected"]
            panel.loglog(mean.index, base, **(_EXACT | {"label": "expected slope"}))
            words = row["quantity"].replace("v^2 + 2 g H", "$v^2 + 2gH$")
            panel.set_title(words, loc="left", fontsize=7)
            speed = row["quantity"].startswith("speed with")
            panel.set_xlabel("Impact speed (m/s)" if speed else "Factor")
            per_mass = row["quantity"].startswith("speed")
            panel.set_ylabel("Wear (J/kg)" if per_mass else "Wear rate (W)")
            middle = float(np.sqrt(part["value"].min() * part["value"].max()))
            reach = max(2.0, 1.3 * float(np.sqrt(part["value"].max() / part["value"].min())))
            panel.set_ylim(middle / reach, middle * reach)
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 4.0, 8.0)))
                axis.set_major_formatter(ScalarFormatter())
                axis.set_minor_locator(NullLocator())
            panel.text(0.05, 0.88, f"{row['exponent']:.4f} ± {row['exponent_stderr']:.4f}",
                       transform=panel.transAxes, fontsize=7)  # fmt: skip
        return _finish(figure, panels, "points: replicates; number: fitted exponent")


def heap_figure(heap: pd.DataFrame) -> Figure:
    """Heap of particles on the plate: height against distance from the axis."""
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.2, style.COLUMN)
        panel.plot(1e3 * heap["x"], 1e3 * heap["height"], "o", color=style.BLUE, ms=3, alpha=0.5)
        panel.set_xlabel("Distance from the axis (mm)")
        panel.set_ylabel("Height (mm)")
        panel.set_title("heap on a level plate", loc="left")
        panel.set_ylim(0, None)
        return _finish(figure, [panel], "centres of the particles at rest")


def _chung_ooi(number: int):
    def figure(tests: pd.DataFrame, measured: pd.DataFrame) -> Figure:
        return chung_ooi_figure(tests, measured, str(number))

    return figure


FIGURES = {
    "restitution": restitution_figure,
    "slip": slip_figure,
    "convergence": convergence_figure,
    "codes": codes_figure,
    "codes_forces": forces_figure,
    "codes_jets": jets_figure,
    "time_step": time_step_figure,
    "coverage": coverage_figure,
    "steady_state": steady_figure,
    "conveyor": conveyor_figure,
    "trends": trends_figure,
    "heap": heap_figure,
    "chute": chute_figure,
    **{f"chung_ooi_{number}": _chung_ooi(number) for number in range(1, 9)},
}
"""Drawing functions by the name of the figure; the workflow defines the tables of each."""


def draw(tables: Iterable[pd.DataFrame], figure: str) -> Figure:
    """Draw the figure of `FIGURES` with this name from its tables."""
    return FIGURES[figure](*tables)
