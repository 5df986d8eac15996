"""Numbers in text: words where there is none."""

import math

import pytest

from abradem.learning.number_text import (
    number_or_words,
    number_with_error,
    percentage,
    score_number,
    score_range,
)

NONE = [None, math.nan, math.inf, -math.inf]


@pytest.mark.parametrize("value", NONE)
def test_what_is_no_number_is_written_in_words(value):
    assert number_or_words(value) == score_number(value) == "not determined"
    assert percentage(value) == number_with_error(value, 1.0) == "not determined"
    assert number_with_error(1.0, value) == "1.000"
    assert score_range((0.5, value)) == "interval not determined"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (number_or_words(0.00123), "0.00123"),
        (number_or_words(-0.0001, ".2f"), "0.00"),
        (number_or_words(-0.0001, "+.2f"), "0.00"),
        (number_or_words(1e300), "above 1e15"),
        (number_or_words(-1e32), "below -1e15"),
        (score_number(-1e32), "below -100"),
        (score_number(-12.3456, 2), "-12.35"),
        (percentage(0.123), "12 %"),
        (percentage(1e300), "above 1e15 %"),
        (number_with_error(0.5, 0.01, "+.2f"), "+0.50 +- 0.01"),
        (score_range((-1e9, 0.5), 2), "below -100 to 0.50"),
    ],
)
def test_numbers_are_written_with_their_bounds(text, words):
    assert text == words
