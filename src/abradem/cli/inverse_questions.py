"""`abradem predict --solve` and `--extremes`: inverse questions about a wear depth."""

from __future__ import annotations

from typing import NamedTuple

from abradem.cli.given_values import Given, say_preset, sought_quantity, value_text
from abradem.cli.predict_words import (
    NO_END,
    fixed_words,
    level_text,
    place_words,
    rate_text,
    warn,
)
from abradem.learning.number_text import number_or_words
from abradem.quantities import quantity, wear_parts
from abradem.surrogate.inverse import CLOSED_FORM, least_and_greatest, range_of, solve
from abradem.surrogate.model import SECONDS_PER_HOUR, PredictionError, Surrogate


class Depth(NamedTuple):
    """A wear depth, mm, that is reached after some hours."""

    depth: float
    hours: float

    @property
    def rate(self) -> float:
        """Wear depth rate, mm/s."""
        return self.depth / (SECONDS_PER_HOUR * self.hours)

    @property
    def words(self) -> str:
        """Such as "5 mm in 1000 h"."""
        return f"{self.depth:g} mm in {self.hours:g} h"


def target_of(surrogate: Surrogate, text: str | None) -> str:
    """Return the wear rate of a surrogate that is named in full or by its statistic alone."""
    names = list(surrogate.models)
    if text is None:
        return names[0]
    plain = text.strip().lower()
    for name in names:
        if plain in (name, wear_parts(name)[1]):
            return name
    raise PredictionError(f"--target {text}: this surrogate predicts {', '.join(names)}")


def print_solution(
    surrogate: Surrogate, given: Given, text: str, wanted: Depth, level: float | None, target: str
) -> None:
    """Print the values of a quantity with which a depth is worn in some hours."""
    name, ends = _sought(surrogate, "--solve", text, given)
    if name == CLOSED_FORM and ends is not None:
        raise PredictionError(f"--solve {text}: {name} needs no range, the wear is proportional")
    others = _without(given, name)
    found = solve(surrogate, others.values, name, wanted.rate, level, target, ends)
    roots = [
        surrogate.predict({**others.values, name: root}, level, target) for root in found.roots
    ]
    warn(dict.fromkeys(line for one in roots for line in one.warnings))
    say_preset(others)
    unit = "" if quantity(name).unit == "1" else f" {quantity(name).unit}"
    interval = f"{level_text(found.confidence, surrogate, target)} interval"
    what = f"for {wanted.words} ({target}: {place_words(surrogate, target)})"
    if name == CLOSED_FORM:
        (root,), ((low, high),) = found.roots, found.spans
        print(
            f"{name} = {root:.4g}{unit}, {interval} {low:.4g} to "
            f"{number_or_words(high, '.4g', NO_END)}{unit}, {what}"
        )
        return
    low, high = range_of(surrogate, name, ends)
    if len(found.roots):
        values = " or ".join(f"{root:.4g}" for root in found.roots)
        print(f"{name} = {values}{unit}, {what}; all values in {low:g} ... {high:g}{unit}")
    else:
        hours = SECONDS_PER_HOUR * wanted.hours
        print(
            f"none: no {name} in {low:g} ... {high:g}{unit} {what}; "
            f"{found.least * hours:.4g} to {found.greatest * hours:.4g} mm are worn"
        )
    if found.spans:
        spans = " and ".join(f"{first:.4g} ... {last:.4g}" for first, last in found.spans)
        print(f"{name} in {spans}{unit} has {wanted.words} in its {interval}")


def print_extremes(
    surrogate: Surrogate, given: Given, text: str, level: float | None, target: str
) -> None:
    """Print the least and the greatest wear depth rate over the range of a quantity."""
    name, ends = _sought(surrogate, "--extremes", text, given)
    others = _without(given, name)
    found = least_and_greatest(surrogate, others.values, name, level, target, ends)
    warn(dict.fromkeys(line for one in found.predictions for line in one.warnings))
    say_preset(others)
    for word, value, one in zip(
        ("least", "greatest"), found.values, found.predictions, strict=True
    ):
        said = rate_text(surrogate, target, one)
        print(f"{word} wear depth rate at {value_text(name, value)}: {said}")


def _sought(surrogate: Surrogate, option: str, text: str, given: Given):
    """Return the quantity that is sought and its range; raise if the surrogate has none such."""
    name, ends = sought_quantity(option, text, given, surrogate.jet.geometry)
    if name not in surrogate.ranges:
        raise PredictionError(f"{option} {text}: {fixed_words(surrogate, [name])}")
    return name, ends


def _without(given: Given, name: str) -> Given:
    """Return the quantities without one that a preset may hold."""
    values = {key: value for key, value in given.values.items() if key != name}
    return Given(values, {key: given.origins[key] for key in values})
