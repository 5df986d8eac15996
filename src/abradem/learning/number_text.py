"""Numbers in text: one way to write them, and words where there is no number.

Sentences, tables, LaTeX, figures and the data card write numbers with these functions. A number
that is missing or not finite is written in words, and so is one beyond any wear rate or score,
which is no more than a sign that something could not be determined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeGuard

UNDETERMINED = "not determined"

LARGEST = 1e15
"""Magnitude beyond which a number is not written out."""

LOWEST_SCORE = -100.0
"""R2 below which only this bound is written: such a model is useless, however far below."""


def number_or_words(value: float | None, form: str = ".3g", missing: str = UNDETERMINED) -> str:
    """A number as text, or words.

    Parameters
    ----------
    value : float or None
    form : str
        Format of the number.
    missing : str
        Written for None, nan and infinity.
    """
    if not is_number(value):
        return missing
    if abs(value) > LARGEST:
        return f"{'above' if value > 0 else 'below -'} {LARGEST:.0e}".replace("- ", "-").replace(
            "e+", "e"
        )
    text = format(value, form)
    # Print minus zero as zero.
    return text[1:] if text.startswith("-") and not float(text.rstrip("%")) else text


def score_number(value: float | None, digits: int = 4, missing: str = UNDETERMINED) -> str:
    """R2 as text, or words."""
    if is_number(value) and value < LOWEST_SCORE:
        return f"below {LOWEST_SCORE:.0f}"
    return number_or_words(value, f".{digits}f", missing)


def percentage(share: float | None, form: str = ".0f", missing: str = UNDETERMINED) -> str:
    """A share in percent as text, or words."""
    return f"{number_or_words(100.0 * share, form)} %" if is_number(share) else missing


def number_with_error(
    value: float | None, error: float | None, form: str = ".3f", sign: str = "+-"
) -> str:
    """A number and its standard error; without an error if that is not determined."""
    shown = number_or_words(value, form)
    if not (is_number(value) and is_number(error)):
        return shown
    return f"{shown} {sign} {number_or_words(error, form.lstrip('+'))}"


def score_range(ends: Sequence[float | None], digits: int = 4) -> str:
    """Both ends of an interval of R2, or words."""
    low, high = ends
    if not (is_number(low) and is_number(high)):
        return f"interval {UNDETERMINED}"
    return f"{score_number(low, digits)} to {score_number(high, digits)}"


def is_number(value: float | None) -> TypeGuard[float]:
    """Whether there is a finite number."""
    return value is not None and math.isfinite(value)
