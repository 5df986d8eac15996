"""Units, and values with units as text: "20 mm", "45°", "−5 m/s", "1e-6 mm³/(N m)".

The one parser of quantities for the configuration, the command line and tables. A unit is a
product of powers of the symbols in `SYMBOLS`, with SI prefixes: ``kg/m3``, ``kg/m^3``, ``kg/m³``,
``kg m^-3``, ``mm³/(N m)``. Conversion is exact in the sense that a value with a unit gives the
floating-point number that is closest to it in the wanted unit.
"""

from __future__ import annotations

import difflib
import math
import re
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from abradem.quantities import quantity

if TYPE_CHECKING:
    import numpy as np

MM_PER_M = 1e3

DIMENSIONS = ("kg", "m", "s", "rad")
"""Units of the base dimensions, in the order of `Unit.powers`."""

_DEGREE = Fraction(180.0 / math.pi)
_FOOT, _POUND, _GRAVITY = Fraction("0.3048"), Fraction("0.45359237"), Fraction("9.80665")

SYMBOLS: dict[str, tuple[Fraction, tuple[int, int, int, int]]] = {
    "g": (Fraction(1, 1000), (1, 0, 0, 0)),
    "t": (Fraction(1000), (1, 0, 0, 0)),
    "m": (Fraction(1), (0, 1, 0, 0)),
    "l": (Fraction(1, 1000), (0, 3, 0, 0)),
    "L": (Fraction(1, 1000), (0, 3, 0, 0)),
    "s": (Fraction(1), (0, 0, 1, 0)),
    "min": (Fraction(60), (0, 0, 1, 0)),
    "h": (Fraction(3600), (0, 0, 1, 0)),
    "N": (Fraction(1), (1, 1, -2, 0)),
    "J": (Fraction(1), (1, 2, -2, 0)),
    "Nm": (Fraction(1), (1, 2, -2, 0)),
    "Pa": (Fraction(1), (1, -1, -2, 0)),
    "bar": (Fraction(100_000), (1, -1, -2, 0)),
    "rad": (Fraction(1), (0, 0, 0, 1)),
    "deg": (1 / _DEGREE, (0, 0, 0, 1)),
    "rev": (360 / _DEGREE, (0, 0, 0, 1)),
    "in": (_FOOT / 12, (0, 1, 0, 0)),
    "ft": (_FOOT, (0, 1, 0, 0)),
    "lb": (_POUND, (1, 0, 0, 0)),
    "psi": (_POUND * _GRAVITY / (_FOOT / 12) ** 2, (1, -1, -2, 0)),
    "ksi": (1000 * _POUND * _GRAVITY / (_FOOT / 12) ** 2, (1, -1, -2, 0)),
}
"""Factor to the base units, and powers of the base dimensions, of each symbol."""

_PREFIXES = {
    "G": Fraction(10**9),
    "M": Fraction(10**6),
    "k": Fraction(10**3),
    "d": Fraction(1, 10),
    "c": Fraction(1, 100),
    "m": Fraction(1, 10**3),
    "u": Fraction(1, 10**6),
    "n": Fraction(1, 10**9),
}
_WITH_PREFIX = {
    "g": "kmu", "t": "k", "m": "kdcmun", "s": "mun", "l": "dcm", "L": "dcm",
    "N": "GMkm", "J": "GMkm", "Nm": "Mkm", "Pa": "GMkm", "bar": "km", "rad": "mu",
}  # fmt: skip
"""Prefixes that a symbol may have; others are more often a slip, such as Grad."""

_WORDS = {
    "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "inch": "in",
    "sec": "s", "second": "s", "seconds": "s", "hr": "h", "hour": "h", "hours": "h",
    "meter": "m", "metre": "m", "meters": "m", "metres": "m", "micron": "um", "microns": "um",
    "millimeter": "mm", "millimetre": "mm", "millimeters": "mm", "millimetres": "mm",
    "centimeter": "cm", "centimetre": "cm", "gram": "g", "grams": "g", "kilogram": "kg",
    "kilograms": "kg", "newton": "N", "pascal": "Pa", "liter": "l", "litre": "l", "minute": "min",
    "minutes": "min", "lbs": "lb", "tonne": "t", "tonnes": "t", "kmh": "km/h", "cc": "cm3",
    "rpm": "rev/min",
}  # fmt: skip

ACCEPTED = {
    "Pa": ("Pa", "kPa", "MPa", "GPa", "N/mm2", "psi"),
    "1/Pa": ("1/Pa", "m2/N", "1/GPa", "mm3/(N m)"),
    "kg/m3": ("kg/m3", "g/cm3", "t/m3"),
    "deg": ("deg", "rad"),
    "m": ("m", "cm", "mm", "um", "in"),
    "m/s": ("m/s", "mm/s", "km/h", "ft/s"),
    "rev/min": ("rev/min", "deg/s", "rad/s"),
    "kg/s": ("kg/s", "g/s", "t/h"),
    "mm/s": ("mm/s", "m/s", "um/s", "mm/h"),
    "s": ("s", "ms", "min", "h"),
    "h": ("h", "min", "s"),
    "1": (),
}
"""Units that messages name for each unit of this package; all others of the dimension do too."""

_TEXT = str.maketrans(
    {
        "−": "-", "‐": "-", "‑": "-", "‒": "-", "–": "-", "＋": "+",
        "µ": "u", "μ": "u", "·": "*", "⋅": "*", "×": "*", "∙": "*", "⁄": "/", "∕": "/",
        "º": "°", "˚": "°", "\u00a0": " ", "\u2009": " ", "\u202f": " ", "\t": " ",
    }
)  # fmt: skip
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[eE]([+-]?[0-9]+))?")
_POWER_OF_TEN = re.compile(r"[*x]\s*10\s*(?:\^|\*\*)\s*([+-]?[0-9]+)(?![0-9.])")
_TEN_TO = re.compile(r"([+-]?)10\s*(?:\^|\*\*)\s*([+-]?[0-9]+)(?![0-9.])")
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]+(?:[eE][+-]?[0-9]+)?(?![0-9,.])")
_TOKEN = re.compile(r"\s*(?:([A-Za-z]+)|([/*()]))")
_EXPONENT = re.compile(r"(?:\s*(?:\^|\*\*)\s*)?([+-]?[0-9]+)")
_DIMENSIONLESS = ("", "1", "-", "none", "dimensionless")
_MOST_CHARACTERS = 80
_LARGEST_EXPONENT = 9
_LARGEST_POWER_OF_TEN = 400


class Unit(NamedTuple):
    """A unit as a factor to the product of powers of kg, m, s and rad."""

    factor: Fraction
    powers: tuple[int, ...]


class UnitError(ValueError):
    """A unit that is unknown, or of another dimension."""


@cache
def parse_unit(text: str) -> Unit:
    """Return the unit of a text such as "kg/m³"; "" and "1" are dimensionless.

    Raises
    ------
    UnitError
        If the text is not a unit.
    """
    plain = re.sub(r"(?<=[A-Za-z0-9])\.(?=[A-Za-z])", "*", _plain(text).strip())
    if plain.lower() in _DIMENSIONLESS:
        return Unit(Fraction(1), (0,) * len(DIMENSIONS))
    if len(plain) > _MOST_CHARACTERS:
        raise UnitError(f"unit {text[:20]!r}... is too long")
    # "1/Pa" is "/Pa"; a 1 elsewhere is none.
    plain = re.sub(r"^1\s*(?=/)", "", plain)
    unit, rest = _product(plain, text, begun=plain.startswith("/"))
    if rest:
        raise UnitError(f"unit {text!r} is unknown")
    return unit


def conversion(unit: str, wanted: str) -> float:
    """Return the factor from ``unit`` to the unit ``wanted``.

    Raises
    ------
    UnitError
        If ``unit`` is unknown or of another dimension.
    """
    return float(_conversion(unit, wanted))


def convert(values: np.ndarray, unit: str, wanted: str) -> np.ndarray:
    """Return numbers in ``unit`` as numbers in the unit ``wanted``.

    Raises
    ------
    UnitError
        If ``unit`` is unknown or of another dimension.
    """
    factor = _conversion(unit, wanted)
    if factor.numerator == 1:
        # 7 / 1000 is the number nearest to 0.007; 7 * 0.001 need not be.
        return values / factor.denominator
    return values * float(factor)


def parse_quantity(text: str, wanted: str, default: str | None = None) -> float:
    """Return the number, in the unit ``wanted``, of a text with or without a unit.

    Parameters
    ----------
    text : str
        For example "20 mm", "45°", "−5 m/s" or "3".
    wanted : str
        Unit of the result.
    default : str, optional
        Unit of a text without a unit; ``wanted`` if it is not given.

    Raises
    ------
    ValueError
        If the text is not a finite number, or the unit is not accepted.
    """
    plain = _plain(text).strip()
    if len(plain) > _MOST_CHARACTERS:
        raise ValueError("is not a number")
    ten = _TEN_TO.match(plain)
    if ten:
        plain = f"{ten.group(1)}1e{ten.group(2)}{plain[ten.end() :]}"
    found = _NUMBER.match(plain)
    if not found:
        raise ValueError("is not a number")
    digits, exponent = found.groups()
    unit = plain[found.end() :].lstrip()
    power = _POWER_OF_TEN.match(unit)
    if power:
        unit = unit[power.end() :].lstrip()
    if unit[:1] in ("*", "^"):
        raise ValueError("is not a number")
    if unit[:1] in (",", ".", "_", "'") or (_NUMBER.match(unit) and unit[:2] != "1/"):
        raise ValueError(_no_number(plain))
    unit = f"1{unit}" if unit.startswith("/") else unit or default or wanted
    exponents = int(exponent or 0), int(power.group(1)) if power else 0
    factor = _conversion(unit, wanted)
    if any(abs(one) > _LARGEST_POWER_OF_TEN for one in exponents):
        raise ValueError("is not a finite number, or too small for one")
    value = Fraction(digits) * Fraction(10) ** sum(exponents) * factor
    try:
        return float(value)
    except OverflowError:
        raise ValueError("is not a finite number") from None


def _no_number(plain: str) -> str:
    """Return why a number that is followed by a mark or another number is none."""
    if _DECIMAL_COMMA.match(plain):
        return "has a decimal comma; write a decimal point"
    if re.match(r"[+-]?[0-9]{1,3}(?:[ ,.'_][0-9]{3})+(?![0-9])", plain):
        return "has separators of thousands; write the digits alone"
    return "is not a number"


def has_unit(text: str) -> bool:
    """Whether a text is a number that is followed by something, such as a unit."""
    plain = _plain(text).strip()
    found = _NUMBER.match(plain)
    return found is not None and found.end() < len(plain)


def parse_value(name: str, text: str, default: str | None = None) -> float:
    """Return the value of a quantity, in its own unit, from text with or without a unit.

    Parameters
    ----------
    name : str
        A quantity of `abradem.quantities`.
    text : str
        For example "20 mm".
    default : str, optional
        Unit of a number without one; that of the quantity if it is not given.

    Returns
    -------
    float
        The value in the unit of the quantity.

    Raises
    ------
    ValueError
        If the text is not a number, or the unit is not accepted for this quantity.
    """
    try:
        return parse_quantity(text, quantity(name).unit, default)
    except UnitError as error:
        raise ValueError(f"{name} = {text!r}: {error}") from None
    except ValueError as error:
        raise ValueError(f"{name} = {text!r} {error}") from None


def accepted(wanted: str) -> tuple[str, ...]:
    """Return the units that messages name for a unit of this package."""
    if wanted in ACCEPTED:
        return ACCEPTED[wanted]
    powers = parse_unit(wanted).powers
    same = (units for unit, units in ACCEPTED.items() if parse_unit(unit).powers == powers)
    return next(same, (wanted,))


def accepted_text(wanted: str) -> str:
    """Return the units that messages name for a unit of this package."""
    units = accepted(wanted)
    return f"allowed {', '.join(units)}" if units else "allowed none, it is a pure number"


def _conversion(text: str, wanted: str) -> Fraction:
    goal = parse_unit(wanted)
    try:
        unit = parse_unit(text)
    except UnitError as error:
        similar = _similar(text, wanted)
        hint = f", did you mean {similar}?" if similar else ""
        raise UnitError(f"{error}{hint} ({accepted_text(wanted)})") from None
    if unit.powers != goal.powers:
        raise UnitError(f"unit {text!r} has another dimension ({accepted_text(wanted)})")
    return unit.factor / goal.factor


def _similar(text: str, wanted: str) -> str:
    units = accepted(wanted)
    same = [unit for unit in units if unit.lower() == text.strip().lower()]
    return (same or difflib.get_close_matches(text, units, n=1, cutoff=0.75) or [""])[0]


def _plain(text: str) -> str:
    """Return the text with plain signs, exponents and blanks, and words for the degree."""
    plain = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+", lambda found: "^" + found[0].translate(_SUPERSCRIPTS), text)
    return plain.translate(_TEXT).replace("°", " deg ")


def _product(text: str, whole: str, inner: bool = False, begun: bool = False) -> tuple[Unit, str]:
    """Return the product at the start of a text, and the rest of it.

    ``inner``: within parentheses. ``begun``: the text begins with the mark after a factor of 1.
    """
    factor, powers = Fraction(1), [0] * len(DIMENSIONS)
    sign, expects = 1, not begun
    while text:
        found = _TOKEN.match(text)
        if not found:
            break
        symbol, mark = found.groups()
        if mark == ")" and inner:
            break
        if mark in ("/", "*"):
            if expects:
                raise UnitError(f"unit {whole!r} is unknown")
            sign, expects = (-1 if mark == "/" else 1), True
            text = text[found.end() :]
            continue
        text = text[found.end() :]
        if mark == "(":
            unit, text = _product(text, whole, inner=True)
            if not text.startswith(")"):
                raise UnitError(f"unit {whole!r} is unknown")
            text = text[1:]
        elif symbol:
            unit = _symbol(symbol, whole)
        else:
            raise UnitError(f"unit {whole!r} is unknown")
        exponent = _EXPONENT.match(text)
        power = sign
        if exponent:
            power *= int(exponent.group(1)[: _LARGEST_EXPONENT + 1])
            text = text[exponent.end() :]
            if abs(power) > _LARGEST_EXPONENT:
                raise UnitError(f"unit {whole!r} is unknown")
        factor *= unit.factor**power
        powers = [a + power * b for a, b in zip(powers, unit.powers, strict=True)]
        sign, expects = 1, False
    if expects:
        raise UnitError(f"unit {whole!r} is unknown")
    return Unit(factor, tuple(powers)), text.strip()


def _symbol(symbol: str, whole: str) -> Unit:
    word = _WORDS.get(symbol) or (_WORDS.get(symbol.lower()) if len(symbol) > 3 else None)
    if word and word != symbol:
        return parse_unit(word)
    if symbol in SYMBOLS:
        return Unit(*SYMBOLS[symbol])
    prefix, rest = symbol[:1], symbol[1:]
    if prefix in _WITH_PREFIX.get(rest, ""):
        factor, powers = SYMBOLS[rest]
        return Unit(_PREFIXES[prefix] * factor, powers)
    raise UnitError(f"unit {whole!r} is unknown")
