"""Performance figures: all values are shown, including very short contacts."""

import numpy as np
import pandas as pd
import pytest
from figure_checks import assert_fit_to_print, texts

from abradem.figures import speed as figures
from abradem.figures import style

CODES = ("islands", "synchronous", "LIGGGHTS", "LAMMPS")


@pytest.fixture
def counts():
    rows = [
        (angle, present, code, cost * present)
        for angle in (45.0, 0.0)
        for present in (10.0, 100.0, 1000.0)
        for code, cost in zip(CODES, (1e-4, 1e-3, 1e-2, 2e-2), strict=True)
    ]
    return pd.DataFrame(rows, columns=["plate_angle", "particles", "code", "cost"])


@pytest.fixture
def rates():
    rows = [
        (scenario, stepping, 1e9 * factor, 1e6 * factor, 0.2 * factor)
        for scenario in "AMBD"
        for stepping, factor in (("islands", 1.0), ("synchronous", 0.1))
    ]
    names = ["scenario", "stepping", "particle_steps", "contact_steps", "share_of_limit"]
    return pd.DataFrame(rows, columns=names)


def test_cost_shows_every_code_at_every_angle_on_common_axes(counts):
    time = np.linspace(0.02, 2.0, 100)
    times = pd.concat(
        pd.DataFrame({"scenario": name, "simulated": time, "spent": cost * time})
        for name, cost in zip("AMBD", (0.01, 0.03, 0.1, 1.0), strict=True)
    )
    figure = figures.cost_figure(counts, times)
    steep, level, scenarios = figure.axes
    assert steep.get_ylim() == level.get_ylim()
    for panel in (steep, level):
        assert len(panel.lines) == len(CODES)
        for line, cost in zip(panel.lines, (1e-4, 1e-3, 1e-2, 2e-2), strict=True):
            np.testing.assert_allclose(line.get_ydata(), cost * line.get_xdata())
    assert len(scenarios.lines) == 4
    words = texts(figure)
    assert "45°" in words and "LAMMPS" in words and "abradem, islands" in words
    assert_fit_to_print(figure)


def test_rates_are_shown_by_scenario_and_the_share_in_per_cent(rates):
    figure = figures.rates_figure(rates)
    particles, contacts, share = figure.axes
    assert particles.lines[0].get_ydata() == pytest.approx([1e9] * 4)
    assert contacts.lines[1].get_ydata() == pytest.approx([1e5] * 4)
    assert share.lines[0].get_ydata() == pytest.approx([20.0] * 4)
    assert [label.get_text() for label in share.get_xticklabels()] == list("AMBD")
    assert_fit_to_print(figure)


def test_contacts_too_short_to_see_are_drawn_a_point_long():
    spans = pd.DataFrame(
        [(0, 0.0, 0.1, "asleep"), (0, 0.1, 0.100001, "plate"), (0, 0.100001, 0.2, "asleep"),
         (1, 0.05, 0.1, "asleep"), (1, 0.1, 0.2, "particle")],
        columns=["particle", "begin", "end", "does"],
    )  # fmt: skip
    contacts = pd.DataFrame([(0, 1, 0.1, 0.2)], columns=["particle", "partner", "begin", "end"])
    figure = figures.islands_figure(spans, contacts, [(0.0, 0.2), (0.09, 0.11)])
    whole, zoom = figure.axes
    (plate,) = (
        c for c in whole.collections if c.get_linewidth() == 4.0 and c.get_colors()[0, 2] > 0.6
    )
    ((start, end),) = [segment[:, 0] for segment in plate.get_segments()]
    point = 200.0 / (72.0 * style.PAGE)
    assert start == pytest.approx(100.0) and end - start == pytest.approx(point)
    assert zoom.get_xlim() == pytest.approx((90.0, 110.0))
    assert_fit_to_print(figure)
