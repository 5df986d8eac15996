"""A small calibration by the workflow: results, refusals, and the same bytes however it is run."""

import shutil

import pytest
import yaml
from copies import run_in, workflow_in
from tables import drawn

from abradem.config import read_config
from abradem.quantities import SAMPLED_NAMES
from abradem.store.files import read_json
from abradem.store.tables import read_table

RATE = "simulation.factory.mass_rate_kg_s"
SEARCH = {
    "study": "found",
    "simulation": {
        "plate": {"facet_size_mm": 50},
        "stop": {"window_s": 1, "max_time_s": 4, "target_stderr": 0.5},
    },
    "wear_rate": {"element_size_mm": None},
    "calibration": {
        "table": "table.csv",
        "search": {
            RATE: {"from": 2, "to": 30, "scale": "log"},
            "simulation.factory.angle_acts": ["tilt", "level"],
        },
        "element_sizes_mm": [50, 100],
        "held_out_every": 4,
        "trials": 4,
        "keep": 0.5,
        "rows": [5, 6],
        "replicates": [1, 2],
    },
}


def folder(root):
    workflow_in(root)
    rows = drawn(8, seed=3, particle_radius=0.03, particle_velocity_y=-4.0)
    rows["wear_total_mean"] = 2e6 * rows["archard_constant"] * (1.0 + rows["plate_angle"] / 50.0)
    rows[[*SAMPLED_NAMES, "wear_total_mean"]].to_csv(root / "table.csv", index=False)
    return root


def bytes_of(root):
    found = root / "results" / "found"
    names = ("calibration/**/*", "figures/*")
    return {
        str(path.relative_to(found)): path.read_bytes()
        for name in names
        for path in sorted(found.glob(name))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = folder(tmp_path_factory.mktemp("calibration"))
    code, lines = run_in(root, "--cores", "2", overlay=SEARCH)
    assert code == 0, lines
    return root


def test_the_calibration_is_the_whole_study(made):
    found = made / "results" / "found"
    summary = read_json(found / "calibration" / "summary.json")
    assert summary["scores"]["used"]["rows"] == 6 and summary["scores"]["held out"]["rows"] == 2
    assert len(read_table(found / "calibration" / "trials.parquet")) == 4
    assert set(read_table(found / "calibration" / "rung-1" / "scores.parquet")["trial"]) <= {
        0, 1, 2, 3,
    }  # fmt: skip
    page = (found / "calibration" / "calibration.html").read_text(encoding="utf-8")
    assert "Of 4 set-ups, trial" in page and "What the search cannot tell apart" in page
    assert not (found / "dataset.parquet").exists()
    assert {path.name for path in (found / "figures").iterdir()} >= {
        "agreement.png",
        "profiles.png",
    }


def test_the_best_set_up_runs_as_it_is(made):
    path = made / "results" / "found" / "calibration" / "best.yaml"
    summary = read_json(made / "results" / "found" / "calibration" / "summary.json")
    config = read_config(made / "config.yaml", path)
    assert config.study == "found_best" and config.calibration.table is None
    assert config.simulation.factory.mass_rate_kg_s == summary["values"][RATE]
    assert config.learning.target == f"wear_{summary['measure']}_{summary['statistic']}"
    code, lines = run_in(made, "dataset", "--dry-run", overlay=yaml.safe_load(path.read_text()))
    assert code == 0, lines


def test_one_core_and_a_lost_half_give_the_same_bytes(made, tmp_path):
    root = folder(tmp_path / "again")
    shutil.copytree(made / "results", root / "results")
    lost = root / "results" / "found" / "calibration"
    # As after a kill: half of the first rung is there, and nothing that follows from it.
    for path in (*lost.glob("*.*"), lost / "rung-0" / "place-0001.parquet"):
        if path.name not in ("setups.json", "rows.parquet"):
            path.unlink()
    (lost / "rung-0" / "scores.parquet").unlink()
    shutil.rmtree(lost / "rung-1")
    shutil.rmtree(root / "results" / "found" / "figures")
    code, lines = run_in(root, "--cores", "1", overlay=SEARCH)
    assert code == 0, lines
    assert bytes_of(root) == bytes_of(made)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"search": {}},
            "overlay.yaml: calibration.search: is empty; name at least one",
        ),
        ({"search": {"seed": [1, 2]}}, "seed: is no key of a simulation"),
        ({"search": {RATE: [1, -1]}}, "simulation.factory.mass_rate_kg_s: -1: is out of range"),
        ({"search": {"simulation.factry.x": [1, 2]}}, "simulation.factry: {x: 1}: unknown key"),
        ({"table": "nowhere.csv"}, "nowhere.csv: there is no such file"),
        ({"target": "wear_total_max"}, "table.csv: lacks wear_total_max, the calibration.target"),
        ({"replicates": [1, 2, 3]}, "rows and replicates must have the same number of rungs"),
        ({"element_sizes_mm": [30]}, "does not divide 300 mm of the plate into whole facets"),
    ],
)
def test_a_search_that_cannot_be_is_refused_before_it_begins(made, tmp_path, change, words):
    root = folder(tmp_path / "refused")
    changed = {**SEARCH, "calibration": {**SEARCH["calibration"], **change}}
    code, lines = run_in(root, "--dry-run", overlay=changed)
    assert code != 0
    assert any(words in line for line in lines), lines
    assert not (root / "results").exists()
