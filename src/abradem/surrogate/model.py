"""Prediction of wear depth rates and their intervals with the surrogate of a study.

A prediction takes less than a millisecond. A study writes its surrogate to two files without code:
``surrogate.json`` (features, units, training ranges, jet, scores) and ``surrogate.safetensors``
(arrays). They hold two small networks that were distilled from the Gaussian process of the study
(`abradem.learning.physical.distil`). One gives the logarithm of the wear number, the other the
logarithm of its standard deviation. `abradem.surrogate.groups` computes the inputs of the networks
from the quantities of a case, and the scale that converts the wear number to mm/s. The intervals
use quantiles of held-out errors divided by this standard deviation
(`abradem.learning.physical.intervals`).

>>> abradem.predict({"plate_angle": 45.0, ...}, model="results/paper/models/surrogate")

Only numpy and safetensors are needed here; torch, scikit-learn, numba and pandas are not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from abradem.dataset.variation import SAME, held_fixed, scales_of
from abradem.quantities import SAMPLED, SAMPLED_NAMES, impossible, quantity
from abradem.store.checksums import damage, remedy
from abradem.store.errors import TableError
from abradem.store.files import read_arrays, read_json
from abradem.surrogate.groups import Jet, group_columns, squared_impact_speed, wear_scale
from abradem.surrogate.parts import NETWORKS, PartError, check_arrays, check_description

BLOCK = 4096
"""Number of rows computed at once, few enough for the processor's cache."""

SECONDS_PER_HOUR = 3600.0

SLACK = 0.01
"""Share of a training range by which a value may be outside it without a warning: the cases of a
study do not reach the exact ends of its ranges."""


class PredictionError(ValueError):
    """The model cannot be read, or the values are invalid; the message has one line per problem."""


class Prediction(NamedTuple):
    """Wear depth rates of n cases, in the mean over the plate or of the target of the study.

    Attributes
    ----------
    rate, lower, upper : ndarray, shape (n,)
        Median and interval, mm/s.
    confidence : float
        Level of the interval: the share of simulated cases inside such intervals.
    warnings : list of str
        Values outside the training ranges, one line for each quantity.
    """

    rate: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    confidence: float
    warnings: list[str]

    def hours_to(self, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Time in hours until the plate is worn to a depth.

        Parameters
        ----------
        depth : float
            Wear depth, mm, of what the surrogate predicts: in the mean over the plate, unless the
            study chose another target. Single places are worn deeper.

        Returns
        -------
        median, least, most : ndarray, shape (n,)
            h; ``least`` follows from the upper end of the interval of the rate.

        Raises
        ------
        PredictionError
            If ``depth`` is not a positive number.
        """
        if not (depth > 0.0 and np.isfinite(depth)):
            raise PredictionError(f"depth = {depth!r} mm must be a positive number")
        # A rate without an upper end is a time without a lower one, and the reverse.
        with np.errstate(divide="ignore", over="ignore"):
            median, least, most = (
                depth / rate / SECONDS_PER_HOUR for rate in (self.rate, self.upper, self.lower)
            )
        return median, least, most


class Surrogate:
    """A surrogate, usually read from its files by `load`.

    Parameters
    ----------
    description : mapping
        Content of the JSON file.
    arrays : mapping of str to ndarray
        Content of the safetensors file.

    Attributes
    ----------
    description : dict
        Content of the JSON file.
    jet : Jet
    ranges : dict of str to (float, float)
        Training range of each sampled quantity.
    group_mean, group_scale : ndarray, shape (10,)
        Scaling of the groups.
    layers : dict of str to list
        Weights and biases of both networks.
    """

    def __init__(self, description: Mapping, arrays: Mapping[str, np.ndarray]):
        self.description = dict(description)
        self.jet = Jet(**description["jet"])
        self.ranges = {
            feature["name"]: tuple(feature["training_range"]) for feature in description["features"]
        }
        self.group_mean, self.group_scale = arrays["group_mean"], arrays["group_scale"]
        self.layers = {name: _layers(arrays, name) for name in NETWORKS}
        self._quantiles = np.sort(arrays["conformal"])

    usual_confidence = 0.95
    """Level of an interval for which no level is asked."""

    @property
    def score_count(self) -> int:
        """Number of held-out errors behind the intervals."""
        return len(self._quantiles)

    @property
    def highest_confidence(self) -> float:
        """Highest level of an interval that the held-out errors can promise."""
        return highest_level(self.score_count)

    @classmethod
    def load(cls, path: str | Path) -> Surrogate:
        """Read a surrogate from its JSON file and the safetensors file next to it.

        Parameters
        ----------
        path : path
            The JSON file, with or without ``.json``.

        Raises
        ------
        PredictionError
            If a file is missing or damaged, or a part of it is missing, of the wrong type or
            shape, or not finite.
        """
        path = Path(path)
        path = path if path.suffix == ".json" else Path(f"{path}.json")
        files = path, path.with_suffix(".safetensors")
        missing = next((file for file in files if not file.exists()), None)
        if missing is not None:
            raise PredictionError(
                f"{missing}: there is no such file; run the study first (make run), or give the "
                "surrogate of another study"
            )
        for file in files:
            if line := damage(file):
                raise PredictionError(line)
        try:
            description, arrays = read_json(files[0]), read_arrays(files[1])
        except TableError as error:
            raise PredictionError(str(error)) from None
        for file, check, content in zip(
            files, (check_description, check_arrays), (description, arrays), strict=True
        ):
            try:
                check(content)
            except PartError as error:
                line = f"{file}: damaged, or not a surrogate ({error}){remedy(file)}"
                raise PredictionError(line) from None
        return cls(description, arrays)

    def predict(
        self, values: Mapping[str, ArrayLike], confidence: float | None = None
    ) -> Prediction:
        """Predict the wear depth rates of some cases.

        Parameters
        ----------
        values : mapping of str to float or array
            The 14 sampled quantities in the units of `abradem.quantities`, broadcast to shape
            (n,). A DataFrame is accepted.
        confidence : float, optional
            Level of the interval, above 0 and at most `highest_confidence`. The default is 0.95,
            or `highest_confidence` if that is lower.

        Returns
        -------
        Prediction
            Rates in mm/s, shape (n,), and the level of the interval.

        Raises
        ------
        PredictionError
            If a quantity is missing, not a number, or physically impossible, if the level is higher
            than the held-out errors can promise, or if the rate is not a positive number.
        """
        columns = _columns(values, self.jet)
        if confidence is None:
            confidence = min(self.usual_confidence, self.highest_confidence)
        factor = self._factor(confidence)
        rows = len(next(iter(columns.values())))
        rate, ratio = np.empty(rows), np.empty(rows)
        for first in range(0, rows, BLOCK):
            part = slice(first, first + BLOCK)
            block = {name: column[part] for name, column in columns.items()}
            z = np.empty((len(block["plate_angle"]), len(self.group_mean)), dtype=np.float32)
            for place, column in enumerate(group_columns(block, self.jet)):
                z[:, place] = (column - self.group_mean[place]) / self.group_scale[place]
            mean, spread = (_run(self.layers[name], z).astype(float) for name in NETWORKS)
            # What overflows is refused below, or makes an interval without an upper end.
            with np.errstate(over="ignore"):
                rate[part] = wear_scale(block, self.jet) * np.exp(mean)
                ratio[part] = np.exp(factor * np.exp(spread))
        wrong = ~(np.isfinite(rate) & (rate > 0.0))
        if wrong.any():
            place = int(np.argmax(wrong))
            where = "" if rows == 1 else f" in row {place + 1}"
            raise PredictionError(
                f"the surrogate gives a wear depth rate of {rate[place]:g} mm/s{where}: the values "
                "are too far from those that it was trained with, or it is damaged"
            )
        with np.errstate(over="ignore"):
            lower, upper = rate / ratio, rate * ratio
        return Prediction(rate, lower, upper, confidence, self._outside(columns))

    def _factor(self, confidence: float) -> float:
        """Half width of the interval in standard deviations, a quantile of held-out errors."""
        if not 0.0 < confidence < 1.0:
            hint = (
                f"; write {confidence / 100.0:g} for {confidence:g} %" if confidence > 1.0 else ""
            )
            raise PredictionError(f"confidence = {confidence!r} must lie between 0 and 1{hint}")
        if confidence > self.highest_confidence:
            raise PredictionError(
                f"confidence = {confidence!r}: the intervals rest on {self.score_count} held-out "
                f"errors, which promise at most {self.highest_confidence:.4g}"
            )
        return conformal_quantile(self._quantiles, confidence)

    def _outside(self, columns: Mapping[str, np.ndarray]) -> list[str]:
        lines = []
        for name, (low, high) in self.ranges.items():
            column = columns[name]
            ends, scale = np.array([[low], [high]]), scales_of([name])
            fixed = bool(held_fixed(ends, scale)[0])
            # A quantity held fixed is the same value if it differs by float noise alone.
            least = SAME * max(abs(low), abs(high), float(scale[0]))
            slack = least if fixed else SLACK * (high - low)
            beyond = (column < low - slack) | (column > high + slack)
            # The wear is exactly proportional to the Archard constant, in any range.
            if name == "archard_constant" or not beyond.any():
                continue
            row, count = quantity(name), int(beyond.sum())
            unit = "" if row.unit == "1" else f" {row.unit}"
            place = int(np.argmax(beyond))
            where = "" if len(column) == 1 else f" in row {place + 1}"
            shown = f"{name} = {column[place]:g}{unit}{where}"
            more = "" if count == 1 else f" (and {count - 1} more)"
            if fixed:
                lines.append(
                    f"{shown}{more}: this quantity was held fixed at {low:g}{unit} in training; "
                    "its effect is unknown to the model, the interval does not hold"
                )
                continue
            lines.append(
                f"{shown}{more} is outside the training range {low:g} ... {high:g}{unit}: "
                "extrapolated, the interval does not hold"
            )
        return lines


def predict(
    values: Mapping[str, ArrayLike],
    model: str | Path | Surrogate = "results/paper/models/surrogate",
    confidence: float | None = None,
) -> Prediction:
    """Predict wear depth rates and their intervals with the surrogate of a study.

    Parameters
    ----------
    values : mapping of str to float or array
        The 14 sampled quantities in the units of `abradem.quantities`; arrays or a DataFrame for
        many cases.
    model : path or Surrogate
        Stem of the files, such as results/paper/models/surrogate.
    confidence : float, optional
        Level of the interval; 0.95, or the highest that the surrogate can promise, by default.

    Returns
    -------
    Prediction
        Rates in mm/s.

    Raises
    ------
    PredictionError
        If the model cannot be read, or a value is invalid.
    """
    surrogate = model if isinstance(model, Surrogate) else Surrogate.load(model)
    return surrogate.predict(values, confidence)


def highest_level(count: int) -> float:
    """Highest level that a conformal interval from ``count`` held-out scores can promise."""
    return count / (count + 1)


def conformal_quantile(ordered: np.ndarray, confidence: float) -> float:
    """Quantile of held-out scores for a conformal interval.

    Of n scores, the one of rank ceil((n + 1) confidence) gives intervals that contain at least
    this share of new rows (Vovk, Gammerman and Shafer 2005, Algorithmic Learning in a Random
    World). For a confidence above n / (n + 1) no rank is high enough, and only an infinite
    interval would do.

    Parameters
    ----------
    ordered : ndarray, shape (n,)
        Scores in ascending order.
    confidence : float
        Level of the interval, above 0 and at most `highest_level` of n.

    Raises
    ------
    ValueError
        If the scores cannot promise this level.
    """
    count = len(ordered)
    # (n + 1) n / (n + 1) need not be n exactly.
    rank = max(1, int(np.ceil((count + 1) * confidence - 1e-9)))
    if not (confidence > 0.0 and rank <= count):
        raise ValueError(
            f"confidence = {confidence!r} is not above 0 and at most {highest_level(count):.4g}, "
            f"which {count} scores can promise"
        )
    return float(ordered[rank - 1])


def _columns(values: Mapping, jet: Jet) -> dict[str, np.ndarray]:
    """The sampled quantities, checked, as arrays of the same length."""
    missing = [name for name in SAMPLED_NAMES if name not in values]
    if missing:
        raise PredictionError(f"missing: {', '.join(missing)}")
    columns = {}
    problems = []
    for row in SAMPLED:
        try:
            column = np.atleast_1d(np.asarray(values[row.name], dtype=float))
        except (TypeError, ValueError):
            problems.append(f"{row.name} = {values[row.name]!r} is not a number")
            continue
        low, high = row.limits
        wrong = ~((column >= low) & (column <= high))
        if wrong.any():
            place = int(np.argmax(wrong))
            where = "" if len(column) == 1 else f" in row {place + 1}"
            problems.append(str(impossible(row.name, float(column[place]), where)))
        columns[row.name] = column
    if problems:
        raise PredictionError("\n".join(problems))
    try:
        columns = dict(zip(columns, np.broadcast_arrays(*columns.values()), strict=True))
    except ValueError:
        lengths = {name: len(column) for name, column in columns.items() if len(column) > 1}
        raise PredictionError(f"columns of different length: {lengths}") from None
    if not np.all(squared_impact_speed(columns, jet) > 0.0):
        raise PredictionError("particles without initial velocity that do not fall cause no wear")
    return columns


def _layers(arrays: Mapping[str, np.ndarray], name: str) -> Sequence[tuple[np.ndarray, np.ndarray]]:
    count = sum(key.startswith(f"{name}_weights_") for key in arrays)
    if not count:
        raise KeyError(f"{name}_weights_0")
    return [(arrays[f"{name}_weights_{i}"], arrays[f"{name}_biases_{i}"]) for i in range(count)]


def _run(layers: Sequence[tuple[np.ndarray, np.ndarray]], z: np.ndarray) -> np.ndarray:
    """Output of a network with rectified linear units for rows (n, p), shape (n,)."""
    for place, (weights, biases) in enumerate(layers):
        if place:
            np.maximum(z, 0.0, out=z)
        z = z @ weights
        z += biases
    return z[:, 0]
