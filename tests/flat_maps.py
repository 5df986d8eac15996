"""A map surrogate whose maps are all even, so that its answers are closed forms."""

import numpy as np

from abradem.surrogate.groups import GROUP_NAMES, Jet

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


def flat_parts(modes=1, counts=(3, 2)):
    """Description and arrays of a map surrogate whose maps are all even, of wear number 0.02."""
    width = len(GROUP_NAMES)
    coefficients = np.zeros((66, 1 + modes))
    coefficients[0, 0] = np.log(0.02)
    description = {
        "kind": "wear_maps",
        "jet": JET._asdict(),
        "groups": list(GROUP_NAMES),
        "plate": {"length": 0.3, "width": 0.3},
        "floor": 0.1,
        "target": {"measure": "friction", "unit": "mm/s"},
    }
    arrays = {
        "group_mean": np.zeros(width),
        "group_scale": np.ones(width),
        "group_low": np.full(width, -1e3),
        "group_high": np.full(width, 1e3),
        "coefficients": coefficients,
        "mean_map": np.full(counts, np.log(1.1)),
        "modes": np.ones((modes, *counts)),
    }
    return description, arrays
