"""Words of the command line, before anything else is imported."""

from __future__ import annotations

from collections.abc import Sequence


class InputError(ValueError):
    """Invalid input; the message is one line for each problem."""


def joined(arguments: Sequence[str]) -> list[str]:
    """Return arguments in which NAME = VALUE, with blanks around "=", is one word.

    A value that begins with a minus, such as -5m/s, would otherwise be taken for an option.
    """
    words: list[str] = []
    for word in arguments:
        # What follows an option is its value, and a word with a name of its own is no value.
        of_option = len(words) > 1 and words[-2].startswith("--") and "=" not in words[-2]
        joins = bool(words) and not words[-1].startswith("-") and not of_option
        after = joins and words[-1].endswith("=") and "=" not in word.strip("=")
        before = joins and word.startswith("=")
        if after or before:
            words[-1] += word
        else:
            words.append(word)
    return words
