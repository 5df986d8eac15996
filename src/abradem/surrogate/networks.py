"""The networks of a surrogate for one wear rate, and its held-out errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from abradem.surrogate.parts import NETWORKS, local_prefix

Layers = Sequence[tuple[np.ndarray, np.ndarray]]


class RateModel(NamedTuple):
    """What a surrogate knows of one wear rate.

    Attributes
    ----------
    target : mapping
        ``name``, ``unit`` and, where it depends on it, ``element_size`` (m).
    layers : dict of str to list
        Weights and biases of the networks `NETWORKS`, from the input on.
    scores : ndarray, shape (n,)
        Held-out errors over their predicted deviation, in ascending order.
    at_least : str or None
        Name of a wear rate that this one cannot be below, as the worst element is worn at least as
        much as the 99th percentile.
    """

    target: Mapping
    layers: dict[str, Layers]
    scores: np.ndarray
    at_least: str | None = None

    @property
    def score_count(self) -> int:
        """Number of held-out errors behind the intervals."""
        return len(self.scores)

    def log_number(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Logarithm of the wear number and of its deviation, (n,), for standardised groups."""
        mean, spread = (_run(self.layers[name], z).astype(float) for name in NETWORKS)
        return mean, spread


def rate_models(description: Mapping, arrays: Mapping[str, np.ndarray]) -> dict[str, RateModel]:
    """The models of all wear rates of a surrogate by their names, that of the study first."""
    found = {description["target"]["name"]: _rate_model(description, arrays, "")}
    for one in description.get("local", []):
        name = one["target"]["name"]
        found[name] = _rate_model(one, arrays, local_prefix(name))
    return found


def _rate_model(one: Mapping, arrays: Mapping[str, np.ndarray], prefix: str) -> RateModel:
    layers = {name: _layers(arrays, f"{prefix}{name}") for name in NETWORKS}
    scores = np.sort(arrays[f"{prefix}conformal"])
    return RateModel(one["target"], layers, scores, one.get("at_least"))


def _layers(arrays: Mapping[str, np.ndarray], name: str) -> Layers:
    count = sum(key.startswith(f"{name}_weights_") for key in arrays)
    return [(arrays[f"{name}_weights_{i}"], arrays[f"{name}_biases_{i}"]) for i in range(count)]


def _run(layers: Layers, z: np.ndarray) -> np.ndarray:
    """Output of a network with rectified linear units for rows (n, p), shape (n,)."""
    for place, (weights, biases) in enumerate(layers):
        if place:
            np.maximum(z, 0.0, out=z)
        z = z @ weights
        z += biases
    return z[:, 0]
