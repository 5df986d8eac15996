"""Regions of a study: flat and steep plates, slow and fast particles, small and large ones.

A score or a coverage over all cases says nothing of a corner in which a model is bad. Plates are
divided at fixed angles: below 12 deg a bed of particles may lie on the plate, above 50 deg they
glance off. Speed and size are divided at the middle of the range of the study.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.variation import HELD_FIXED, of_kind, variation
from abradem.learning.protocols import LEAKAGE_FREE
from abradem.learning.scores import r2
from abradem.quantities import SAMPLED_NAMES

ANGLE, SPEED, SIZE = "plate_angle", "particle_velocity_y", "particle_radius"

ANGLES = (12.0, 20.0, 50.0)
"""Plate angles that divide the regions, deg."""


class Region(NamedTuple):
    """Cases in which the absolute value of one quantity is at least ``low`` and below ``high``.

    Attributes
    ----------
    name, words : str
        Short name, and a description with its bounds.
    quantity : str
    low, high : float
        In the unit of `abradem.quantities`.
    """

    name: str
    words: str
    quantity: str
    low: float
    high: float

    def holds(self, inputs: np.ndarray) -> np.ndarray:
        """Whether each case with sampled quantities (n, m) is in the region, shape (n,)."""
        value = np.abs(inputs[:, SAMPLED_NAMES.index(self.quantity)])
        return (value >= self.low) & (value < self.high)


def regions_of(inputs: np.ndarray) -> list[Region]:
    """Regions of a study; a quantity that was held fixed divides nothing.

    Parameters
    ----------
    inputs : ndarray, shape (n, m)
        The sampled quantities in the units of `abradem.quantities`; those of `SAMPLED_NAMES` are
        the first.
    """
    sampled = inputs[:, : len(SAMPLED_NAMES)]
    fixed = of_kind(SAMPLED_NAMES, variation(sampled, SAMPLED_NAMES), HELD_FIXED)
    found = []
    if ANGLE not in fixed:
        ends = (0.0, *ANGLES, np.inf)
        for low, high in pairwise(ends):
            words = (
                f"plate below {high:g} deg" if low == 0.0
                else f"plate above {low:g} deg" if high == np.inf
                else f"plate {low:g} to {high:g} deg"
            )  # fmt: skip
            found.append(Region(words.removeprefix("plate "), words, ANGLE, low, high))
    for quantity, names, (less, more), unit, factor in (
        (SPEED, ("slow", "fast"), ("slower", "faster"), "m/s", 1.0),
        (SIZE, ("small", "large"), ("smaller", "larger"), "mm", 1e3),
    ):
        if quantity in fixed:
            continue
        value = np.abs(inputs[:, SAMPLED_NAMES.index(quantity)])
        middle = float(0.5 * (value.min() + value.max()))
        at = f"than {factor * middle:.3g} {unit}"
        what = "released" if quantity == SPEED else "radius"
        found.append(Region(names[0], f"{what} {less} {at}", quantity, 0.0, middle))
        found.append(Region(names[1], f"{what} {more} {at}", quantity, middle, np.inf))
    return found


def error_by_region(predictions: pd.DataFrame, dataset: pd.DataFrame) -> pd.DataFrame:
    """Share of each model's error that falls into each region, over the test rows of all splits.

    Parameters
    ----------
    predictions : pandas.DataFrame
        From `abradem.learning.comparison.with_scale`.
    dataset : pandas.DataFrame
        case_id and the sampled quantities.

    Returns
    -------
    pandas.DataFrame
        model, region, words, tested (test rows of all splits), case_share (their share of all test
        rows), error_share (of the sum of squared errors of the wear), number_error_share (of that
        of the logarithm of the wear number), r2_number (within the region). Leakage-free scores
        alone; the shares of the regions of one quantity add up to 1, and are nan for a target that
        is not positive.
    """
    inputs = dataset.set_index("case_id")[list(SAMPLED_NAMES)]
    regions = regions_of(inputs.to_numpy(dtype=float))
    rows = []
    tested = predictions[
        (predictions["protocol"] == LEAKAGE_FREE) & (predictions["split"] == "test")
    ]
    for model, part in tested.groupby("model", sort=False):
        values = inputs.loc[part["case_id"]].to_numpy(dtype=float)
        actual, predicted, floor, scale = (
            part[name].to_numpy(dtype=float) for name in ("actual", "predicted", "floor", "scale")
        )
        known = bool((actual > 0.0).all() and (floor > 0.0).all() and (scale > 0.0).all())
        raised = np.maximum(predicted, floor)
        number = np.log(actual / scale) if known else np.full(len(part), np.nan)
        guess = np.log(raised / scale) if known else number
        raw, logarithmic = _shares(predicted - actual), _shares(guess - number)
        for region in regions:
            held = region.holds(values)
            rows.append(
                (model, region.name, region.words, int(held.sum()), float(held.mean()),
                 float(raw[held].sum()), float(logarithmic[held].sum()),
                 r2(number[held], guess[held]) if known else np.nan)
            )  # fmt: skip
    columns = [
        "model", "region", "words", "tested", "case_share", "error_share", "number_error_share",
        "r2_number",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def _shares(error: np.ndarray) -> np.ndarray:
    """Share of each row in the sum of squared errors; nan without any error."""
    # Squares of huge errors overflow.
    largest = float(np.abs(error).max(initial=0.0))
    squared = (error / largest) ** 2 if largest > 0.0 else np.full(len(error), np.nan)
    return squared / squared.sum()
