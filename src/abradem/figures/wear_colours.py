"""Colours of wear maps, in which no wear is another colour than little wear."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap
from matplotlib.patches import Patch

WEAR_MAP = "YlOrRd"
"""Colours of depth maps, yellow to red."""
NO_WEAR = "#C3CFD9"
"""Colour of facets without wear, which is not a colour of little wear."""

FULL_SHARE = 0.995
"""Quantile of the final depths at which a scale ends that is shared by frames, so that single
extreme facets do not determine it."""


def wear_colours() -> Colormap:
    """Colours of depth maps, with a colour of its own for masked facets, those without wear."""
    return mpl.colormaps[WEAR_MAP].with_extremes(bad=NO_WEAR)


def only_worn(depth: np.ndarray) -> np.ma.MaskedArray:
    """The depths of a map with the facets masked that have no wear."""
    return np.ma.masked_less_equal(depth, 0.0)


def no_wear_handle() -> Patch:
    """Legend handle for the facets without wear."""
    return Patch(color=NO_WEAR, label="no wear")


def scale_top(depth: np.ndarray) -> float:
    """Depth at the upper end of a scale for frames whose last has the given depths, their unit."""
    worn = depth[depth > 0.0]
    return float(np.quantile(worn, FULL_SHARE)) if worn.size else 1.0
