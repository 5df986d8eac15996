"""`abradem config` refuses the tables and searches that the workflow refuses."""

from pathlib import Path

import pytest
import yaml
from tables import drawn, product_law

from abradem.cli.main import main
from abradem.config import ConfigError, load_config
from abradem.quantities import SAMPLED_NAMES
from abradem.running.given_tables import calibration_inputs, external_input

RATE = "simulation.factory.mass_rate_kg_s"
LENGTH = "simulation.factory.patch_length_mm"
GOOD = {"table": "table.csv", "search": {RATE: {"from": 2, "to": 30}}, "trials": 4}


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = drawn(12).assign(wear_total_mean=1e-4)
    rows[[*SAMPLED_NAMES, "wear_total_mean"]].to_csv("table.csv", index=False)
    return tmp_path


def checked(capsys, option="--check", **values):
    """Exit code and lines of `abradem config` for a base file and an override file."""
    Path("config.yaml").write_text("study: a\n")
    Path("over.yaml").write_text(yaml.safe_dump(values))
    code = main(["config", option, "config.yaml", "over.yaml"])
    said = capsys.readouterr()
    return code, (said.err or said.out).splitlines()


def test_a_search_that_can_be_is_accepted(capsys):
    assert checked(capsys, calibration=GOOD)[0] == 0
    assert checked(capsys, "--folder", calibration=GOOD) == (0, ["results/a"])
    config = load_config({"study": "a", "calibration": GOOD})
    found = calibration_inputs(config)
    assert found.table == "table.csv" and len(found.trials) == len(found.setups) == 4


@pytest.mark.parametrize("option", ["--check", "--folder"])
@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"search": {}}, "over.yaml: calibration.search: is empty"),
        ({"search": {"seed": [1, 2]}}, "over.yaml: calibration.search: seed: is no key"),
        ({"search": {RATE: [1, -1]}}, f"over.yaml: calibration.search: {RATE}: -1: is out of"),
        (
            {"search": {"simulation.gravty": [9, 10]}},
            "over.yaml: calibration.search: simulation.gravty: 9: unknown key, did you mean",
        ),
        (
            {"search": {"simulation.factry.mass_rate_kg_s": [9, 10]}},
            "over.yaml: calibration.search: simulation.factry: {mass_rate_kg_s: 9",
        ),
        ({"search": {"simulation.gravity.x": [9, 10]}}, "over.yaml: calibration.search: simula"),
        ({"search": {RATE: [4]}}, f"over.yaml: calibration.search: {RATE}: needs at least two"),
        (
            {"search": {LENGTH: ["0.3 m", "30 cm"]}},
            f"over.yaml: calibration.search: {LENGTH}: holds a value twice",
        ),
        ({"search": {LENGTH: ["300 mm", 300]}}, "over.yaml: calibration.search: "),
        ({"search": {RATE: {"from": "14.4 t/h", "to": 3}}}, "over.yaml: calibration.search: "),
        ({"table": "nowhere.csv"}, "calibration.table: nowhere.csv: there is no such file"),
        ({"table": "."}, "calibration.table: .: is a folder, not a file"),
        ({"table": "https://a.b/c.csv"}, "calibration.table: https://a.b/c.csv: is an address"),
        ({"target": "wear_total_max"}, "table.csv: lacks wear_total_max, the calibration.target"),
        ({"columns": {"plate_angle": "zebra"}}, "table.csv: lacks column 'zebra'"),
        ({"leave_out": [2, 5000]}, "table.csv: has no row 5000 of calibration.leave_out"),
    ],
)
def test_what_a_calibration_cannot_begin_with_is_refused(capsys, option, change, line):
    code, lines = checked(capsys, option, calibration={**GOOD, **change})
    assert code == 2
    assert any(one.startswith(line) for one in lines), lines


def test_all_problems_of_a_calibration_are_told_at_once():
    config = load_config({"study": "a", "calibration": {**GOOD, "table": "no.csv", "search": {}}})
    with pytest.raises(ConfigError) as error:
        calibration_inputs(config)
    assert error.value.problems == [
        "calibration.table: no.csv: there is no such file",
        "calibration.search: is empty; name at least one unknown key",
    ]


def test_a_key_of_a_section_that_may_be_empty_is_searched():
    """Otherwise it would be searched without any effect."""
    name = "simulation.pair_interaction.restitution"
    for section in ({}, {"simulation": {"pair_interaction": None}}):
        given = {"study": "a", "calibration": {**GOOD, "search": {name: [0.2, 0.8]}}, **section}
        setups = calibration_inputs(load_config(given)).setups
        assert {one["pair_interaction"]["restitution"] for one in setups} == {0.2, 0.8}


TARGET = {"target": "wear_total_mean"}


def test_a_table_in_which_nothing_varies_is_refused(capsys):
    fixed = {name: product_law(1)[name][0] for name in SAMPLED_NAMES}
    table = product_law(24).assign(**fixed)[[*SAMPLED_NAMES, "wear_total_mean"]]
    table.to_csv("fixed.csv", index=False)
    for option in ("--check", "--folder"):
        code, lines = checked(capsys, option, dataset={"external": "fixed.csv"}, learning=TARGET)
        assert code == 2 and lines[-1].startswith(
            "dataset.external: fixed.csv: every quantity has the same value in all rows"
        )
    varied = product_law(24)[[*SAMPLED_NAMES, "wear_total_mean"]]
    varied.to_csv("varied.csv", index=False)
    assert checked(capsys, dataset={"external": "varied.csv"}, learning=TARGET)[0] == 0
    config = load_config({"study": "a", "dataset": {"external": "varied.csv"}, "learning": TARGET})
    assert external_input(config) == ("varied.csv", "", "")
