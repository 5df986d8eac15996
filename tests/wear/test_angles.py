"""Short simulations for pictures, run times, and the graph of rules."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from abradem.config import ConfigError, load_config, typical_case
from abradem.dem.model import Setup
from abradem.running.rule_graph import from_dot, rule_graph, stages
from abradem.running.run_times import run_times
from abradem.simulation.snapshots import write_scene
from abradem.store.tables import read_table
from abradem.wear.angles import depth_by_angle
from abradem.wear.depths import depth_frames

ROOT = Path(__file__).parents[2]
CASE = typical_case(load_config({"study": "x"})) | {"particle_radius": 0.02}
SETUP = Setup(facet_size=0.05)


def test_a_particle_of_the_pictures_that_is_wider_than_the_plate_is_one_line():
    values = {
        "study": "x",
        "simulation": {"plate": {"length_mm": 150.0}},
        "sampling": {"ranges": {"particle_radius_mm": 10.0}},
        "figures": {"typical": {"particle_radius_mm": 80.0}},
    }
    with pytest.raises(ConfigError, match=r"figures\.typical\.particle_radius_mm: 80\.0: .* 75 mm"):
        load_config(values)


def test_depth_by_angle_varies_one_angle_and_holds_the_other():
    from abradem import Case, simulate

    angles = {"plate_angle": [30.0, 60.0], "factory_angle": [0.0]}
    curves, rates = depth_by_angle(CASE, SETUP, angles, 2.0)
    assert rates["angle"].tolist() == [30.0, 60.0, 0.0]
    alone = simulate(Case(**{**CASE, "factory_angle": 0.0}), Setup(facet_size=0.05, duration=2.0))
    mine = curves[curves["varied"] == "factory_angle"]
    depth = 1e3 * CASE["archard_constant"] / SETUP.plate_area * alone.worn[:, 0]
    np.testing.assert_array_equal(mine["wear_depth"], depth)
    for row in rates.itertuples():
        curve = curves[(curves["varied"] == row.varied) & (curves["angle"] == row.angle)]
        assert curve["wear_depth"].is_monotonic_increasing
        assert row.rate == pytest.approx(curve["wear_depth"].iloc[-1] / 2.0, rel=0.3)


def test_a_depth_of_the_frames_is_the_plate_mean_of_the_series(tmp_path):
    write_scene(CASE, SETUP, tmp_path, 1.0, 0.25)
    wear = read_table(tmp_path / "wear.parquet")
    times, depth = depth_frames(wear, CASE, SETUP)
    assert depth.shape == (len(times), *SETUP.facets) and times[0] == 0.0
    worn = wear.groupby("time")["wear_total"].sum()
    mean = 1e3 * CASE["archard_constant"] / SETUP.plate_area * worn
    np.testing.assert_allclose(depth.mean(axis=(1, 2)), mean, rtol=1e-12)


def test_run_times_are_summed_by_rule_and_half_written_files_do_not_count(tmp_path):
    (tmp_path / "simulate").mkdir()
    for name, seconds in (("a", 2.0), ("b", 3.5)):
        (tmp_path / "simulate" / f"{name}.tsv").write_text(f"s\th:m:s\n{seconds}\t0:00:02\n")
    (tmp_path / "simulate" / "c.tsv").write_text("s\th:m:s\n")
    (tmp_path / "angles.tsv").write_text("s\th:m:s\n9.0\t0:00:09\n")
    (tmp_path / "half.tsv").write_text("")
    assert run_times(tmp_path) == [
        {"rule": "angles", "jobs": 1, "seconds": 9.0, "longest": 9.0},
        {"rule": "simulate", "jobs": 2, "seconds": 5.5, "longest": 3.5},
    ]
    assert run_times(tmp_path / "nothing") == []


def test_every_rule_has_the_file_it_stands_in_first():
    files = sorted((ROOT / "workflow" / "rules").glob("*.smk"))
    found = stages(files)
    assert found["simulate"] == "simulation" and found["dataset"] == "dataset"
    assert found["figure_flow"] == "paper"


def test_the_graph_of_rules_is_a_table_of_pairs():
    dot = '0[label = "all"];\n1[label = "b\\nx: 1"];\n2[label = "a"];\n2 -> 1\n1 -> 0\n'
    graph = from_dot(dot, {"a": "first", "b": "second"})
    expected = pd.DataFrame({"rule": ["a", "b"], "stage": ["first", "second"], "needs": ["", "a"]})
    pd.testing.assert_frame_equal(graph, expected, check_dtype=False)


def test_a_workflow_that_is_wrong_is_one_line(tmp_path):
    snakefile = tmp_path / "Snakefile"
    snakefile.write_text("import sys\nsys.exit('no such study')\n")
    with pytest.raises(RuntimeError, match=r"snakemake --rulegraph failed: ") as error:
        rule_graph(snakefile, [])
    assert "\n" not in str(error.value)
