"""What figures call models and protocols."""

from __future__ import annotations

from abradem.figures import style
from abradem.parameters import quantity

HONEST, AS_PUBLISHED = "honest", "as_published"

PROTOCOLS = {AS_PUBLISHED: "as published", HONEST: "honest"}
COLOURS = {AS_PUBLISHED: style.RED, HONEST: style.BLUE}

MODELS = {
    "linear": "least squares",
    "lasso": "lasso",
    "ridge": "ridge",
    "pca_wrong_target": "PCA, wrong target",
    "pca": "PCA regression",
    "tree": "decision tree",
    "forest": "random forest",
    "paper_net": "449-24-500-385 net",
    "ga_ann": "GA-ANN",
    "power_law": "power law",
    "boosting": "boosting",
    "networks": "network ensemble",
    "gaussian_process": "Gaussian process",
    "surrogate": "surrogate (distilled)",
}


def feature_ticks(names) -> list[str]:
    """Tick labels of features: X number and symbol."""
    return [f"{quantity(name).symbol}  ${quantity(name).tex}$" for name in names]


def feature_rows(panel, names) -> None:
    """A panel with one row for each feature, the first on top."""
    panel.set_yticks(range(len(names)), feature_ticks(names), fontsize=6.5)
    panel.tick_params(axis="y", length=0)
    panel.set_ylim(len(names) - 0.4, -0.6)


def minus(text: str) -> str:
    """A number's text with a minus sign."""
    return text.replace("-", "\N{MINUS SIGN}")
