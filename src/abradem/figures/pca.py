"""Principal components: correlations of the features, loadings, variances, regression."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from abradem.figures import style
from abradem.learning.protocols import AS_PUBLISHED, LEAKAGE_FREE
from abradem.quantities import quantity
from abradem.words.labels import LABELS, PROTOCOLS, feature_label

DIVERGING = "RdBu_r"
LOWEST = -1.0
"""Lower end of the R2 axis."""


def draw_correlations(correlations: pd.DataFrame, model: Mapping) -> Figure:
    """Draw `correlations_figure` with the number of training rows of the model."""
    return correlations_figure(correlations, model["training_rows"])


def correlations_figure(correlations: pd.DataFrame, rows: int) -> Figure:
    """Correlations of every pair of X1 to X21 (the wear), as the lower triangle of a heat map.

    Parameters
    ----------
    correlations : pandas.DataFrame
        From `abradem.learning.baselines.pca.fit_pca`.
    rows : int
        Number of rows of the data set.
    """
    names = list(dict.fromkeys(correlations["feature"]))
    grid = correlations.pivot(index="feature", columns="other", values="correlation")
    values = grid.loc[names, names].to_numpy()
    lower = np.tril(np.ones(values.shape, dtype=bool), -1)
    with style.style():
        figure, (panel,) = style.panels(1, 1, 0.88 * style.PAGE)
        mesh = panel.imshow(
            np.where(lower, values, np.nan)[1:, :-1], cmap=DIVERGING, vmin=-1.0, vmax=1.0,
            aspect="auto",
        )  # fmt: skip
        for i, j in zip(*np.nonzero(lower), strict=True):
            if np.isfinite(values[i, j]):
                panel.text(
                    j, i - 1, _short(values[i, j]), ha="center", va="center", fontsize=6.5,
                    color="white" if abs(values[i, j]) > 0.6 else "black",
                )  # fmt: skip
        panel.set_xticks(
            range(len(names) - 1),
            [f"{quantity(name).symbol}\n${LABELS[name].tex}$" for name in names[:-1]],
            fontsize=6.5,
        )
        panel.set_yticks(
            range(len(names) - 1), [feature_label(name) for name in names[1:]], fontsize=6.5
        )
        panel.tick_params(length=0)
        panel.spines[:].set_visible(False)
        bar = figure.colorbar(
            mesh, cax=panel.inset_axes((0.55, 0.9, 0.4, 0.025)), orientation="horizontal"
        )
        bar.set_label("Pearson correlation")
        bar.outline.set_linewidth(0.6)
        style.caption(
            figure,
            f"all {rows} rows, descriptive, the same under both protocols; X21: wear depth rate"
            + ("; empty: held fixed" if not np.isfinite(values).all() else ""),
        )
    return figure


def _short(value: float) -> str:
    """A correlation as short text for a cell: two decimals, no leading zero."""
    text = style.minus(f"{round(value, 2) + 0.0:.2f}")
    return text if text[-4] == "1" else text.replace("0.", ".", 1)


def loadings_figure(loadings: pd.DataFrame, scree: pd.DataFrame, summary: dict) -> Figure:
    """Loadings and variances of the components, for both scalings.

    Parameters
    ----------
    loadings, scree : pandas.DataFrame
    summary : dict
        From `abradem.learning.baselines.pca.fit_pca`.
    """
    protocols = [name for name in (AS_PUBLISHED, LEAKAGE_FREE) if name in set(scree["protocol"])]
    with style.style():
        figure, axes = style.panels(4, 2, 3.0)
        for index, protocol in enumerate(protocols):
            _scree_panel(axes[index], index, scree[scree["protocol"] == protocol], protocol)
        for index, protocol in enumerate(protocols, start=2):
            rows = loadings[loadings["protocol"] == protocol]
            grid = rows.pivot(index="feature", columns="component", values="loading")
            names = list(dict.fromkeys(rows["feature"]))
            panel = axes[index]
            mesh = panel.imshow(
                grid.loc[names].to_numpy(), cmap=DIVERGING, vmin=-1.0, vmax=1.0, aspect="auto"
            )
            panel.set_xticks(range(0, grid.shape[1]), grid.columns, fontsize=6.5)
            panel.set_yticks(
                range(len(names)), [feature_label(name) for name in names], fontsize=6.5
            )
            panel.tick_params(length=0)
            panel.set_xlabel("Component")
            panel.set_title(
                f"{style.letter(index)} loadings, {PROTOCOLS[protocol]}", loc="left", fontsize=7.0
            )
        bar = figure.colorbar(mesh, ax=axes[2:], shrink=0.9, pad=0.02)
        bar.set_label("Loading")
        bar.outline.set_linewidth(0.6)
        left = ", ".join(quantity(name).symbol for name in summary["held_fixed"])
        words = "; ".join(f"{PROTOCOLS[name]}: {summary['stiffness'][name]}" for name in protocols)
        style.caption(
            figure,
            "all rows, without the target; as published: features scaled to 0...1; leakage-free: "
            f"standardised. Stiffnesses, {words} (a feature is grouped with the component that it "
            "correlates with most, if by at least 0.6)"
            + (f". Held fixed and left out: {left}" if left else ""),
        )
    return figure


def _scree_panel(panel, index, rows, protocol) -> None:
    panel.bar(rows["component"], rows["share"], color=style.PROTOCOL_COLOURS[protocol], width=0.7)
    panel.plot(rows["component"], rows["cumulative"], "o-", color=style.BLACK, ms=2.5, lw=0.9)
    panel.set_ylim(0.0, 1.05)
    panel.set_xlim(0.3, len(rows) + 0.7)
    panel.set_xticks(rows["component"])
    panel.tick_params(axis="x", labelsize=6.5)
    panel.set_xlabel("Component")
    panel.set_ylabel("Share of the variance")
    panel.set_title(
        f"{style.letter(index)} variances (line: cumulative), {PROTOCOLS[protocol]}",
        loc="left",
        fontsize=7.0,
    )


def components_curve_figure(curve: pd.DataFrame) -> Figure:
    """R2 on held-out rows against the number of components, for both targets and protocols.

    Parameters
    ----------
    curve : pandas.DataFrame
        From `abradem.learning.baselines.pca.fit_pca`.
    """
    with style.style():
        figure, (panel,) = style.panels(1, 1, 2.6, style.COLUMN)
        for protocol, explained, colour, line, words in (
            (AS_PUBLISHED, "last component", style.ORANGE, "s-",
             "as published, wrong target (last component)"),
            (AS_PUBLISHED, "wear", style.PROTOCOL_COLOURS[AS_PUBLISHED], "o-",
             "as published, wear"),
            (LEAKAGE_FREE, "wear", style.PROTOCOL_COLOURS[LEAKAGE_FREE], "^-",
             "leakage-free, wear"),
        ):  # fmt: skip
            rows = curve[(curve["protocol"] == protocol) & (curve["explained"] == explained)]
            panel.plot(rows["components"], rows["r2"], line, color=colour, ms=2.5, label=words)
            if rows["r2_lower"].notna().any():
                panel.fill_between(
                    rows["components"], rows["r2_lower"], rows["r2_upper"], color=colour,
                    alpha=0.18, lw=0,
                )  # fmt: skip
        panel.axhline(0.0, color=style.BLACK, lw=0.5)
        values = pd.concat([curve["r2"], curve["r2_lower"]]).dropna()
        low = float(values.min()) if len(values) else 0.0
        panel.set_ylim(max(min(low, 0.0) - 0.05, LOWEST), 1.0)
        panel.set_xlim(0.5, max(1, curve["components"].max()) + 0.5)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
        panel.set_xlabel("Number of components")
        panel.set_ylabel("$R^2$ on held-out rows")
        figure.legend(loc="outside upper left")
        style.caption(
            figure,
            "as published: one split, scalers and components of all rows; leakage-free: median "
            "over the repeated splits, band: central share of the splits"
            + ("; values below \N{MINUS SIGN}1 are not shown" if low < LOWEST else ""),
        )
    return figure
