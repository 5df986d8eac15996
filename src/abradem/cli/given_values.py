"""NAME=VALUE on the command line: blanks around "=", units, presets, and what is misspelt."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from abradem.config.materials import PARTICLE_MATERIALS, material_name, preset, similar_material
from abradem.dataset.known_names import hint_for, known_quantity
from abradem.quantities import SAMPLED_NAMES, quantity
from abradem.surrogate.model import PredictionError
from abradem.units import parse_quantity, parse_value

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


COMMAND_LINE = "command line"

LEAST_PERCENT = 50.0
"""Smallest number that is taken for percent without the mark: 1.5 may be a slip of 0.15 or 15."""


def given_values(texts: Sequence[str], material: str | None) -> Given:
    """Read the values of a command line and of a preset.

    Parameters
    ----------
    texts : sequence of str
        Words such as "particle_radius=20mm"; a word without "=" continues the value before it.
    material : str or None
        Name of a preset.

    Raises
    ------
    PredictionError
        With one line for each problem; all misspelt names are in one line.
    """
    values: dict[str, float] = {}
    origins: dict[str, str] = {}
    if material is not None:
        particle = _particle_material(material)
        values |= preset(particle)
        origins |= dict.fromkeys(values, particle)
    problems, unknown, seen = [], [], set()
    for text in _assignments(texts):
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            problems.append(f"{text!r} is not of the form NAME=VALUE")
            continue
        known = known_quantity(name, SAMPLED_NAMES)
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
                values[quantity_name] = parse_value(quantity_name, value, unit)
                origins[quantity_name] = COMMAND_LINE
            except ValueError as error:
                problems.append(str(error))
    if unknown:
        problems.insert(0, _unknown(unknown))
    if problems:
        raise PredictionError("\n".join(problems))
    return Given(values, origins)


def _assignments(texts: Sequence[str]) -> list[str]:
    found: list[str] = []
    for text in texts:
        if "=" not in text and found and "=" in found[-1]:
            found[-1] += f" {text}"
        else:
            found.append(text)
    return found


def _unknown(names: Sequence[str]) -> str:
    """Return one line on all names that are no quantities."""
    hints = [hint_for(name, SAMPLED_NAMES) for name in names]
    shown = [f"{name} ({hint})" if hint else name for name, hint in zip(names, hints, strict=True)]
    known = "" if all(hints) else f"; known are {', '.join(SAMPLED_NAMES)}"
    plural = "no such quantity" if len(names) == 1 else "no such quantities"
    return f"{', '.join(shown)}: {plural}{known}"


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


def value_text(name: str, value: float) -> str:
    """Return a value of a quantity as text with its unit."""
    unit = quantity(name).unit
    return f"{name} = {value:.6g}{'' if unit == '1' else f' {unit}'}"
