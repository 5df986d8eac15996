"""The decision tree: scores against its depth, importance of features, and the pruned tree."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.words.labels import LABELS, PROTOCOLS

LOWEST = -1.5
DRAWN_DEPTH = 4
"""Number of levels drawn below the root; deeper branches end in an ellipsis."""


def tree_curve_figure(curve: pd.DataFrame, importance: pd.DataFrame, summary: dict) -> Figure:
    """R2 on training and test rows against the depth, and the importance of the features.

    Parameters
    ----------
    curve, importance : pandas.DataFrame
    summary : dict
        From `abradem.learning.baselines.trees.fit_trees`.
    """
    with style.style():
        figure, axes = style.panels(3, 3, 3.2)
        # Both protocols have the same vertical axis.
        low = float(np.nanmin([*curve["r2"], *curve["r2_lower"], 0.0]))
        for index, protocol in enumerate((AS_PUBLISHED, LEAKAGE_FREE)):
            panel = axes[index]
            rows = curve[curve["protocol"] == protocol]
            for split, line in (("train", "--"), ("test", "-")):
                part = rows[rows["split"] == split]
                panel.plot(part["depth"], part["r2"], line, color=style.PROTOCOL_COLOURS[protocol])
                if part["r2_lower"].notna().any():
                    panel.fill_between(
                        part["depth"], part["r2_lower"], part["r2_upper"],
                        color=style.PROTOCOL_COLOURS[protocol], alpha=0.15, lw=0,
                    )  # fmt: skip
            panel.set_ylim(max(low - 0.1, LOWEST), 1.08)
            panel.axhline(0.0, color=style.BLACK, lw=0.5)
            panel.set_xlim(0.0, rows["depth"].max() + 1)
            panel.set_xlabel("Maximum depth")
            panel.set_ylabel("$R^2$")
            panel.set_title(
                f"{style.letter(index)} tree, {PROTOCOLS[protocol]}", loc="left", fontsize=7.0
            )
        _importance_panel(axes[2], importance)
        figure.legend(
            handles=[
                Line2D([], [], color=style.BLACK, ls="--", label="training rows"),
                Line2D([], [], color=style.BLACK, label="test rows"),
            ],
            loc="outside upper left",
            ncols=2,
        )
        count = summary["published_splits_on_wear_constant"]
        style.caption(
            figure,
            "as published: unscaled features, one split; at its best depth the tree splits "
            f"{count} times on the wear constant. Leakage-free: standardised features, median and "
            "central share of the repeated splits. (c) share of the variance removed, all rows, "
            "leakage-free models" + style.sharing(importance),
        )
    return figure


def _importance_panel(panel, importance: pd.DataFrame) -> None:
    features = list(dict.fromkeys(importance["feature"]))
    places = np.arange(len(features))
    for shift, model, colour in ((-0.2, "tree", style.SKY), (0.2, "forest", style.GREEN)):
        rows = importance[importance["model"] == model].set_index("feature").loc[features]
        panel.barh(places + shift, rows["importance"], height=0.4, color=colour, label=model)
    style.feature_rows(panel, features)
    style.name_fixed(panel, rows["variation"])
    panel.set_xlabel("Importance")
    panel.legend(loc="lower right")
    panel.set_title(f"{style.letter(2)} leakage-free tree and forest", loc="left", fontsize=7.0)


def tree_figure(nodes: pd.DataFrame, summary: dict) -> Figure:
    """The pruned tree of all rows.

    Parameters
    ----------
    nodes : pandas.DataFrame
    summary : dict
        From `abradem.learning.baselines.trees.fit_trees`.
    """
    rows = {row["node"]: row for row in nodes.to_dict("records")}
    with style.style():
        places = _places(rows)
        depth = max((level for _, level in places.values()), default=0)
        figure, (panel,) = style.panels(1, 1, 0.5 + 0.85 * (depth + 1))
        panel.set_axis_off()
        power = style.decade(nodes["predicted"].abs().max())
        for node, (x, level) in places.items():
            row = rows[node]
            for side, words in (("left", "yes"), ("right", "no")):
                child = row[side]
                if child in places:
                    to_x, to_level = places[child]
                    panel.plot([x, to_x], [-level, -to_level], color=style.GREY, lw=0.8, zorder=1)
                    panel.text(
                        0.5 * (x + to_x), -0.5 * (level + to_level), words, fontsize=6.5,
                        color=style.GREY, ha="center", va="center",
                        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
                    )  # fmt: skip
            leaf = row["left"] < 0
            panel.text(
                x, -level, _node_words(row, power, node in places and not leaf and
                                       row["left"] not in places),
                ha="center", va="center", fontsize=6.5, zorder=2,
                bbox={
                    "boxstyle": "round,pad=0.3", "lw": 0.7,
                    "facecolor": style.LIGHT_GREY if leaf else "white",
                    "edgecolor": style.BLUE,
                },
            )  # fmt: skip
        width = max((x for x, _ in places.values()), default=0.0)
        panel.set_xlim(-0.6, width + 0.6)
        panel.set_ylim(-depth - 0.5, 0.5)
        panel.text(
            0.0, 1.0, "first lines: condition\nmean: mean wear depth rate\n"
            f"         ({style.scaled_unit(power, 'mm/s')})\nn: number of rows\ngrey: leaf",
            transform=panel.transAxes, ha="left", va="top", fontsize=6.5, color=style.GREY,
        )  # fmt: skip
        pruned = summary["pruned"]
        style.caption(
            figure,
            f"protocol: leakage-free; all rows, standardised; cost-complexity pruning with the "
            f"cross-validated penalty {pruned['ccp_alpha']:.2g}: {pruned['leaves']} leaves, depth "
            f"{pruned['depth']}; mean wear depth rate in "
            f"{style.scaled_unit(power, 'mm/s')}"
            + (f"; levels below {DRAWN_DEPTH} are not drawn" if pruned["depth"] > DRAWN_DEPTH
               else ""),
        )  # fmt: skip
    return figure


def _places(rows: dict) -> dict[int, tuple[float, int]]:
    """Position of each drawn node: leaves side by side, others centred above their children."""
    places: dict[int, tuple[float, int]] = {}
    columns = [0]

    def place(node: int, level: int) -> float:
        row = rows[node]
        if row["left"] < 0 or level == DRAWN_DEPTH:
            x = float(columns[0])
            columns[0] += 1
        else:
            x = 0.5 * (place(row["left"], level + 1) + place(row["right"], level + 1))
        places[node] = (x, level)
        return x

    if rows:
        place(0, 0)
    return places


def _node_words(row: dict, power: int, cut: bool) -> str:
    mean = f"mean {row['predicted'] / 10.0**power:.3g}\nn = {row['rows']}"
    if row["left"] < 0:
        return mean
    if cut:
        return f"{mean}\n..."
    name = style.with_unit(f"${LABELS[row['feature']].tex}$", row["unit"])
    return f"{name}\n≤ {style.number(row['threshold'])}\n{mean}"
