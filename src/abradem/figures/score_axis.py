"""Axes of R2 with a logarithmic scale of 1 - R2, the share of the variance that is not explained.

On a linear axis good models are indistinguishable and one bad interval takes most of the width.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axis import Axis

LEAST = 1e-4
"""Unexplained share 1 - R2 at which axes end."""

MOST = 2.0
"""Unexplained share 1 - R2 at the other end: R2 = -1, much worse than the mean of the rows."""

_TICKS = (2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001)
_APART = 0.09
"""Smallest distance of labelled ticks as a share of the axis."""


def unexplained(r2, most: float = MOST) -> np.ndarray:
    """1 - R2, not beyond the ends of the axes; nan stays nan."""
    return np.clip(1.0 - np.asarray(r2, dtype=float), LEAST, most)


def label_scores(axis: Axis, low: float, high: float) -> None:
    """Label a logarithmic axis of 1 - R2, from ``low`` to ``high``, with R2."""
    kept: list[float] = []
    span = np.log(high / low)
    for tick in _TICKS:
        within = low <= tick <= high * (1.0 + 1e-9)
        if within and (not kept or np.log(kept[-1] / tick) > _APART * span):
            kept.append(tick)
    labels = [f"{1.0 - tick:.4g}".replace("-", "\N{MINUS SIGN}") for tick in kept]
    axis.set_ticks(kept, labels)
    axis.set_ticks([], minor=True)
