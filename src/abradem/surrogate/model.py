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

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from abradem.store.checksums import remedy
from abradem.surrogate.domain import Domain, warnings_on
from abradem.surrogate.groups import Jet, group_columns, wear_scale
from abradem.surrogate.inputs import PredictionError, checked_columns
from abradem.surrogate.networks import RateModel, rate_models
from abradem.surrogate.parts import PartError, check_arrays, check_description, local_names
from abradem.surrogate.stored import stored_model

BLOCK = 4096
"""Number of rows computed at once, few enough for the processor's cache."""

SECONDS_PER_HOUR = 3600.0


class Prediction(NamedTuple):
    """Wear depth rates of n cases at one place of the plate, such as its mean or worst element.

    Attributes
    ----------
    rate, lower, upper : ndarray, shape (n,)
        Median and interval, mm/s.
    confidence : float
        Level of the interval: the share of simulated cases inside such intervals.
    warnings : list of str
        What is unlike the training cases, see `abradem.surrogate.domain`: one line for each
        quantity, and one on cases that are far from all of them.
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
            Wear depth, mm, of what the rate is that was predicted: in the mean over the plate, for
            example. Nothing is worn deeper than the worst element.

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
        Training range of each sampled quantity, also of a geometry.
    group_mean, group_scale : ndarray, shape (10 and those of a geometry,)
        Scaling of the groups.
    models : dict of str to RateModel
        Networks and held-out errors of each wear rate by its name; the target of the study is the
        first.
    domain : Domain or None
        The training cases, if the surrogate holds them.
    """

    def __init__(self, description: Mapping, arrays: Mapping[str, np.ndarray]):
        self.description = dict(description)
        self.jet = Jet(**description["jet"])
        self.ranges = {
            feature["name"]: tuple(feature["training_range"]) for feature in description["features"]
        }
        self.group_mean, self.group_scale = arrays["group_mean"], arrays["group_scale"]
        self.models = rate_models(description, arrays)
        self.domain = (
            Domain(arrays["domain_rows"], arrays["domain_slopes"], description["domain"]["limit"])
            if "domain" in description
            else None
        )

    usual_confidence = 0.95
    """Level of an interval for which no level is asked."""

    @property
    def highest_confidence(self) -> float:
        """Highest level of an interval that the held-out errors of the target can promise."""
        return highest_level(self.model().score_count)

    def model(self, target: str | None = None) -> RateModel:
        """Model of a wear rate; by default of the target of the study.

        Raises
        ------
        PredictionError
            If the surrogate does not predict this wear rate.
        """
        if target is None:
            return next(iter(self.models.values()))
        if target not in self.models:
            raise PredictionError(
                f"target {target!r}: this surrogate predicts {', '.join(self.models)}"
            )
        return self.models[target]

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
        description, arrays = stored_model(
            path, "run the study first (make run), or give the surrogate of another study"
        )
        file = path
        try:
            check_description(description)
            file = path.with_suffix(".safetensors")
            check_arrays(
                arrays,
                len(description["groups"]),
                local_names(description),
                "domain" in description,
            )
        except PartError as error:
            line = f"{file}: damaged, or not a surrogate ({error}){remedy(file)}"
            raise PredictionError(line) from None
        return cls(description, arrays)

    def predict_all(
        self, values: Mapping[str, ArrayLike], confidence: float | None = None
    ) -> dict[str, Prediction]:
        """Predict every wear rate of the surrogate, see `predict`.

        Returns
        -------
        dict of str to Prediction
            By the names of the wear rates, that of the study first.
        """
        return {name: self.predict(values, confidence, name) for name in self.models}

    def predict(
        self,
        values: Mapping[str, ArrayLike],
        confidence: float | None = None,
        target: str | None = None,
    ) -> Prediction:
        """Predict the wear depth rates of some cases.

        Parameters
        ----------
        values : mapping of str to float or array
            The 14 sampled quantities, and those of the geometry that were sampled
            (`abradem.surrogate.groups.input_names`), in the units of `abradem.quantities`,
            broadcast to shape (n,). A DataFrame is accepted.
        confidence : float, optional
            Level of the interval, above 0 and at most `highest_confidence`. The default is 0.95,
            or `highest_confidence` if that is lower.
        target : str, optional
            One of `models`, such as "wear_friction_max"; by default the target of the study.

        Returns
        -------
        Prediction
            Rates in mm/s, shape (n,), and the level of the interval.

        Raises
        ------
        PredictionError
            If a quantity is missing, not a number, or physically impossible, if the level is higher
            than the held-out errors can promise, if the surrogate has no such target, or if the
            rate is not a positive number.
        """
        asked = self.model(target)
        columns = checked_columns(values, self.jet)
        if confidence is None:
            confidence = min(self.usual_confidence, highest_level(asked.score_count))
        factor = self._factor(asked, confidence)
        rows = len(next(iter(columns.values())))
        rate, ratio, far = np.empty(rows), np.empty(rows), np.zeros(rows, dtype=bool)
        for first in range(0, rows, BLOCK):
            part = slice(first, first + BLOCK)
            block = {name: column[part] for name, column in columns.items()}
            z = self._standardised(block)
            mean, spread = asked.log_number(z)
            if asked.at_least is not None:
                mean = np.maximum(mean, self.models[asked.at_least].log_number(z)[0])
            # What overflows is refused below, or makes an interval without an upper end.
            with np.errstate(over="ignore"):
                rate[part] = wear_scale(block, self.jet) * np.exp(mean)
                ratio[part] = np.exp(factor * np.exp(spread))
            if self.domain is not None:
                far[part] = self.domain.distance(z) > self.domain.limit
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
        warnings = warnings_on(
            columns, self.ranges, lambda some: asked.log_number(self._standardised(some)), far
        )
        return Prediction(rate, lower, upper, confidence, warnings)

    def _standardised(self, columns: Mapping[str, np.ndarray]) -> np.ndarray:
        """Standardised groups, shape (n, p), of checked quantities (n,)."""
        z = np.empty((len(columns["plate_angle"]), len(self.group_mean)))
        for place, column in enumerate(group_columns(columns, self.jet)):
            z[:, place] = (column - self.group_mean[place]) / self.group_scale[place]
        return z

    def _factor(self, model: RateModel, confidence: float) -> float:
        """Half width of the interval in standard deviations, a quantile of held-out errors."""
        if not 0.0 < confidence < 1.0:
            hint = (
                f"; write {confidence / 100.0:g} for {confidence:g} %" if confidence > 1.0 else ""
            )
            raise PredictionError(f"confidence = {confidence!r} must lie between 0 and 1{hint}")
        if confidence > highest_level(model.score_count):
            raise PredictionError(
                f"confidence = {confidence:.12g}: the intervals rest on {model.score_count} "
                f"held-out errors, which promise at most {highest_level(model.score_count):.4g}"
            )
        return conformal_quantile(model.scores, confidence)


def predict(
    values: Mapping[str, ArrayLike],
    model: str | Path | Surrogate = "results/paper/models/surrogate",
    confidence: float | None = None,
    target: str | None = None,
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
    target : str, optional
        Wear rate, such as "wear_friction_max" (the worst element), "wear_friction_p99",
        "wear_friction_footprint" or "wear_friction_mean"; by default the target of the study.

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
    return surrogate.predict(values, confidence, target)


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
