"""A result in mm/s: closed forms of a straight line and a ramp, refusals, and a real jet."""

import inspect
import math
import re

import numpy as np
import pandas as pd
import pytest
from straight_engine import RATE, ramp, straight_line

import abradem
import abradem.dem
from abradem.quantities import SAMPLED, STATISTICS, WEAR_MEASURES, stderr_column, wear_column
from abradem.simulation.batch import TABLES, run_case
from abradem.wear.rates import wear_rates

SETUP = abradem.Setup(facet_size=0.03, window=2.0, max_time=4.0)
CASE = abradem.Case(archard_constant=2e-9, plate_angle=20.0, seed=5)


@pytest.fixture
def engine(monkeypatch):
    """Results of the straight engine, with options of a test."""
    options = {}
    monkeypatch.setitem(
        vars(abradem.dem),
        "simulate",
        lambda case, setup, **_: straight_line(case, setup, **options),
    )
    return options


@pytest.fixture
def result(engine):
    return abradem.simulate(CASE, SETUP)


MEAN = 1e3 * 2e-9 * RATE / 0.09
"""mm/s: W J / (area time)."""


@pytest.mark.parametrize("measure", WEAR_MEASURES)
def test_the_mean_is_archards_law_of_the_whole_plate(result, measure):
    found = result.wear_rate(measure)
    assert found.rate == pytest.approx(MEAN, rel=1e-12)
    assert found.stderr == pytest.approx(0.0, abs=1e-12 * MEAN)


@pytest.mark.parametrize(("size", "count"), [(None, 10), (0.03, 10), (0.06, 5), (0.15, 2)])
def test_the_worst_element_of_a_ramp_depends_on_its_size(result, size, count):
    """The rows of a ramp of n elements have the means (2 i - 1) / n of the mean, i = 1 ... n."""
    # Facets have shares proportional to 1 ... 10, so an element of k facets has a mean of theirs.
    k = 10 // count
    shares = np.arange(1, 11).reshape(count, k).mean(axis=1) / 5.5
    assert result.wear_rate("friction", "max", size).rate == pytest.approx(MEAN * shares.max())
    p99 = np.percentile(np.repeat(shares, count), 99.0)
    assert result.wear_rate("friction", "p99", size).rate == pytest.approx(MEAN * p99)
    np.testing.assert_allclose(
        result.wear_map("friction", size), np.repeat(MEAN * shares[:, None], count, axis=1)
    )


def test_the_map_of_facets_has_the_mean_of_the_plate(result):
    found = result.wear_map()
    assert found.shape == SETUP.facets
    np.testing.assert_allclose(found, MEAN * ramp(SETUP) * found.size, rtol=1e-12)
    assert found.mean() == pytest.approx(MEAN)


def test_wear_is_proportional_to_the_archard_constant_alone(engine):
    one, two = (abradem.simulate(abradem.Case(archard_constant=w), SETUP) for w in (1e-9, 3e-9))
    assert two.wear_rate().rate == pytest.approx(3.0 * one.wear_rate().rate, rel=1e-12)
    np.testing.assert_array_equal(one.worn, two.worn)


def test_the_series_ends_at_rate_times_time(result):
    series = result.series()
    assert series["depth_total"].iloc[-1] == pytest.approx(MEAN * 3.5)
    assert list(series) == [
        "time", *(f"depth_{one}" for one in WEAR_MEASURES), "delivered_mass", "particles_present",
    ]  # fmt: skip


def test_a_row_has_the_case_and_what_the_methods_tell(result):
    row = result.to_frame(element_size=0.06).iloc[0]
    assert row["plate_angle"] == 20.0 and row["seed"] == 5 and row["status"] == "ok"
    for measure in WEAR_MEASURES:
        for statistic in STATISTICS:
            column = wear_column(measure, statistic)
            told = result.wear_rate(measure, statistic, 0.06)
            assert (row[column], row[stderr_column(column)]) == told
    assert row["wear_total_max"] != result.to_frame().iloc[0]["wear_total_max"]


def test_a_table_of_results_is_made_by_joining_their_rows(engine):
    rows = [
        abradem.simulate(abradem.Case(plate_angle=angle), SETUP).to_frame() for angle in (0, 30)
    ]
    assert pd.concat(rows)["plate_angle"].tolist() == [0, 30]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"status": "overlap above 20 % of the radius"}, "no wear rate: overlap above 20 %"),
        ({"steady": False}, "did not wear steadily for the window of 2 s"),
    ],
)
def test_without_a_steady_rate_no_number_is_told(engine, options, words):
    engine.update(options)
    result = abradem.simulate(CASE, SETUP)
    for method in (result.wear_rate, result.wear_map, result.wear_rates):
        with pytest.raises(ValueError, match=words):
            method()
    row = result.to_frame().iloc[0]
    assert row["status"] == result.status and math.isnan(row["wear_total_max"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("volume",), "measure = 'volume' is unknown; allowed: total, sliding, friction"),
        (("total", "median"), "statistic = 'median' is unknown; allowed: mean, worn,"),
        (("total", "max", 0.04), "element_size = 0.04 m does not divide the plate"),
    ],
)
def test_unknown_names_and_sizes_are_refused(result, arguments, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        result.wear_rate(*arguments)


@pytest.mark.parametrize("measure", ["total", "friction"])
def test_pictures_show_the_case_and_the_rate(result, measure):
    worn, depth = result.plot_map(measure), result.plot_series(measure)
    for figure in (worn, depth):
        title = figure.axes[0].get_title(loc="left")
        assert "= 20°" in title and "22.5 mm" in title and "case" not in title
        assert measure in figure.get_supxlabel()
    mesh = worn.axes[0].collections[0].get_array()
    # In units of a power of ten, a multiple of three.
    assert np.log10(result.wear_map(measure).max() / mesh.max()) % 3 == pytest.approx(0, abs=1e-9)
    assert len(depth.axes[0].lines) == 2


def test_the_repr_is_short(result):
    said = repr(result)
    assert len(said) < 200 and "\n" not in said
    assert said.startswith(
        "<CaseResult: ok, 3.5 s simulated, 200 particles released; plate_angle=20"
    )


# The case


def test_a_case_is_by_default_the_middle_of_the_papers_ranges():
    case = abradem.Case()
    for row in SAMPLED:
        assert getattr(case, row.name) == pytest.approx(sum(row.paper_range) / 2, rel=1e-12)


@pytest.mark.parametrize("row", SAMPLED, ids=lambda row: row.name)
def test_the_docstring_of_a_case_has_unit_and_limits(row):
    text = inspect.getdoc(abradem.Case)
    found = re.search(rf"^{row.name} : float\n((?:    .*\n)+)", text, re.MULTILINE)
    low, high = row.limits
    assert f"[{low:g}, {high:g}]".replace("e+0", "e").replace("e+", "e") in found[1]
    assert row.unit == "1" or row.unit in found[1]


@pytest.mark.parametrize(
    ("values", "lines"),
    [
        (
            {"particle_radius": 20.0},
            ["particle_radius = 20 m is impossible (allowed 0.0001 ... 0.1 m)"],
        ),
        (
            {"particle_velocity_y": 5.0},
            ["particle_velocity_y = 5 m/s is impossible (allowed -30 ... 0 m/s; down is negative)"],
        ),
        (
            {"particle_radius": 20.0, "restitution": 0.01},
            ["restitution = 0.01 is impossible (allowed 0.05 ... 1)",
             "particle_radius = 20 m is impossible (allowed 0.0001 ... 0.1 m)"],
        ),
    ],
)  # fmt: skip
def test_impossible_values_are_refused_as_in_predict(engine, values, lines):
    with pytest.raises(ValueError) as refused:
        abradem.simulate(abradem.Case(**values), SETUP)
    assert str(refused.value).splitlines() == lines


# The engine itself


def test_a_jet_has_the_rates_that_a_study_gives():
    setup = {"facet_size": 0.05, "window": 0.5, "max_time": 1.5, "number_rate": 60.0,
             "mass_rate": None}  # fmt: skip
    case = abradem.Case(plate_angle=40.0, particle_radius=0.03, particle_velocity_y=-6.0, seed=3)
    result = abradem.simulate(case, abradem.Setup(**setup))
    row = {**vars(case), "case_id": 7, "block": 1, "rejected": ""}
    tables = run_case(row, setup)
    rates = wear_rates(
        **{name: tables[name] for name in TABLES},
        cases=pd.DataFrame([row]),
        setup=abradem.Setup(**setup),
        element_size=0.1,
    ).iloc[0]
    for measure in WEAR_MEASURES:
        for statistic in STATISTICS:
            column = wear_column(measure, statistic)
            found = result.wear_rate(measure, statistic, 0.1)
            assert found.rate == rates[column] > 0.0
            assert found.stderr == rates[stderr_column(column)]
