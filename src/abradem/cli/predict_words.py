"""Predictions of a surrogate in words, as the commands print them."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from abradem.learning.number_text import number_or_words
from abradem.quantities import GEOMETRY_UNITS
from abradem.surrogate.geometry_groups import numbers_of, sampled_names
from abradem.surrogate.model import Prediction, Surrogate, highest_level
from abradem.words.wear import place_of

NO_END = "any number of"


def rate_text(surrogate: Surrogate, name: str, prediction: Prediction) -> str:
    """Return the rate of the first case, its interval, and of what place of the plate it is."""
    rate, low, high = (float(column[0]) for column in prediction[:3])
    unit = surrogate.models[name].target["unit"]
    level = level_text(prediction.confidence, surrogate, name)
    return (
        f"{rate:.4g} {unit}, {level} interval {low:.4g} to "
        f"{number_or_words(high, '.4g', NO_END)} {unit} ({name}: {place_words(surrogate, name)})"
    )


def level_text(confidence: float, surrogate: Surrogate, name: str | None = None) -> str:
    """Return the level of an interval in percent, and why it is below the usual one."""
    text = f"{100.0 * confidence:.4g} %"
    count = surrogate.model(name).score_count
    if confidence == highest_level(count) < surrogate.usual_confidence:
        text += f" (the highest that {count} held-out errors promise)"
    return text


def place_words(surrogate: Surrogate, name: str | None = None) -> str:
    """Return of what place of the plate a rate of a surrogate is, by default its target."""
    target = surrogate.model(name).target
    return place_of(target)


def depth_words(surrogate: Surrogate, name: str | None = None) -> str:
    """Return of what a depth is that a surrogate predicts, in words."""
    words = f"depth {place_words(surrogate, name)}"
    target = surrogate.model(name).target
    if target["name"].endswith("_max") or not target.get("known", True):
        return words
    return f"{words}; single places are worn deeper"


def fixed_words(surrogate: Surrogate, names: Iterable[str]) -> str:
    """Return that numbers of a geometry are fixed in the study of a surrogate, in words."""
    numbers = numbers_of(surrogate.jet.geometry)
    listed = ", ".join(f"{name} at {numbers[name]:g} {GEOMETRY_UNITS[name]}" for name in names)
    varied = ", ".join(sampled_names(surrogate.jet.geometry)) or "none"
    return f"fixed in the study of this surrogate: {listed} (allowed of its geometry: {varied})"


def warn(lines: Iterable[str]) -> None:
    """Print warnings to stderr."""
    for line in lines:
        print(f"warning: {line}", file=sys.stderr)
