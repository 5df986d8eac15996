"""Comparison of the numbers in LaTeX files with the results that they state as their source."""

import math
import re

from abradem.report import latex
from abradem.words.escaping import for_latex


def at_source(found, source):
    """The value at the source stated in a comment."""
    file, _, place = source.partition(": ")
    percent = place.endswith(" [x 100]")
    value = latex.cited_value(found.files[file], place.removesuffix(" [x 100]"), file)
    return 100.0 * value if percent else value


def assert_agree(text, value):
    if isinstance(value, str):
        assert text == for_latex(value)
    elif isinstance(value, list):
        assert text == "-".join(map(str, value))
    elif value is None or math.isnan(value):
        assert text in (latex.MISSING, latex.UNDETERMINED)
    elif text.startswith(("below", "above")):
        assert (value < latex.parsed(text)) == text.startswith("below")
        assert abs(value) > 99.0
    else:
        assert abs(latex.parsed(text) - value) <= latex.resolution(text) * (1.0 + 1e-9), text


def macros(text):
    return re.findall(r"^\\newcommand\{\\([A-Za-z]+)\}\{(.*)\} % (.*)$", text, re.MULTILINE)


def rows(text):
    """Cells and sources of every row with numbers."""
    for line in text.splitlines():
        cells, found, sources = line.partition(r" \\ % ")
        if found:
            yield cells.split(" & "), sources.split("; ")


def is_number(cell):
    try:
        latex.parsed(cell)
    except ValueError:
        return False
    return True
