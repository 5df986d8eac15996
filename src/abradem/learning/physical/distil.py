"""Distillation of the Gaussian process into small networks, the surrogate.

The Gaussian process needs all its rows for a prediction; a network needs only a few thousand
weights. The network is trained on predictions of the process at many points, drawn evenly within
the training ranges (knowledge distillation; Hinton, Vinyals and Dean 2015, arXiv:1503.02531).
These labels are cheap and free of noise. A second network learns the logarithm of the standard
deviation of the process times the error scale, the unit of the prediction intervals.

The surrogate is scored separately: on each of the study's splits the process is fitted to the
training rows and distilled, and the *network* is scored on the test rows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abradem.dataset.variation import settled
from abradem.learning.evaluation import Results
from abradem.learning.network import Network, Training, start, train
from abradem.learning.physical.error_scale import ErrorScale
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.intervals import Conformal
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import GROUP_SCALE, WearProblem
from abradem.learning.protocols import LEAKAGE_FREE, repeated_splits
from abradem.learning.rows import standard_scaler
from abradem.learning.scores import has_spread, scores_of
from abradem.quantities import quantity, wear_parts
from abradem.surrogate.groups import group_matrix, group_names, input_names, wear_scale
from abradem.surrogate.model import Surrogate

MODEL = "surrogate"

SPREAD_HIDDEN = (32, 32)
"""Hidden layers for the standard deviation, which is smooth and need not be precise."""

SCHEDULE = ((0.45, 64, 3e-3), (0.3, 128, 1e-3), (0.25, 256, 3e-4))
"""Training phases: share of the epochs, rows of a mini-batch, learning rate."""

CHECKED = 2000
"""Number of points, not used in training, at which network and process are compared."""


class Settings(NamedTuple):
    """Number of distillation points, neurons of the hidden layers, passes over the points."""

    points: int = 20_000
    hidden: tuple[int, ...] = (64, 64)
    epochs: int = 40


def distil(
    process: GaussianProcess,
    given: WearProblem,
    settings: Settings,
    seed: int = 0,
    scale: ErrorScale | None = None,
) -> tuple[dict[str, np.ndarray], dict]:
    """Train networks that reproduce the mean and the standard deviation of a process.

    Parameters
    ----------
    process : GaussianProcess
    given : WearProblem
        Its inputs give the ranges from which the points are drawn.
    settings : Settings
    seed : int
    scale : ErrorScale, optional
        Multiplies the deviation of the process; 1 by default.

    Returns
    -------
    arrays : dict of str to ndarray
        The arrays that `abradem.surrogate.model.Surrogate` reads, except the conformal scores.
    error : dict
        ``rms`` and ``largest`` relative difference of the prediction from that of the process at
        new points, and ``deviation_rms``, that of the standard deviation.
    """
    low, high = given.inputs.min(axis=0), given.inputs.max(axis=0)
    groups = _points(low, high, settings.points, seed, given)
    mean, deviation = _labels(process, groups, scale)
    scaler = standard_scaler(groups)
    z = scaler.forward(groups)
    networks = {
        "mean": _trained(z, mean, settings.hidden, settings.epochs, seed),
        "spread": _trained(z, np.log(deviation), SPREAD_HIDDEN, settings.epochs // 2 + 1, seed),
    }
    fresh = _points(low, high, CHECKED, seed + 1, given)
    expected = _labels(process, fresh, scale)
    z = scaler.forward(fresh)
    away = np.abs(networks["mean"].predict(z) - expected[0])
    spread = networks["spread"].predict(z) - np.log(expected[1])
    arrays = {"group_mean": np.asarray(scaler.mean), "group_scale": np.asarray(scaler.scale)}
    for name, network in networks.items():
        arrays.update({f"{name}_{key}": array for key, array in network.arrays().items()})
    return arrays, {
        "rms": float(np.sqrt(np.mean(away**2))),
        "largest": float(away.max()),
        "deviation_rms": float(np.sqrt(np.mean(spread**2))),
    }


def _labels(process: GaussianProcess, groups: np.ndarray, scale: ErrorScale | None):
    """Mean and deviation that the networks learn, each (n,), at groups (n, p)."""
    mean, deviation = process.predict_with_deviation(groups)
    return mean, deviation if scale is None else deviation * scale.at(groups)


def surrogate_of(
    given: WearProblem,
    process: GaussianProcess,
    conformal: Conformal,
    settings: Settings,
    results: Results,
    confidence: float = 0.95,
    seed: int = 0,
    element_size: float | None = None,
) -> tuple[dict, dict[str, np.ndarray]]:
    """Description and arrays of the surrogate of a study.

    Parameters
    ----------
    given : WearProblem
    process : GaussianProcess
        Fitted to all rows.
    conformal : Conformal
        Held-out scores and error scale, see `abradem.learning.physical.intervals.calibrate`.
    settings : Settings
    results : Results
        From `evaluate_surrogate`.
    confidence : float
        Central share of the splits that the intervals of the scores contain.
    seed : int
    element_size : float, optional
        Edge of the elements of the target, m; not noted for the mean over the plate.
    """
    arrays, error = distil(process, given, settings, seed, conformal.scale)
    arrays["conformal"] = conformal.scores
    description = _describe(given, error, settings, results, confidence)
    description["error_scale"] = conformal.scale.describe()
    of_elements = wear_parts(given.table.target_name)[1] != "mean"
    if of_elements and element_size is not None:
        description["target"]["element_size"] = element_size
    return description, arrays


def evaluate_surrogate(
    given: WearProblem,
    settings: Settings,
    test_share: float = 0.2,
    repeats: int = 20,
    seed: int = 0,
) -> Results:
    """Score distilled networks on the test rows of the repeated splits, as their teacher is."""
    results = Results(given.table)
    make = makers(seed)[PROCESS]
    splits = repeated_splits(given.table.keys, given.table.groups, test_share, repeats, seed)
    for repeat, (rows, test) in enumerate(splits):
        process = fitted(make, given, rows)
        arrays, _ = distil(process, given._replace(inputs=given.inputs[rows]), settings, seed)
        arrays["conformal"] = np.sort(np.abs(process.residuals) / process.deviations)
        description = _describe(given, {}, settings, None, 0.95)
        predicted = Surrogate(description, arrays).predict(
            dict(zip(input_names(given.jet), given.inputs[test].T, strict=True))
        )
        # Surrogate and problem use the same unit, that of the headline wear rate.
        floor = float(given.table.target[rows].min())
        results.add(MODEL, LEAKAGE_FREE, "test", repeat, test, predicted.rate, floor)
    return results


def _describe(given: WearProblem, error: dict, settings: Settings, results, confidence) -> dict:
    low, high = given.inputs.min(axis=0), given.inputs.max(axis=0)
    return {
        "model": MODEL,
        "kind": "surrogate",
        "protocol": LEAKAGE_FREE,
        "distilled_from": PROCESS,
        "distillation_error": error,
        "hidden": list(settings.hidden),
        "points": settings.points,
        "table": given.table.name,
        "training_rows": len(given.table.target),
        "dataset_hash": given.table.hash,
        "jet": given.jet.stored(),
        "groups": list(group_names(given.jet)),
        "features": [
            {
                "symbol": row.symbol,
                "name": row.name,
                "unit": row.unit,
                "training_range": [float(low[place]), float(high[place])],
            }
            for place, row in enumerate(map(quantity, input_names(given.jet)))
        ],
        "target": {"name": given.table.target_name, "unit": given.table.unit},
        "scores": {}
        if results is None
        else scores_of(results.scores, MODEL, LEAKAGE_FREE, confidence),
    }


def _points(low, high, count: int, seed: int, given: WearProblem) -> np.ndarray:
    """Groups of cases spread evenly over the ranges, as a Latin hypercube."""
    from scipy.stats import qmc

    names = input_names(given.jet)
    unit = qmc.LatinHypercube(len(names), rng=np.random.default_rng(seed)).random(count)
    values = dict(zip(names, (low + unit * (high - low)).T, strict=True))
    # Without initial velocity and without fall the wear number is undefined.
    possible = wear_scale(values, given.jet) > 0.0
    found = group_matrix({name: column[possible] for name, column in values.items()}, given.jet)
    return settled(found, GROUP_SCALE)


def _trained(z: np.ndarray, target: np.ndarray, hidden, epochs: int, seed: int) -> Network:
    """A network in standardised groups whose output is the target itself."""
    spread = float(target.std()) if has_spread(target) else 1.0
    centre = float(target.mean())
    network = start(z.shape[1], tuple(hidden), seed)
    for place, (share, batch, rate) in enumerate(SCHEDULE):
        training = Training(max(1, round(share * epochs)), batch, rate)
        (network,) = train([network], [seed + place], z, (target - centre) / spread, training)
    weights, biases = list(network.weights), list(network.biases)
    weights[-1] = weights[-1] * np.float32(spread)
    biases[-1] = biases[-1] * np.float32(spread) + np.float32(centre)
    return Network(weights, biases)
