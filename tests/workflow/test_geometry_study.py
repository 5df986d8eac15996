"""A study of a geometry by the workflow: cells, parts, figures and the answer in words."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from abradem.store.tables import read_table, read_units

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.slow

SMALL = {
    "study": "chain",
    "sampling": {"cases_per_block": 3, "ranges": {"particle_shear_modulus_gpa": 0.02}},
    "simulation": {
        "cases_per_job": 2,
        "time_step_rayleigh_fraction": 0.1,
        "plate": {"facet_size_mm": 100},
        "factory": {"mass_rate_kg_s": 8},
        "stop": {"window_s": 0.5, "max_time_s": 1.5, "target_stderr": 1.0,
                 "sample_interval_s": 0.01},
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """A copy of the workflow, with the study of few cases and coarse cells as small.yaml."""
    root = tmp_path_factory.mktemp("geometry")
    for name in ("Snakefile", "config.yaml"):
        shutil.copy2(ROOT / name, root)
    for name in ("studies", "workflow", "profiles"):
        shutil.copytree(ROOT / name, root / name)
    (root / "small.yaml").write_text(yaml.safe_dump(SMALL))
    return root


def snakemake(root, *arguments):
    """Run Snakemake on the study of two plates and return what it prints."""
    done = subprocess.run(
        [
            sys.executable, "-m", "snakemake", "--configfile", "config.yaml",
            "studies/two_plates.yaml", *arguments,
        ],
        cwd=root, text=True, check=False, timeout=1800, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), *sys.path])},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.fixture(scope="module")
def results(root):
    """The study of two plates with few cases and coarse cells."""
    snakemake(root, "small.yaml")
    return root / "results" / "chain"


def test_enough_cases_end_in_models_and_few_in_their_parts(root):
    """Models of the plate's maps and replicates are left out, and the paper's networks."""
    many = set(re.findall(r"^(\w+) +\d+$", snakemake(root, "--dry-run"), re.MULTILINE))
    few = set(re.findall(r"^(\w+) +\d+$", snakemake(root, "small.yaml", "-n"), re.MULTILINE))
    models = {
        "part_rows", "linear", "trees", "fit_physical", "surrogate", "sensitivity", "scores",
        "explorer", "model_card", "findings",
    }  # fmt: skip
    of_plate = {"wear_maps", "replicates", "noise_floor", "speed_up", "ga_ann", "latex"}
    assert models <= many and not of_plate & many
    assert {"cells", "part_effects", "dataset"} <= many & few
    assert not (models | of_plate) & few


def test_the_data_set_has_the_quantities_of_the_geometry(results):
    dataset = read_table(results / "dataset.parquet")
    assert len(dataset) == 3
    assert dataset["plate_2_angle"].between(120.0, 165.0).all()
    assert read_units(results / "dataset.parquet")["plate_2_angle"] == "deg"


def test_cells_and_parts_agree_with_the_data_set(results):
    """The mean over both plates in the window is near the steady slope of the data set."""
    cells = read_table(results / "cells.parquet")
    parts = read_table(results / "wear_by_part.parquet").set_index(["case_id", "part_name"])
    for case, rows in cells.groupby("case_id"):
        for name, of_part in rows.groupby("part_name"):
            area = of_part["cell_area"]
            mean = (of_part["depth_rate_friction"] * area).sum() / area.sum()
            assert parts.loc[(case, name), "wear_friction_mean"] == pytest.approx(mean)
    dataset = read_table(results / "dataset.parquet").set_index("case_id")
    for case in dataset.index:
        of_case = parts.loc[case]
        mean = (of_case["wear_friction_mean"] * of_case["area"]).sum() / of_case["area"].sum()
        assert mean == pytest.approx(dataset.loc[case, "wear_friction_mean"], rel=0.5)


def test_the_page_answers_and_the_figures_are_there(results):
    text = (results / "parts.html").read_text(encoding="utf-8")
    assert "Of 2 parts" in text and "wears most" in text
    for name in ("surface", "part_rates"):
        assert (results / "figures" / f"{name}.png").stat().st_size > 5_000
