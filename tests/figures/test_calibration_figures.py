"""Figures and sentences of a calibration, from tables with known answers."""

import numpy as np
import pandas as pd
import pytest
from figure_checks import assert_fit_to_print
from tables import drawn

from abradem.calibration.agreement import SCORES, agreement
from abradem.figures.calibration import draw_agreement, draw_profiles
from abradem.report.calibration import sentences

NAMES = {"simulation.factory.mass_rate_kg_s": 12.0, "simulation.factory.angle_acts": "arc"}


@pytest.fixture
def found():
    """A calibration whose simulated rates lack an exponent of 0.5 in the friction."""
    rows = drawn(60, seed=2)
    given = 1e6 * rows["archard_constant"] * rows["particle_radius"]
    simulated = given * (rows["static_friction"] / 0.47) ** -0.5
    predicted = rows.assign(
        part=np.where(np.arange(60) % 4 == 0, "held out", "used"),
        given=given, simulated=simulated, simulated_stderr=0.05 * simulated,
    )  # fmt: skip
    scores = {}
    for name in ("both", "held out", "used"):
        here = predicted if name == "both" else predicted[predicted["part"] == name]
        scores[name] = {
            "rows": len(here),
            **agreement(here["given"], here["simulated"]),
            "single": {score: [0.9, 0.01] for score in SCORES},
        }
    summary = {
        "trial": 3, "values": NAMES, "measure": "friction", "statistic": "max",
        "element_size": 0.03, "by": "log_r2", "replicates": 2, "scores": scores,
        "equal": {name: [value] for name, value in NAMES.items()}, "equal_trials": [3, 5],
    }  # fmt: skip
    slopes = pd.DataFrame(
        {
            "quantity": ["particle_radius", "static_friction", "restitution"],
            **{f"{of}_{end}": [1.0, 0.5, 0.0] if end == "exponent" else 0.01
               for of in ("given", "simulated", "ratio") for end in ("exponent", "stderr")},
        }
    )  # fmt: skip
    slopes["ratio_exponent"] = [0.0, 0.5, 0.1]
    profiles = pd.DataFrame(
        [
            ("simulation.factory.mass_rate_kg_s", "4 to 8", 4.0, 8.0, 3, 0.6, 0.01, True),
            ("simulation.factory.mass_rate_kg_s", "8 to 16", 8.0, 16.0, 3, 0.9, 0.01, False),
            ("simulation.factory.angle_acts", "tilt", np.nan, np.nan, 4, 0.9, 0.01, False),
            ("simulation.factory.angle_acts", "arc", np.nan, np.nan, 4, 0.895, 0.01, False),
            ("statistic", "p99", np.nan, np.nan, 0, np.nan, np.nan, True),
            ("statistic", "max", np.nan, np.nan, 7, 0.9, 0.01, False),
        ],
        columns=["unknown", "value", "low", "high", "trials", "score", "noise", "told_apart"],
    )
    return predicted, summary, slopes, profiles


def test_the_agreement_is_fit_to_print_and_names_what_is_left(found):
    predicted, summary, slopes, _ = found
    figure = draw_agreement(predicted, summary, slopes)
    assert_fit_to_print(figure)
    titles = [panel.get_title(loc="left") for panel in figure.axes]
    assert any("b = +0.50 ± 0.01" in title for title in titles)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert f"of ln y {summary['scores']['used']['log_r2']:.3f}" in texts[0]


def test_profiles_are_fit_to_print(found):
    _, summary, _, profiles = found
    figure = draw_profiles(profiles, summary)
    assert_fit_to_print(figure)
    titles = [panel.get_title(loc="left") for panel in figure.axes]
    assert any("mass rate (kg/s)" in title for title in titles) and len(titles) == 3


def test_the_sentences_say_what_is_known_and_what_not(found):
    _, summary, slopes, profiles = found
    said = dict(sentences(summary, slopes, profiles, trials=32))
    assert "Of 32 set-ups, trial 3 explains the table best" in said["Best set-up"]
    assert "worst element of 30 mm" in said["Best set-up"]
    assert said["Agreement"].index("Used (45 rows)") < said["Agreement"].index("Held out (15 rows)")
    told = said["What the search cannot tell apart"]
    assert "2 set-ups of the last rung are equal" in told
    assert "simulation.factory.mass_rate_kg_s: 8 to 16" in told and "statistic: max" in told
    assert "Nothing can be said of simulation.factory.angle_acts." in told
    assert "left against coefficient of static friction (+0.50 ± 0.01)" in said["Exponents"]
