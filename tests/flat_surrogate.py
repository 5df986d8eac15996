"""A surrogate whose wear number is the same for all cases, so that its answers are closed forms."""

import math

import numpy as np

from abradem.learning.model_files import write_model
from abradem.quantities import quantity
from abradem.surrogate.groups import group_names, input_names, wear_scale

NUMBER, SPREAD, SCORES = 0.02, 0.1, np.full(99, 2.0)
"""Wear number, its relative standard deviation, held-out errors in standard deviations."""


def write_flat_surrogate(stem, jet, target="wear_friction_p99"):
    """Write the two files of the surrogate."""
    description = {
        "kind": "surrogate",
        "jet": jet.stored(),
        "groups": list(group_names(jet)),
        "target": {"name": target, "unit": "mm/s"},
        "features": [
            {
                "name": row.name,
                "unit": row.unit,
                "training_range": list(row.paper_range or row.limits),
            }
            for row in map(quantity, input_names(jet))
        ],
    }
    width = len(group_names(jet))
    nothing = np.zeros((width, 1), dtype=np.float32)
    arrays = {
        "group_mean": np.zeros(width),
        "group_scale": np.ones(width),
        "conformal": SCORES,
        "mean_weights_0": nothing,
        "mean_biases_0": np.array([math.log(NUMBER)], dtype=np.float32),
        "spread_weights_0": nothing,
        "spread_biases_0": np.array([math.log(SPREAD)], dtype=np.float32),
    }
    write_model(description, arrays, f"{stem}.json")


def flat_prediction(values, jet):
    """Rate and the ends of its interval, mm/s."""
    rate = NUMBER * wear_scale(values, jet)
    return rate, rate * math.exp(-2.0 * SPREAD), rate * math.exp(2.0 * SPREAD)
