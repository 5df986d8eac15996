"""Architecture of the networks found by the genetic search."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.quantities import TARGET
from abradem.words.labels import LABELS, PROTOCOLS

_MOST_DRAWN = 11
"""Number of neurons drawn for the largest layer."""


def draw(summaries: Iterable[Mapping]) -> Figure:
    """Draw `architecture_figure` from the summaries of both protocols."""
    return architecture_figure({summary["protocol"]: summary for summary in summaries})


def architecture_figure(summaries: Mapping[str, Mapping]) -> Figure:
    """Features, hidden layers and output of the network found under each protocol.

    Parameters
    ----------
    summaries : mapping
        By protocol, see `abradem.learning.baselines.ga_ann.fit_networks`: ``features`` and
        ``architecture`` are shown.

    Returns
    -------
    matplotlib.figure.Figure
        Only some neurons of each layer are drawn; the number above a layer is the actual one.
    """
    protocols = [name for name in (AS_PUBLISHED, LEAKAGE_FREE) if name in summaries]
    with style.style():
        figure, axes = style.panels(len(protocols), 2, 2.9)
        for index, (panel, protocol) in enumerate(zip(axes, protocols, strict=True)):
            _network(panel, summaries[protocol], style.PROTOCOL_COLOURS[protocol])
            layers = "-".join(map(str, summaries[protocol]["architecture"]))
            panel.set_title(
                f"{style.letter(index)} {PROTOCOLS[protocol]}: {layers}", loc="left", fontsize=7.5
            )
        style.caption(
            figure,
            "fully connected layers of rectified linear units; numbers: neurons in each layer; "
            "only some of the neurons and connections are drawn",
        )
    return figure


def _network(panel, summary, colour) -> None:
    features, layers = summary["features"], summary["architecture"]
    largest = max(layers)
    drawn = [
        len(features),
        *(max(3, round(_MOST_DRAWN * (size / largest) ** 0.5)) for size in layers),
        1,
    ]
    drawn = [drawn[0], *(min(n, size) for n, size in zip(drawn[1:-1], layers, strict=True)), 1]
    places = [
        np.column_stack([np.full(count, float(x)), np.linspace(-1.0, 1.0, count) * _spread(count)])
        for x, count in enumerate(drawn)
    ]
    for left, right in itertools.pairwise(places):
        lines = [(a, b) for a in left for b in right]
        panel.add_collection(
            LineCollection(lines, colors=style.GREY, linewidths=0.25, alpha=0.35, zorder=1)
        )
    for column, points in enumerate(places):
        inner = 0 < column < len(places) - 1
        panel.scatter(
            points[:, 0], points[:, 1], s=20, zorder=2, lw=0.6,
            facecolor=colour if inner else "white", edgecolor="white" if inner else style.BLACK,
        )  # fmt: skip
    for (_, y), name in zip(places[0][::-1], features, strict=True):
        panel.text(-0.18, y, f"${LABELS[name].tex}$", ha="right", va="center", fontsize=7.0)
    for x, size in enumerate(layers, start=1):
        panel.text(x, 1.13, str(size), ha="center", va="bottom", fontsize=7.0)
    panel.text(0, 1.13, str(len(features)), ha="center", va="bottom", fontsize=7.0)
    panel.text(len(places) - 0.82, 0.0, f"${LABELS[TARGET.name].tex}$", va="center", fontsize=8.0)
    panel.set_xlim(-0.75, len(places) - 0.45)
    panel.set_ylim(-1.1, 1.32)
    panel.set_axis_off()


def _spread(count: int) -> float:
    """Half the height of a column of neurons; small for few neurons."""
    return 0.0 if count == 1 else min(1.0, 0.35 + 0.06 * count)
