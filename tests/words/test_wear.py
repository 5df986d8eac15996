"""The words for every target of a study, from one place."""

import pytest

from abradem.config import Config, target_dict
from abradem.quantities import STATISTICS, WEAR_COLUMNS, WEAR_MEASURES, quantity, wear_parts
from abradem.words.wear import WearTarget, place_of

PLACES = {
    "mean": "mean over the plate",
    "worn": "mean over the worn 30 mm elements",
    "footprint": "mean over the footprint of 30 mm elements",
    "p99": "99th percentile of 30 mm elements",
    "max": "worst 30 mm element",
}


@pytest.mark.parametrize("measure", WEAR_MEASURES)
@pytest.mark.parametrize("statistic", STATISTICS)
def test_a_target_says_measure_statistic_and_size(measure, statistic):
    said = WearTarget(f"wear_{measure}_{statistic}", 0.03)
    assert (said.measure, said.statistic) == (measure, statistic)
    assert said.place == place_of({"name": said.name, "element_size": 0.03}) == PLACES[statistic]
    assert said.words == f"wear depth rate, {measure}, {PLACES[statistic]}"
    assert said.has_elements == ("element" in said.place)
    assert "mm" not in WearTarget(said.name).place


@pytest.mark.parametrize(
    ("statistic", "words"),
    [("mean", "mean of the part lower"), ("p99", "99th percentile of the cells of the part lower")],
)
def test_the_wear_of_a_part_of_a_geometry_names_it(statistic, words):
    stored = {"name": f"wear_friction_{statistic}", "cells": True, "part": "lower"}
    assert place_of(stored) == WearTarget.stored(stored).place == words
    assert "surface" not in words


def test_other_columns_are_no_wear_rate():
    assert place_of({"name": "loss"}) == "as in the table that the model learned from"
    with pytest.raises(KeyError, match="'wear_total' is no wear rate; known: wear_total_mean"):
        wear_parts("wear_total")


def test_a_rate_whose_meaning_is_not_known_is_not_named():
    said = WearTarget("wear_total_mean", None, known=False)
    stored = place_of({"name": said.name, "known": False})
    for words in (said.place, said.words, said.explained, stored):
        assert "table" in words and "total" not in words and "mean" not in words.split(" (")[0]


def test_every_wear_rate_is_the_target_of_the_table_of_quantities():
    for name in WEAR_COLUMNS:
        row = quantity(name)
        assert (row.symbol, row.name, row.unit, row.kind) == ("X21", name, "mm/s", "target")


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({}, ("wear_friction_p99", 0.03, True, False, None)),
        ({"learning": {"target": "wear_total_mean"}, "wear_rate": {"element_size_mm": None}},
         ("wear_total_mean", 0.01, True, False, None)),
        ({"learning": {"target": "wear_friction_p99"}, "wear_rate": {"element_size_mm": 30}},
         ("wear_friction_p99", 0.03, True, False, None)),
        ({"learning": {"target": "wear_total_max"}, "dataset": {"external": "t.csv"}},
         ("wear_total_max", None, False, False, None)),
        ({"learning": {"target": "wear_total_max"},
          "dataset": {"external": "t.csv", "rate": "stated"}},
         ("wear_total_max", None, True, False, None)),
        ({"simulation": {"geometry": {"kind": "arc"}}},
         ("wear_friction_p99", None, True, True, None)),
        ({"simulation": {"geometry": {"kind": "arc"}}, "learning": {"part": "arc"}},
         ("wear_friction_p99", None, True, True, "arc")),
    ],
)  # fmt: skip
def test_the_target_of_a_configuration(values, expected):
    assert WearTarget(**target_dict(Config(study="x", **values))) == expected


def test_the_rates_of_a_geometry_are_those_of_its_cells():
    places = {
        statistic: WearTarget(f"wear_friction_{statistic}", cells=True).place
        for statistic in STATISTICS
    }
    assert len(set(places.values())) == len(STATISTICS)
    assert places["p99"] == "99th percentile of the cells"
    assert not any("plate" in words or "element" in words for words in places.values())
