"""NAME=VALUE on the command line: blanks around "=", units, presets, lists, what is misspelt."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from abradem.config.materials import PARTICLE_MATERIALS, material_name, preset, similar_material
from abradem.dataset.known_names import hint_for, known_quantity, normal
from abradem.quantities import SAMPLED_NAMES, impossible, quantity
from abradem.surrogate.geometry_groups import numbers_of, places_of
from abradem.surrogate.model import PredictionError
from abradem.units import has_unit, parse_quantity, parse_value

_LEVEL = re.compile(r"([0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?\s*(%?)")


class Given(NamedTuple):
    """Quantities of a command line.

    Attributes
    ----------
    values : dict of str to float
        In the units of `abradem.quantities`; the command line takes precedence over the preset.
    origins : dict of str to str
        "command line" or the name of the preset.
    """

    values: dict[str, float]
    origins: dict[str, str]


class Swept(NamedTuple):
    """Quantities of a sweep: those with one value, and the values of the others in their order."""

    fixed: Given
    lists: dict[str, tuple[float, ...]]


COMMAND_LINE = "command line"

MOST_VALUES = 10_000
"""Largest number of values of one quantity of a sweep."""

LEAST_PERCENT = 50.0
"""Smallest number that is taken for percent without the mark: 1.5 may be a slip of 0.15 or 15."""


def given_values(
    texts: Sequence[str], material: str | None, geometry: Mapping | None = None
) -> Given:
    """Read the values of a command line and of a preset.

    Parameters
    ----------
    texts : sequence of str
        Words such as "particle_radius=20mm"; a word without "=" continues the value before it.
    material : str or None
        Name of a preset.
    geometry : mapping or None
        Whose numbers are quantities as well, see `quantity_named`.

    Raises
    ------
    PredictionError
        With one line for each problem; all misspelt names are in one line.
    """
    swept = _read(texts, material, geometry, lists=False)
    return swept.fixed


def swept_values(
    texts: Sequence[str], material: str | None, geometry: Mapping | None = None
) -> Swept:
    """Read the values of a sweep, each a value, a list or a range, and of a preset.

    Parameters
    ----------
    texts : sequence of str
        Words such as "particle_radius=10mm,20mm" or "plate_angle=0:70:5" (first, last, step; the
        last value belongs to the range if a step ends on it). A unit behind the last number alone
        is that of all.
    material : str or None
        Name of a preset.
    geometry : mapping or None
        Whose numbers are quantities as well, see `quantity_named`.

    Raises
    ------
    PredictionError
        With one line for each problem.
    """
    return _read(texts, material, geometry, lists=True)


def quantity_named(text: str, geometry: Mapping | None) -> tuple[str, str | None] | None:
    """Return the quantity that a name stands for and the unit in the name, or None.

    Parameters
    ----------
    text : str
        Such as "plate_angle" or, of a geometry, "arc.radius", "lower.angle" for the plate named
        "lower", or "plate_2_angle".
    geometry : mapping or None
        Plain values, see `abradem.surrogate.geometry_groups.numbers_of`.
    """
    numbers = numbers_of(geometry)
    found = known_quantity(text, SAMPLED_NAMES)
    if found is not None or not numbers:
        return found
    key = normal(text)
    for part, place in places_of(geometry).items():
        if key.startswith(f"{normal(part)}_"):
            key = f"{place}_{key.removeprefix(f'{normal(part)}_')}"
            break
    found = known_quantity(key, numbers)
    if found is None:
        return None
    name, unit = found
    # A plate may have the sampled plate angle.
    other = numbers[name]
    return (other if isinstance(other, str) else name), unit


def _read(
    texts: Sequence[str], material: str | None, geometry: Mapping | None, lists: bool
) -> Swept:
    values: dict[str, float] = {}
    origins: dict[str, str] = {}
    several: dict[str, tuple[float, ...]] = {}
    problems, unknown, seen = [], [], set()
    if material is not None:
        try:
            particle = _particle_material(material)
        except PredictionError as error:
            problems.append(str(error))
        else:
            values |= preset(particle)
            origins |= dict.fromkeys(values, particle)
    for text in _assignments(texts):
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            problems.append(f"{text!r} is not of the form NAME=VALUE")
            continue
        known = quantity_named(name, geometry)
        if known is None:
            unknown.append(name)
        elif known[0] in seen:
            problems.append(f"{known[0]} is given twice")
        elif not value:
            problems.append(f"{name} has no value")
        else:
            quantity_name, unit = known
            seen.add(quantity_name)
            try:
                if lists and ("," in value or ":" in value):
                    several[quantity_name] = _values_of(quantity_name, value, unit)
                    values.pop(quantity_name, None)
                else:
                    values[quantity_name] = parse_value(quantity_name, value, unit)
                origins[quantity_name] = COMMAND_LINE
            except ValueError as error:
                problems.append(str(error))
    if unknown:
        problems.insert(0, _unknown(unknown, geometry))
    if problems:
        # What is possible is checked again where the values are used.
        problems += impossible_values({**values, **several})
        raise PredictionError("\n".join(problems))
    return Swept(Given(values, origins), several)


def impossible_values(values: Mapping[str, float | Sequence[float]]) -> list[str]:
    """Return one line for each value, or value of a list, that is impossible."""
    lines = [
        impossible(name, number)
        for name, numbers in values.items()
        for number in ([numbers] if isinstance(numbers, (int, float)) else numbers)
    ]
    return [line for line in lines if line]


def _values_of(name: str, text: str, unit: str | None) -> tuple[float, ...]:
    """Return the values of a list or of a range."""
    mark = ":" if ":" in text else ","
    words = [word.strip() for word in text.split(mark)]
    if mark == ":" and (len(words) != 3 or "," in text):
        raise ValueError(f"{name} = {text!r} is not a range FIRST:LAST:STEP or a list A,B,C")
    if not all(words):
        raise ValueError(f"{name} = {text!r} has an empty place")
    if has_unit(words[-1]) and not any(has_unit(word) for word in words[:-1]):
        unit = _unit_behind(words[-1])
    numbers = [parse_value(name, word, unit) for word in words]
    if mark == ",":
        if len(set(numbers)) < len(numbers):
            raise ValueError(f"{name} = {text!r} holds a value twice")
        return tuple(numbers)
    first, last, step = numbers
    steps = (last - first) / step if step else math.nan
    if not steps >= 0.0:
        raise ValueError(f"{name} = {text!r}: the step does not lead from the first to the last")
    if steps > MOST_VALUES:
        raise ValueError(f"{name} = {text!r} has more than {MOST_VALUES} values")
    # A last value missed by rounding alone belongs to the range.
    count = math.floor(steps + 1e-9) + 1
    ends = abs(steps - (count - 1)) <= 1e-9
    return tuple(
        last if ends and place == count - 1 and count > 1 else first + place * step
        for place in range(count)
    )


def _unit_behind(text: str) -> str:
    """Return the unit behind a number."""
    found = re.match(r"[-+−]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+−]?[0-9]+)?\s*(.*)", text)
    return found.group(1) if found else ""


def _assignments(texts: Sequence[str]) -> list[str]:
    found: list[str] = []
    for text in texts:
        if "=" not in text and found and "=" in found[-1]:
            found[-1] += f" {text}"
        else:
            found.append(text)
    return found


def _unknown(names: Sequence[str], geometry: Mapping | None) -> str:
    """Return one line on all names that are no quantities."""
    allowed = (*SAMPLED_NAMES, *numbers_of(geometry))
    hints = [hint_for(name, allowed) for name in names]
    shown = [f"{name} ({hint})" if hint else name for name, hint in zip(names, hints, strict=True)]
    known = "" if all(hints) else f"; known are {', '.join(allowed)}"
    plural = "no such quantity" if len(names) == 1 else "no such quantities"
    return f"{', '.join(shown)}: {plural}{known}"


def add_material_argument(parser: argparse.ArgumentParser) -> None:
    """Add the argument that names a preset of particles."""
    parser.add_argument(
        "--material",
        metavar="NAME",
        help="preset for the quantities that are not given, on a steel plate: "
        + ", ".join(sorted(PARTICLE_MATERIALS)),
    )


def say_preset(given: Given) -> None:
    """Print the quantities that come from a preset, if any does."""
    presets = [
        (value_text(name, given.values[name]), origin)
        for name, origin in sorted(given.origins.items())
        if origin in PARTICLE_MATERIALS
    ]
    if presets:
        values = ", ".join(text for text, _ in presets)
        print(f"from the preset {presets[0][1]}: {values}", file=sys.stderr)


def _particle_material(text: str) -> str:
    """Return the name of a preset of particles; raise if there is none."""
    name = material_name(text)
    if name in PARTICLE_MATERIALS:
        return name
    close = similar_material(text, PARTICLE_MATERIALS)
    hint = f", did you mean {close}?" if close else ""
    raise PredictionError(
        f"--material {text}: no such preset{hint} (allowed {', '.join(sorted(PARTICLE_MATERIALS))})"
    )


def confidence_level(text: str) -> float:
    """Return a level between 0 and 1 of a text such as "0.95", "95" or "95 %"."""
    found = _LEVEL.fullmatch(text.strip())
    if not found:
        comma = ", with a decimal point instead of the comma" if "," in text else ""
        raise PredictionError(f"--confidence {text}: is not a number{comma}")
    number = float(text.strip().removesuffix("%"))
    if found.group(2) or LEAST_PERCENT <= number < 100.0:
        number /= 100.0
    if not 0.0 < number < 1.0:
        raise PredictionError(
            f"--confidence {text}: must lie between 0 and 1, or between {LEAST_PERCENT:g} and 100, "
            "in percent"
        )
    return number


def depth_mm(text: str) -> float:
    """Return a depth in mm of a text such as "5mm" or "5"."""
    try:
        depth = 1e3 * parse_quantity(text, "m", default="mm")
    except ValueError as error:
        raise PredictionError(f"--depth {text}: {error}") from None
    if not depth > 0.0:
        raise PredictionError(f"--depth {text}: must be positive")
    return depth


def hours_of(text: str) -> float:
    """Return a time in hours of a text such as "1000", "1000h" or "3.6e6 s"."""
    try:
        hours = parse_quantity(text, "h")
    except ValueError as error:
        raise PredictionError(f"--hours {text}: {error}") from None
    if not hours > 0.0:
        raise PredictionError(f"--hours {text}: must be positive")
    return hours


def sought_quantity(
    option: str, text: str, given: Given, geometry: Mapping | None = None
) -> tuple[str, tuple[float, float] | None]:
    """Return the quantity of a text such as "plate_angle" or "plate_angle=20:60deg", and its range.

    Parameters
    ----------
    option : str
        Of the command line, for the messages.
    text : str
    given : Given
        A quantity that is sought may be in its preset, not on the command line.
    geometry : mapping or None
        See `quantity_named`.

    Raises
    ------
    PredictionError
        With one line.
    """
    word, equals, behind = (part.strip() for part in text.partition("="))
    known = quantity_named(word, geometry)
    if known is None:
        raise PredictionError(f"{option} {text}: {_unknown([word], geometry)}")
    name, unit = known
    if given.origins.get(name) == COMMAND_LINE:
        raise PredictionError(f"{option} {text}: {name} is also given as a value; leave one out")
    if not equals:
        return name, None
    ends = [end.strip() for end in behind.split(":")]
    if len(ends) != 2 or not all(ends):
        raise PredictionError(f"{option} {text}: {behind!r} is not a range FROM:TO")
    if has_unit(ends[1]) and not has_unit(ends[0]):
        unit = _unit_behind(ends[1])
    try:
        low, high = (parse_value(name, end, unit) for end in ends)
    except ValueError as error:
        raise PredictionError(f"{option} {text}: {error}") from None
    problems = impossible_values({name: (low, high)})
    if problems or not low < high:
        reason = problems[0] if problems else f"{low:g} is not below {high:g}"
        raise PredictionError(f"{option} {text}: {reason}")
    return name, (low, high)


def value_text(name: str, value: float) -> str:
    """Return a value of a quantity as text with its unit."""
    unit = quantity(name).unit
    return f"{name} = {value:.6g}{'' if unit == '1' else f' {unit}'}"
