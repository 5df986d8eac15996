"""The genetic search: fitness and network size over the generations, and retrained networks."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.words.labels import PROTOCOLS

LOWEST = -0.5
_FITNESS = {
    AS_PUBLISHED: "Fitness: $R^2$ on the test rows",
    LEAKAGE_FREE: "Fitness: $R^2$ on validation rows",
}


def draw(
    history: Iterable[pd.DataFrame], scores: Iterable[pd.DataFrame], summaries: Iterable[dict]
) -> Figure:
    """Draw `search_figure` from the tables and summaries of both protocols."""
    found, scored = (pd.concat(parts, ignore_index=True) for parts in (history, scores))
    return search_figure(found, scored, {summary["protocol"]: summary for summary in summaries})


def search_figure(history: pd.DataFrame, scores: pd.DataFrame, summaries: dict) -> Figure:
    """Fitness by generation, size of the networks, and scores of retrained networks.

    Parameters
    ----------
    history : pandas.DataFrame
        History of both protocols; the first search of each is shown.
    scores : pandas.DataFrame
        Scores of the networks.
    summaries : dict
        By protocol, see `abradem.learning.baselines.ga_ann.fit_networks`.
    """
    history = history[history["repeat"] == 0]
    protocols = [name for name in (AS_PUBLISHED, LEAKAGE_FREE) if name in summaries]
    with style.style():
        figure, axes = style.panels(4, 2, 2.2)
        lows = [
            history.loc[history["protocol"] == name, "fitness"].quantile(0.03) for name in protocols
        ]
        low = max(float(min(lows)) - 0.05, LOWEST)
        for index, protocol in enumerate(protocols):
            rows = history[history["protocol"] == protocol]
            _fitness_panel(axes[index], index, rows, summaries[protocol], low)
        _size_panel(axes[2], summaries, protocols)
        _retrained_panel(axes[3], scores, protocols)
        figure.legend(handles=_handles(protocols), loc="outside upper center", ncols=5)
        style.caption(
            figure,
            "(a, b) networks below the axis are drawn at its edge. (d) GA-ANN: network found; "
            "paper: 449-24-500-385. The fitness of the search and the final score belong to "
            "different trainings of the network, and in the leakage-free search to different rows "
            "(validation, test), so they differ; as published the final score is the best result "
            "on the test rows, leakage-free it is that of the first training",
        )
    return figure


def _handles(protocols) -> list:
    return [
        *(Patch(color=style.PROTOCOL_COLOURS[name], label=PROTOCOLS[name]) for name in protocols),
        Line2D([], [], marker="o", ms=3.0, color=style.GREY, alpha=0.5, ls="", mew=0,
               label="one network"),
        Line2D([], [], color=style.GREY, ls="--", label="median"),
        Line2D([], [], color=style.BLACK, drawstyle="steps-post", label="best"),
        Line2D([], [], marker="o", ms=3.2, mfc="none", mew=0.8, color=style.BLACK, ls="",
               label="lineage of the best"),
        Line2D([], [], marker="x", ms=5.0, mew=1.2, color=style.BLACK, ls="",
               label="(d) fitness of the search"),
        Line2D([], [], marker="D", ms=4.0, mew=1.2, mfc="none", color=style.BLACK, ls="",
               label="(d) final score, test rows"),
        Line2D([], [], marker="o", ms=2.8, color=style.GREY, alpha=0.5, ls="", mew=0,
               label="(d) trained again, test rows"),
    ]  # fmt: skip


def _fitness_panel(panel, index, rows, summary, low) -> None:
    protocol = summary["protocol"]
    colour = style.PROTOCOL_COLOURS[protocol]
    panel.scatter(
        rows["generation"] + 1, rows["fitness"].clip(lower=low), s=6, color=colour, alpha=0.35, lw=0
    )
    found = pd.DataFrame(summary["generations"])
    place = found["generation"] + 1
    panel.step(place, found["best_fitness"].clip(lower=low), where="post", color=style.BLACK)
    panel.plot(place, found["median_fitness"].clip(lower=low), ls="--", color=colour)
    descent = pd.DataFrame(summary["lineage"])
    panel.plot(
        descent["generation"] + 1, descent["fitness"].clip(lower=low), "o", ms=3.2, mfc="none",
        mew=0.8, color=style.BLACK,
    )  # fmt: skip
    panel.set_ylim(low - 0.04 * (1.0 - low), 1.0 + 0.02 * (1.0 - low))
    panel.set_xlabel("Generation")
    panel.xaxis.get_major_locator().set_params(integer=True)
    panel.set_ylabel(_FITNESS[protocol])
    layers = "-".join(map(str, summary["architecture"]))
    panel.set_title(
        f"{style.letter(index)} {PROTOCOLS[protocol]}: {layers}", loc="left", fontsize=7.0
    )


def _size_panel(panel, summaries, protocols) -> None:
    for protocol in protocols:
        found = pd.DataFrame(summaries[protocol]["generations"])
        place, colour = found["generation"] + 1, style.PROTOCOL_COLOURS[protocol]
        panel.fill_between(
            place, found["fewest_parameters"], found["most_parameters"], color=colour, alpha=0.15,
            lw=0,
        )  # fmt: skip
        panel.plot(place, found["median_parameters"], color=colour)
    panel.set_yscale("log")
    panel.set_xlabel("Generation")
    panel.xaxis.get_major_locator().set_params(integer=True)
    panel.set_ylabel("Weights and biases")
    panel.set_title(
        f"{style.letter(2)} size of the networks: median and range", loc="left", fontsize=7.0
    )


def _retrained_panel(panel, scores, protocols) -> None:
    rows = scores[scores["metric"] == "R2"]
    ticks: list[str] = []
    values: list[float] = []
    for protocol in protocols:
        for model in ("ga_ann", "paper_net"):
            mine = rows[(rows["protocol"] == protocol) & (rows["model"] == model)]
            by_split = {name: part["value"].to_numpy() for name, part in mine.groupby("split")}
            place, colour = len(ticks), style.PROTOCOL_COLOURS[protocol]
            again = by_split.get("retrained", np.empty(0))
            spread = (
                np.linspace(-0.18, 0.18, len(again)) if len(again) > 1 else np.zeros(len(again))
            )
            panel.plot(place + spread, again, "o", ms=2.8, color=colour, alpha=0.5, mew=0)
            for split, marker, size in (("test", "D", 4.0), ("search", "x", 5.0)):
                if split in by_split:
                    panel.plot(
                        place, by_split[split][0], marker, ms=size, mew=1.2, color=style.BLACK,
                        mfc="none",
                    )  # fmt: skip
                    values.append(by_split[split][0])
            values += list(again)
            name = "GA-ANN" if model == "ga_ann" else "paper"
            ticks.append(f"{name}\n{PROTOCOLS[protocol]}")
    panel.set_xticks(range(len(ticks)), ticks, fontsize=6.5)
    panel.set_xlim(-0.5, len(ticks) - 0.5)
    finite = [value for value in values if np.isfinite(value)]
    low, high = (min(finite), max(finite)) if finite else (0.0, 1.0)
    pad = 0.1 * (high - low) + 0.01
    panel.set_ylim(max(low, -2.0) - pad, high + pad)
    panel.set_ylabel("$R^2$")
    panel.set_title(f"{style.letter(3)} the networks trained again", loc="left", fontsize=7.0)
