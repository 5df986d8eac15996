"""Every figure of the verification study draws from its own tables only."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from abradem.figures.verification import FIGURES
from abradem.verification import chung_ooi, codes, laws

DATA = Path(__file__).parents[1] / "data" / "codes"


def labels(figure):
    return {text for legend in figure.legends for text in [t.get_text() for t in legend.texts]}


def test_restitution_shows_the_three_normal_laws():
    figure = FIGURES["restitution"](laws.restitution_sweep())
    assert labels(figure) >= {"textbook, not attractive", "textbook, attractive", "exact"}


def test_codes_shows_every_code_of_the_tables():
    reference = codes.read(DATA / "single_impacts.csv")
    reference = reference[reference["angle"] == 30.0]
    figure = FIGURES["codes"](codes.compare_impacts(reference))
    assert {text.split(":")[0] for text in labels(figure)} == set(reference["code"])


def test_forces_draws_one_panel_for_each_impact():
    reference = codes.read(DATA / "forces.csv")
    figure = FIGURES["codes_forces"](codes.compare_forces(reference))
    assert len(figure.axes) == len(reference.groupby(["code", "variant", "angle"]))


def test_the_chute_has_a_panel_for_each_code_with_a_profile():
    reference = codes.read(DATA / "chutes.csv").rename(columns={"value": "reference"})
    table = reference.assign(ours=reference["reference"], spread=0.01)
    figure = FIGURES["chute"](table)
    profiles = table[table["quantity"] == "normal_impulse"]
    assert [panel.get_title(loc="left") for panel in figure.axes] == list(profiles["code"].unique())


@pytest.mark.parametrize("number", [4, 5])
def test_chung_ooi_has_the_exact_branch(number):
    tests = chung_ooi.oblique_test() if number == 4 else chung_ooi.plane_tests()
    figure = FIGURES[f"chung_ooi_{number}"](tests, chung_ooi.measured())
    assert "exact" in labels(figure)
    assert ("experiment" if number == 4 else "finite elements") in labels(figure)


def test_coverage_counts_the_intervals_that_miss():
    rng = np.random.default_rng(1)
    rates = pd.DataFrame(
        {
            "value": rng.normal(1.0, 0.1, 50),
            "relative_stderr": 0.1,
            "covered": [1.0] * 47 + [0.0] * 3,
        }
    )
    assert "interval misses the mean (3)" in labels(FIGURES["coverage"](rates))
