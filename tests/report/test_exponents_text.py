"""What the report says of the exponents beside those of the published data."""

import pandas as pd

from abradem.learning.exponents import PUBLISHED, exponents_beside_published
from abradem.report.findings import _exponents
from abradem.report.latex import EXPONENTS, CitedResults, exponents_tex

ROW = {
    "rows": 109, "published_exponent": 0.87, "published_stderr": 0.02, "combined_errors": 1.0,
}  # fmt: skip


def test_the_paragraph_counts_the_exponents_that_agree():
    table = pd.DataFrame(
        [
            {"quantity": "particle_radius", "exponent": 0.9, "exponent_stderr": 0.03,
             "verdict": "agrees", **ROW},
            {"quantity": "restitution", "exponent": 1.5, "exponent_stderr": 0.1,
             "verdict": "differs", **ROW},
            {"quantity": "static_friction", "exponent": float("nan"),
             "exponent_stderr": float("nan"), "verdict": "not determined", **ROW},
        ]
    )  # fmt: skip
    said = _exponents(table)
    assert "109 cases faster than 4 m/s" in said
    assert "1 + coefficient of restitution 1.5" in said and "friction" not in said
    assert said.endswith("1 of 2 agree within 2 combined standard errors.")


def test_too_few_cases_are_said_and_left_out_of_the_numbers():
    rows = pd.DataFrame({"particle_velocity_y": [-1.0], "wear_total_max": [1.0]})
    table = exponents_beside_published(rows, "wear_total_max", {})
    assert _exponents(table) == (
        "The 0 cases faster than 4 m/s do not determine the exponents of the quantities."
    )
    tex = exponents_tex(CitedResults({EXPONENTS: table}), "x")
    assert tex.count("not determined & not determined & ") == len(PUBLISHED)
    assert r"\ensuremath{-0.77} & 0.10 & not determined" in tex
