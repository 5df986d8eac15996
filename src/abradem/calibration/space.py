"""The unknowns of a set-up, and set-ups drawn from them as a Sobol sequence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

DIGITS = 3
"""Significant digits of drawn numbers, so that a set-up can be written and read."""


class Unknown(NamedTuple):
    """A key of the configuration that the user does not know.

    Attributes
    ----------
    keys : tuple of str
        Dotted keys that all take the same value, such as the two sides of a square patch.
    choices : tuple
        The values to choose from; empty for a number between ``low`` and ``high``.
    low, high : float
        Bounds of a number, in the unit of the key.
    log : bool
        Whether the logarithm of the number is drawn evenly.
    """

    keys: tuple[str, ...]
    choices: tuple
    low: float = math.nan
    high: float = math.nan
    log: bool = False

    @property
    def name(self) -> str:
        """The keys as they are written in the configuration."""
        return ", ".join(self.keys)


def unknowns(search: Mapping) -> list[Unknown]:
    """Read a search space.

    Parameters
    ----------
    search : mapping
        For each key (or keys, separated by commas) a list of choices, or a mapping with ``from``,
        ``to`` and optionally ``scale`` ("linear" or "log").

    Raises
    ------
    ValueError
        With the key and what is allowed.
    """
    found: list[Unknown] = []
    seen: set[str] = set()
    for name, values in search.items():
        keys = tuple(key.strip() for key in str(name).split(","))
        for key in keys:
            if not key.startswith("simulation."):
                raise ValueError(f"{key}: is no key of a simulation (allowed simulation. ...)")
            if key in seen:
                raise ValueError(f"{key}: is given twice")
            seen.add(key)
        found.append(_unknown(keys, values))
    return found


def _unknown(keys: tuple[str, ...], values) -> Unknown:
    name = ", ".join(keys)
    if isinstance(values, (list, tuple)):
        if len(values) < 2 or any(isinstance(one, (list, dict)) for one in values):
            raise ValueError(f"{name}: needs at least two plain values to choose from")
        if len({_same(one) for one in values}) < len(values):
            raise ValueError(f"{name}: holds a value twice")
        return Unknown(keys, tuple(values))
    if not isinstance(values, Mapping) or not {"from", "to"} <= set(values) <= {
        "from",
        "to",
        "scale",
    }:
        raise ValueError(f"{name}: must be a list of values or {{from: ..., to: ...}}")
    low, high, scale = values["from"], values["to"], values.get("scale", "linear")
    for bound in (low, high):
        if isinstance(bound, bool) or not isinstance(bound, (int, float)):
            raise ValueError(f"{name}: {bound!r} is not a number")
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"{name}: from = {low!r} must be below to = {high!r}")
    if scale not in ("linear", "log"):
        raise ValueError(f"{name}: scale = {scale!r} is unknown (allowed linear, log)")
    if scale == "log" and low <= 0.0:
        raise ValueError(f"{name}: from = {low!r} must be positive on a logarithmic scale")
    return Unknown(keys, (), float(low), float(high), scale == "log")


def _same(value) -> tuple:
    """What two choices have in common that are the same value, up to rounding of their units."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return ("number", f"{value:.12g}") if number else (type(value).__name__, value)


def draw(space: list[Unknown], count: int, seed: int) -> list[dict[str, object]]:
    """Draw set-ups evenly from the space, as a scrambled Sobol sequence (Sobol 1967).

    Parameters
    ----------
    space : list of Unknown
    count : int
        Number of set-ups; powers of two fill the space evenly.
    seed : int

    Returns
    -------
    list of dict
        For each set-up the value of each unknown by `Unknown.name`.
    """
    import warnings

    from scipy.stats import qmc

    with warnings.catch_warnings():
        # A number of set-ups that is not a power of two is less even, but not wrong.
        warnings.simplefilter("ignore", UserWarning)
        points = qmc.Sobol(len(space), rng=np.random.default_rng([seed, 1])).random(count)
    return [
        {one.name: _value(one, float(u)) for one, u in zip(space, point, strict=True)}
        for point in points
    ]


def _value(unknown: Unknown, u: float):
    if unknown.choices:
        return unknown.choices[min(int(u * len(unknown.choices)), len(unknown.choices) - 1)]
    if unknown.log:
        value = unknown.low * (unknown.high / unknown.low) ** u
    else:
        value = unknown.low + u * (unknown.high - unknown.low)
    return min(max(float(f"{value:.{DIGITS}g}"), unknown.low), unknown.high)


def keys_of(values: Mapping[str, object]) -> dict[str, object]:
    """Return the value of each single key of a drawn set-up."""
    return {key.strip(): value for name, value in values.items() for key in name.split(",")}
