"""The map surrogate: the wear map of a plate from the dimensionless groups of a case.

`abradem.surrogate.maps` states the model. It is fitted in three steps, on training cases alone:

*Shape.* The map of a case, divided by its mean, is averaged with its mirror image: slope, feed and
plate are symmetric about the middle of the width, so that the difference is noise.

*Modes.* Principal components of ln(shape + floor), `MODES` at most.

*Polynomials.* The logarithm of the wear number of the mean and the coefficient of each mode are
fitted by ridge regression on terms of second order in the standardised groups. The penalty of each
is the one of `PENALTIES` with the smallest error of leaving one case out, which needs no further
fit: e_i = r_i / (1 - h_ii) with the residual r and the hat matrix h (Allen 1974, Technometrics
16:125; Golub, Heath and Wahba 1979, Technometrics 21:215).

The maps are scored on the test cases of the study's splits, against the simulated maps with all
their scatter, which the halves of the plate tell (`possible_shape_r2`). Beside the model,
`MEAN_SHAPE` has the same mean over the plate and the mean shape of the training cases: what knowing
the case adds to the shape is the difference between both.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.learning.physical.problem import WearProblem
from abradem.learning.protocols import LEAKAGE_FREE, repeated_splits
from abradem.learning.rows import standard_scaler
from abradem.learning.scores import SCORE_COLUMNS, middle_of, r2, scores_of
from abradem.surrogate.groups import GROUP_NAMES
from abradem.surrogate.maps import KIND, second_order, shapes, wear_numbers
from abradem.units import MM_PER_M

MODES = 8
"""Largest number of modes; those that the groups do not explain get coefficients near 0."""

FLOOR = 1.0
"""f of ln(shape + f), in means over the plate. The map of a window of seconds scatters widely, and
the logarithm of a smaller floor would make much of elements that few particles met."""

PENALTIES = 10.0 ** np.arange(-2.0, 7.5, 0.5)
"""Penalties of the ridge regression, on standardised terms."""

FEWEST_CASES = 4
"""Fewest cases with a map from which maps are learned."""

MODEL, MEAN_SHAPE = MODELS = ("wear_maps", "mean_shape")

UNITS = {
    "map_R2": "1",
    "shape_R2": "1",
    "shape_R2_possible": "1",
    "maximum_R2_log": "1",
    "maximum_ratio": "1",
    "place_distance": "mm",
}
"""Metrics and their units, see `map_scores`."""


class PlateSides(NamedTuple):
    """Length and width of the plate, m."""

    length: float
    width: float


def wear_maps(
    given: WearProblem,
    maps: np.ndarray,
    plate: PlateSides,
    measure: str,
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
    confidence: float = 0.95,
) -> tuple[tuple[dict, dict[str, np.ndarray]], pd.DataFrame]:
    """Fit the map surrogate to all cases, and score it on the repeated splits.

    Parameters
    ----------
    given : WearProblem
        Gives groups, scale, and the splits; its target does not enter.
    maps : ndarray, shape (n, nx, nz)
        Wear depth rate of the elements for the rows of ``given``, mm/s, all nan for cases without
        a map, see `abradem.wear.element_maps.element_maps`.
    plate : PlateSides
    measure : str
        Wear measure of the maps.
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    confidence : float
        Central share of the splits that the intervals of the scores contain.

    Returns
    -------
    model : tuple of dict
        Description and arrays, which `abradem.surrogate.maps.MapSurrogate` reads.
    scores : pandas.DataFrame
        With the columns of `abradem.learning.scores.SCORE_COLUMNS`.

    Raises
    ------
    ValueError
        If fewer than `FEWEST_CASES` cases have a map with wear.
    """
    known = usable(maps)
    if known.sum() < FEWEST_CASES:
        raise ValueError(
            f"{int(known.sum())} cases have a wear map, at least {FEWEST_CASES} are needed"
        )
    numbers = maps / given.scale[:, None, None]
    scores = evaluate_maps(given, numbers, known, plate, test_share, repeats, seed)
    rows = np.flatnonzero(known)
    description = {
        "model": MODEL,
        "kind": KIND,
        "protocol": LEAKAGE_FREE,
        "table": given.table.name,
        "training_rows": len(rows),
        "dataset_hash": given.table.hash,
        "jet": given.jet.stored(),
        "groups": list(GROUP_NAMES),
        "plate": plate._asdict(),
        "floor": FLOOR,
        "target": {"measure": measure, "unit": given.table.unit},
        "scores": {name: scores_of(scores, name, LEAKAGE_FREE, confidence) for name in MODELS},
    }
    return (description, fit_maps(given.groups[rows], numbers[rows])), scores


def usable(maps: np.ndarray) -> np.ndarray:
    """Which cases have a finite map (n, nx, nz) with any wear, bool (n,)."""
    sums = maps.sum(axis=(1, 2))
    return np.isfinite(sums) & (sums > 0.0)


def fit_maps(groups: np.ndarray, numbers: np.ndarray) -> dict[str, np.ndarray]:
    """Fit modes and polynomials.

    Parameters
    ----------
    groups : ndarray, shape (n, 10)
    numbers : ndarray, shape (n, nx, nz)
        Wear numbers of the elements, with a mean above 0.

    Returns
    -------
    dict of str to ndarray
        The arrays of `abradem.surrogate.maps.MapSurrogate`.
    """
    mean = numbers.mean(axis=(1, 2))
    shape = numbers / mean[:, None, None]
    logs = np.log(0.5 * (shape + shape[:, :, ::-1]) + FLOOR)
    mean_map = logs.mean(axis=0)
    flat = (logs - mean_map).reshape(len(logs), -1)
    count = min(MODES, len(flat) - 1, flat.shape[1])
    _, _, directions = np.linalg.svd(flat, full_matrices=False)
    modes = _with_sign(directions[:count])
    scaler = standard_scaler(groups)
    targets = np.column_stack([np.log(mean), flat @ modes.T])
    return {
        "group_mean": np.asarray(scaler.mean),
        "group_scale": np.asarray(scaler.scale),
        "group_low": groups.min(axis=0),
        "group_high": groups.max(axis=0),
        "coefficients": ridge(second_order(scaler.forward(groups)), targets),
        "mean_map": mean_map,
        "modes": modes.reshape(count, *mean_map.shape),
    }


def _with_sign(modes: np.ndarray) -> np.ndarray:
    """Modes (k, m) whose largest entry is positive; their sign is arbitrary."""
    largest = np.take_along_axis(modes, np.abs(modes).argmax(axis=1)[:, None], axis=1)
    return modes * np.where(largest < 0.0, -1.0, 1.0)


def ridge(terms: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Ridge regression with the penalty of the smallest leave-one-out error for each target.

    Parameters
    ----------
    terms : ndarray, shape (n, p)
        The first column is 1 and is not penalised; the others are standardised here.
    targets : ndarray, shape (n, k)

    Returns
    -------
    ndarray, shape (p, k)
        Coefficients of the terms as given.
    """
    scaler = standard_scaler(terms[:, 1:])
    x, y = scaler.forward(terms[:, 1:]), targets - targets.mean(axis=0)
    left, singular, right = np.linalg.svd(x, full_matrices=False)
    projected = left.T @ y
    best = np.full(y.shape[1], np.inf)
    found = np.zeros((x.shape[1], y.shape[1]))
    for penalty in PENALTIES:
        share = singular**2 / (singular**2 + penalty)
        residual = y - left @ (share[:, None] * projected)
        # The mean takes one degree of freedom of each row.
        hat = (left**2) @ share + 1.0 / len(y)
        error = np.sum((residual / (1.0 - np.minimum(hat, 1.0 - 1e-9))[:, None]) ** 2, axis=0)
        weights = right.T @ ((singular / (singular**2 + penalty))[:, None] * projected)
        better = error < best
        best, found[:, better] = np.where(better, error, best), weights[:, better]
    slopes = found / np.asarray(scaler.scale)[:, None]
    return np.vstack([targets.mean(axis=0) - np.asarray(scaler.mean) @ slopes, slopes])


def evaluate_maps(
    given: WearProblem,
    numbers: np.ndarray,
    known: np.ndarray,
    plate: PlateSides,
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
) -> pd.DataFrame:
    """Score the maps of the test cases of the repeated splits; fits see training cases alone.

    Parameters
    ----------
    given : WearProblem
    numbers : ndarray, shape (n, nx, nz)
        Wear numbers of the elements.
    known : ndarray of bool, shape (n,)
        Cases with a map; the others are left out on both sides of a split.
    plate : PlateSides
    test_share, repeats, seed
        See `abradem.learning.protocols.repeated_splits`.
    """
    rows: list[dict] = []
    splits = repeated_splits(given.table.keys, given.table.groups, test_share, repeats, seed)
    for repeat, (train, test) in enumerate(splits):
        train, test = train[known[train]], test[known[test]]
        if len(train) < FEWEST_CASES or not len(test):
            continue
        arrays = fit_maps(given.groups[train], numbers[train])
        predicted = wear_numbers(arrays, given.groups[test], FLOOR)
        mean = predicted.mean(axis=(1, 2))[:, None, None]
        typical = shapes(arrays, np.zeros((1, len(arrays["modes"]))), FLOOR)
        for model, maps in zip(MODELS, (predicted, mean * typical), strict=True):
            found = map_scores(numbers[test], maps, given.scale[test], plate)
            rows += [
                {"model": model, "protocol": LEAKAGE_FREE, "table": given.table.name,
                 "split": "test", "repeat": repeat, "metric": metric, "value": value,
                 "unit": UNITS[metric]}
                for metric, value in found.items()
            ]  # fmt: skip
    return pd.DataFrame(rows, columns=SCORE_COLUMNS)


def map_scores(
    actual: np.ndarray, predicted: np.ndarray, scale: np.ndarray, plate: PlateSides
) -> dict[str, float]:
    """Scores of predicted maps.

    Parameters
    ----------
    actual, predicted : ndarray, shape (n, nx, nz)
        Wear numbers of the elements.
    scale : ndarray, shape (n,)
        Scale of the wear, mm/s.
    plate : PlateSides

    Returns
    -------
    dict of str to float
        ``map_R2``: R2 of the depth rates (mm/s) of all elements of all cases. ``shape_R2``: of
        the maps divided by their means. ``shape_R2_possible``: the same for a model without error,
        see `possible_shape_r2`. ``maximum_R2_log``: of the logarithm of the depth
        rate of the worst element. ``maximum_ratio``: median of predicted over simulated worst
        element. ``place_distance``: median distance between the worst elements, mm.
    """
    both = actual, predicted
    rates = [scale[:, None, None] * maps for maps in both]
    simulated, given = (maps / maps.mean(axis=(1, 2), keepdims=True) for maps in both)
    worst, found = (maps.max(axis=(1, 2)) for maps in rates)
    return {
        "map_R2": r2(*(maps.ravel() for maps in rates)),
        "shape_R2": r2(simulated.ravel(), given.ravel()),
        "shape_R2_possible": possible_shape_r2(simulated),
        "maximum_R2_log": r2(np.log(worst), np.log(found)),
        "maximum_ratio": middle_of(found / worst),
        "place_distance": middle_of(_apart(actual, predicted, plate)),
    }


def possible_shape_r2(shape: np.ndarray) -> float:
    """R2 of the shape of maps that a model without error would reach, estimated from the maps.

    What a map and its mirror image have in common is not scatter, as slope, feed and plate are
    symmetric about the middle of the width. With independent scatter of both halves, the share of
    the variance that is no scatter is cov(p, p mirrored) / var(p), the split-half reliability of
    the halves (Spearman 1910, Br. J. Psychol. 3:271).

    Parameters
    ----------
    shape : ndarray, shape (n, nx, nz)
        Maps divided by their means.

    Returns
    -------
    float
        nan if the plate has a single element across, or all maps are even.
    """
    half = shape.shape[2] // 2
    one, other = shape[:, :, :half] - 1.0, shape[:, :, ::-1][:, :, :half] - 1.0
    power = float(np.sum(one**2) + np.sum(other**2))
    return 2.0 * float(np.sum(one * other)) / power if power > 0.0 else np.nan


def _apart(actual: np.ndarray, predicted: np.ndarray, plate: PlateSides) -> np.ndarray:
    """Distance between the worst elements of two maps of each case, mm.

    A predicted map is symmetric about the middle of the width, so its worst element has a twin;
    the nearer one counts.
    """
    nx, nz = actual.shape[1:]
    places = [
        np.unravel_index(maps.reshape(len(maps), -1).argmax(axis=1), (nx, nz))
        for maps in (actual, predicted)
    ]
    (x, z), (other_x, other_z) = places
    across = np.minimum(np.abs(z - other_z), np.abs(z - (nz - 1 - other_z)))
    away = np.hypot((x - other_x) * plate.length / nx, across * plate.width / nz)
    return MM_PER_M * away


def plate_of(setup: Mapping) -> PlateSides:
    """Plate of a set-up, given as plain values of a `Setup`."""
    return PlateSides(setup["plate_length"], setup["plate_width"])
