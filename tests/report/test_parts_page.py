"""The page on the parts of a surface: its sentences state the numbers of its tables."""

import pandas as pd

from abradem.report.parts_page import parts_page
from abradem.wear.part_effects import part_effects

COLUMN = "wear_friction_mean"
CASES = pd.DataFrame(
    {"case_id": range(6), "plate_2_angle": [20.0, 25.0, 30.0, 35.0, 40.0, 45.0], "restitution": 0.5}
)
RATES = {"upper": [1.0, 1.2, 0.9, 1.1, 1.0, 1.05], "lower": [3.0, 2.8, 2.5, 2.0, 1.5, 1.0]}
PARTS = pd.concat(
    [
        pd.DataFrame({"case_id": range(6), "part_name": part, "area": 0.09, COLUMN: rates})
        for part, rates in RATES.items()
    ],
    ignore_index=True,
)


def page(parts, cases):
    return parts_page("one", parts, part_effects(parts, cases, COLUMN), cases, COLUMN)


def test_the_answer_names_the_part_that_wears_most_and_what_spares_it():
    text = page(PARTS, CASES)
    assert "Of 2 parts lower wears most: 2.13 mm/s on average over 6 cases" in text
    assert "; upper 1.04 mm/s. It falls with" in text
    assert (
        "It falls with angle of plate 2 (rank correlation -1.00): 2.9 mm/s from 20 to 25 deg, "
        "1.25 mm/s from 40 to 45 deg." in text
    )
    assert "1.04 mm/s on average over 6 cases, from 0.9 to 1.2 mm/s." in text


def test_no_effect_is_stated_where_nothing_varied_or_none_is_clear():
    text = page(PARTS, CASES.assign(plate_2_angle=20.0))
    assert "lower wears most" in text and "rank correlation" not in text
    upper = PARTS[PARTS["part_name"] == "upper"]
    assert "No quantity that varied decides it alone" in page(upper, CASES)


def test_the_answer_is_on_the_part_that_the_study_explains():
    effects = part_effects(PARTS, CASES, COLUMN)
    text = parts_page("one", PARTS, effects, CASES, COLUMN, asked="lower")
    assert "; upper 1.04 mm/s. Of lower: It falls with angle of plate 2" in text
    rising = PARTS.assign(**{COLUMN: PARTS[COLUMN].where(PARTS["part_name"] == "lower", 9.0)})
    effects = part_effects(rising, CASES, COLUMN)
    text = parts_page("one", rising, effects, CASES, COLUMN, asked="lower")
    assert "upper wears most" in text and "Of lower: It falls with angle of plate 2" in text


def test_what_chance_gives_in_few_cases_is_no_effect():
    """Four values in order are one of 24 orders, and as likely reversed; five are one of 120."""
    for count, stated in ((4, False), (5, True)):
        rows = PARTS[PARTS["case_id"] < count]
        text = page(rows, CASES.iloc[:count])
        assert ("It falls with angle of plate 2" in text) == stated
        assert ("no more than chance gives in 4 cases" in text) != stated


def test_without_rates_the_page_says_so():
    assert "No case gave a wear rate." in page(PARTS.iloc[:0], CASES)


def test_rates_are_put_beside_one_from_elsewhere():
    """The target and its 99th percentile, as multiples, and which are of the same order."""
    parts = PARTS.assign(wear_friction_p99=10.0 * PARTS[COLUMN])
    effects = part_effects(parts, CASES, COLUMN)
    text = parts_page("one", parts, effects, CASES, COLUMN, 0.2, "A and B (2021)")
    assert (
        "As multiples of the 0.2 mm/s that A and B (2021) report: lower 11 (mean), 1.1e+02 (99th "
        "percentile of the cells); upper 5.2 (mean), 52 (99th percentile of the cells). "
        "Within a factor of 10 of it: mean of upper." in text
    )
    far = parts_page("one", parts, effects, CASES, COLUMN, 1e-6)
    assert "of the 1e-06 mm/s: lower" in far and "Within a factor of 10 of it: none." in far
    assert "As multiples" not in parts_page("one", parts, effects, CASES, COLUMN)
    assert "As multiples" not in parts_page("one", parts.iloc[:0], effects, CASES, COLUMN, 0.2)
