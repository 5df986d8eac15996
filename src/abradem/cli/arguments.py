"""Words of the command line, before anything else is imported."""

from __future__ import annotations

from collections.abc import Sequence


def joined(arguments: Sequence[str]) -> list[str]:
    """Return arguments in which NAME = VALUE, with blanks around "=", is one word.

    A value that begins with a minus, such as -5m/s, would otherwise be taken for an option.
    """
    words: list[str] = []
    for word in arguments:
        after = bool(words) and words[-1].endswith("=") and not words[-1].startswith("-")
        before = word.startswith("=") and bool(words) and not words[-1].startswith("-")
        if after or before:
            words[-1] += word
        else:
            words.append(word)
    return words
