"""The model card: ranges as configured, all targets with scores, what is unknown said so."""

import json
import re
from html.parser import HTMLParser

import pandas as pd
import pytest

from abradem.quantities import SAMPLED
from abradem.report.model_card import card_page, model_card
from abradem.store.files import read_json, write_json
from abradem.surrogate.groups import Jet

JET = Jet(0.385, 9.81, 42.0, None, 0.09, 0.09, "arc", 0.235)
SCORES = {
    name: {"mean": value, "median": value, "lower": value - 0.1, "upper": value + 0.01, "unit": "1"}
    for name, value in (("R2", 0.95), ("R2_log", 0.985), ("MAPE", 0.12), ("RMSE", 0.002))
}
SURROGATE = {
    "table": "paper",
    "jet": JET._asdict(),
    "jet_known": True,
    "target": {"name": "wear_friction_p99", "unit": "mm/s", "element_size": 0.03, "known": True},
    "scores": {"test": SCORES},
    "distillation_error": {"rms": 0.0102, "largest": 0.06},
    "local": [
        {
            "target": {"name": "wear_friction_mean", "unit": "mm/s"},
            "held_out": {"R2": 0.977, "R2_log": 0.988, "MAPE": 0.108, "RMSE": 0.0014, "MAE": 1e-3},
        }
    ],
    "features": [
        {"name": row.name, "unit": row.unit,
         "training_range": [0.99 * row.paper_range[0] + 0.01 * row.paper_range[1],
                            row.paper_range[1]]}
        for row in SAMPLED
    ],
    "training_rows": 198,
    "dataset_hash": "0123abcd",
}  # fmt: skip
INTERVALS = {
    "rows": 198,
    "highest_level": 198 / 199,
    "coverage": [{"level": 0.8, "coverage": 0.79, "band": [0.745, 0.855], "relative_width": 0.2}],
    "regions": {"shares": 24, "in_band": 21, "expected": 22.43, "in_joint": 23},
}
REGIONS = pd.DataFrame(
    [("flat", "plate angle below 12 deg", 0.8, 0.58, 0.6, 0.95, 34, False, 0.56, 1.0, True)],
    columns=["region", "words", "level", "coverage", "band_lower", "band_upper", "tested",
             "in_band", "joint_lower", "joint_upper", "in_joint"],
)  # fmt: skip
FRESH = {
    "cases": 200,
    "rates": [
        {"target": name, "shares": 24, "in_band": 23, "expected": 22.6, "in_joint": 22,
         "scores": {"R2": 0.9},
         "all": [{"level": 0.8, "coverage": share, "band": [0.745, 0.855], "in_band": True}]}
        for name, share in (("wear_friction_p99", 0.81), ("wear_friction_mean", 0.76))
    ],
}  # fmt: skip
FAILURES = pd.DataFrame({"status": ["unsteady", "unsteady", "overlap <5 %>"]})
RANGES = {row.name: list(row.paper_range) for row in SAMPLED}


@pytest.fixture(scope="module")
def card():
    return model_card(SURROGATE, INTERVALS, RANGES, FAILURES, REGIONS, "0.1.0", "CC-BY-4.0")


def test_a_simulated_study_says_what_it_is_for(card):
    assert card["intended_use"][0].endswith("as the engine simulates them")
    assert card["not_intended"][0].startswith("another jet or plate than the one below")


def test_ranges_are_those_of_the_configuration_beside_those_of_the_rows(card):
    for one, row, feature in zip(card["ranges"], SAMPLED, SURROGATE["features"], strict=True):
        assert one["configured"] == list(row.paper_range)
        assert one["in_rows"] == feature["training_range"] and one["unit"] == row.unit


def test_every_target_has_its_meaning_and_scores(card):
    first, second = card["targets"]
    assert first["words"].startswith("wear depth rate, 99th percentile of 30 mm elements")
    assert first["scores"]["R2"] == {"median": 0.95, "lower": 0.85, "upper": 0.96, "unit": "1"}
    assert second["scores"]["RMSE"]["median"] == 0.0014
    assert second["scores"]["RMSE"]["unit"] == "mm/s"


def test_failures_are_counted_by_reason(card):
    assert card["rows"]["failed"] == 3
    assert card["rows"]["reasons"] == {"unsteady": 2, "overlap <5 %>": 1}


def test_the_content_survives_json(card, tmp_path):
    write_json(card, tmp_path / "card.json")
    assert read_json(tmp_path / "card.json") == json.loads(json.dumps(card))


class Rows(HTMLParser):
    """Cells of all tables, and whether each tag is closed."""

    def __init__(self, page):
        super().__init__()
        self.cells, self.open = [], []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        if tag != "meta":
            self.open.append(tag)
        if tag == "tr":
            self.cells.append([])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.cells[-1].append(data)


def test_the_page_shows_what_the_content_says(card):
    page = card_page(card)
    found = Rows(page)
    assert found.open == []
    assert ["mass rate", "42 kg/s"] in found.cells
    assert ["plate angle", "deg", "0 ... 70", "0.7 ... 70"] in found.cells
    (regions,) = [row for row in found.cells if row[0] == "plate angle below 12 deg"]
    assert regions == ["plate angle below 12 deg", "34", "80 %", "58.0 %", "60.0 to 95.0 %",
                       "56.0 to 100.0 %"]  # fmt: skip
    assert "21 of the 24 shares by region are as expected by chance" in page
    assert "22.4 would be on average. 23 of 24 are in the joint bands" in page
    (target,) = [row for row in found.cells if row[0] == "wear_friction_p99"]
    assert target[2:] == ["0.9500 (0.8500 to 0.9600)", "0.9850 (0.8850 to 0.9950)", "12.0 %"]
    assert "1 overlap &lt;5 %&gt;" in page and "CC-BY-4.0" in page
    assert not re.search(r"https?://|<script", page)


def test_the_coverage_of_fresh_cases_is_shown_at_each_place(card):
    assert card["fresh"] is None and "fresh cases" not in card_page(card)
    tested = model_card(SURROGATE, INTERVALS, RANGES, fresh=FRESH)
    first, second = (one["words"] for one in tested["fresh"]["rates"])
    assert first.startswith("wear depth rate, 99th percentile of 30 mm elements")
    page = card_page(tested)
    assert "On 200 fresh cases" in page
    (mean,) = [row for row in Rows(page).cells if row[1:3] == ["80 %", "76.0 %"]]
    assert mean[0] == second and second.startswith("wear depth rate, mean over the plate")
    assert mean[3:] == ["74.5 to 85.5 %", "23 of 24 (22.6)", "22 of 24"]


def test_what_is_not_known_of_a_table_is_said():
    target = {"name": "wear_total_mean", "unit": "mm/s", "known": False}
    table = {**SURROGATE, "target": target, "jet_known": False, "local": [], "scores": {}}
    card = model_card(table, INTERVALS, None)
    page = card_page(card)
    assert "as in the table of the study" in page and "as the engine simulates" not in page
    assert "than that of the table, whatever it is" in page
    assert "Not stated for the table" in page and "that of the table it learned from" in page
    assert "mean over the plate" not in page and "not determined" in page
    assert card["licence"]["model"] == "that of the table it learned from"
    assert card["ranges"][0]["configured"] is None and "<td class=n>-</td>" in page


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        (None, [["contact of two particles", "as of particle and surface"]]),
        (
            {"restitution": 0.5, "rolling_friction": 0.01},
            [
                ["restitution of two particles", "0.5"],
                ["rolling friction of two particles", "0.01"],
            ],
        ),
    ],
)
def test_the_card_tells_how_particles_meet(pair, words):
    card = model_card({**SURROGATE, "pair_interaction": pair}, INTERVALS, RANGES)
    assert card["jet"]["pair_interaction"] == pair
    cells = Rows(card_page(card)).cells
    assert all(row in cells for row in words)
    assert "contacts between particles are fixed" in card["not_intended"][0]
    assert not any("two particles" in cell for row in Rows(card_page(
        model_card(SURROGATE, INTERVALS, RANGES))).cells for cell in row)  # fmt: skip


def test_the_card_of_a_geometry_names_its_kind_its_numbers_and_the_part():
    geometry = {"shape": {"kind": "arc", "radius": "arc_radius", "begin": 80.0, "end": 30.0,
                          "width": 0.3}}  # fmt: skip
    radius = {"name": "arc_radius", "unit": "m", "training_range": [0.26, 0.98]}
    surrogate = {
        **SURROGATE,
        "jet": JET._replace(geometry=geometry).stored(),
        "target": {**SURROGATE["target"], "element_size": None, "cells": True, "part": "arc"},
        "features": [*SURROGATE["features"], radius],
    }
    card = model_card(surrogate, INTERVALS, {**RANGES, "arc_radius": [0.25, 1.0]})
    assert card["intended_use"][0].startswith("wear depth rates of the geometry of the study")
    assert "what was not sampled of the geometry are fixed" in card["not_intended"][0]
    assert card["jet"]["geometry"]["kind"] == "arc"
    fixed = {name: one["value"] for name, one in card["jet"]["geometry"]["fixed"].items()}
    assert fixed == {"arc_begin": 80.0, "arc_end": 30.0, "arc_width": 0.3}
    assert not {"geometry", "plate_area", "arc_radius"} & set(card["jet"]["values"])
    assert card["ranges"][-1] == {
        "name": "arc_radius", "unit": "m", "words": "radius of the arc", "configured": [0.25, 1.0],
        "in_rows": [0.26, 0.98],
    }  # fmt: skip
    assert "99th percentile of the cells of the part arc" in card["targets"][0]["words"]
    text = card_page(card)
    assert "slope where the arc ends" in text and "30 deg" in text and "radius of the arc" in text
