"""Studies in which two quantities vary, as most do, or none, by the workflow."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.store.files import read_json
from abradem.store.tables import read_table

ROOT = Path(__file__).parents[2]
VARIED = {"plate_angle": [20, 60], "particle_velocity_y": [-8, -2]}
FIXED = {
    "particle_shear_modulus_gpa": 6, "particle_poisson_ratio": 0.3, "particle_density": 2600,
    "equipment_shear_modulus_gpa": [80, 80], "equipment_poisson_ratio": 0.28,
    "equipment_density": 7800, "restitution": 0.5, "rolling_friction": 0.05,
    "static_friction": 0.45, "archard_constant": 1e-9, "factory_angle": -30,
    "particle_radius_mm": 25,
}  # fmt: skip
NO_NUMBER = re.compile(r"(?<![A-Za-z])(nan|NaN|inf|None)(?![A-Za-z])|(?<=\d)e\+?([3-9]\d|\d{3})")


def run(root, ranges, *targets):
    """Run the small study with other ranges."""
    for name in ("Snakefile", "config.yaml"):
        shutil.copy2(ROOT / name, root)
    for name in ("studies", "workflow", "profiles"):
        shutil.copytree(ROOT / name, root / name)
    values = {"study": "few", "sampling": {"cases_per_block": 6, "ranges": ranges}}
    (root / "few.yaml").write_text(yaml.safe_dump(values))
    return subprocess.run(
        [
            sys.executable, "-m", "snakemake", *targets, "--configfile", "config.yaml",
            "studies/smoke.yaml", "few.yaml",
        ],
        cwd=root, text=True, check=False, timeout=1800, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
    )  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    root = tmp_path_factory.mktemp("two")
    done = run(root, {**FIXED, **VARIED}, "documents")
    assert done.returncode == 0, done.stdout
    return root / "results" / "few"


def test_exponents_are_stated_of_what_varied_alone(results):
    rows = read_table(results / "learning" / "power_law.parquet").set_index("term")
    quantities = rows[rows["kind"] == "quantity"]["variation"]
    assert quantities["impact_speed"] == "varied"
    assert set(quantities.drop("impact_speed")) == {"held fixed"}
    equation = read_json(results / "learning" / "physical.json")["equation"]
    assert "held fixed, their effect is in the constant: (R/H)" in equation
    assert "tell them apart: Fr, L, Ca" in equation


def test_findings_rank_what_varied_and_name_the_rest(results):
    text = (results / "models" / "findings.html").read_text(encoding="utf-8")
    assert "These quantities had the same value in all cases" in text
    assert "Hardly any effect" not in text.partition("Held fixed, hence")[2]
    said = read_json(results / "learning" / "sensitivity.json")
    assert set(said["dominant"]) == set(VARIED)
    assert set(said["held_fixed"]) == set(SAMPLED_NAMES) - set(VARIED)


def test_no_text_of_the_study_has_a_number_that_is_none(results):
    files = [*results.glob("latex/*.tex"), *results.glob("tables/*.csv"),
             results / "models" / "findings.html"]  # fmt: skip
    assert len(files) > 15
    for file in files:
        assert not NO_NUMBER.search(file.read_text(encoding="utf-8")), file


def test_the_summary_of_the_report_names_them(results):
    assert "particle radius" in read_json(results / "summary.json")["held_fixed"]


def test_a_study_without_a_quantity_that_varies_is_refused_before_it_is_simulated(tmp_path):
    fixed = {**FIXED, **{name: ends[0] for name, ends in VARIED.items()}}
    assert len(fixed) == len(SAMPLED)
    done = run(tmp_path, fixed)
    assert done.returncode != 0
    (line,) = [line for line in done.stdout.splitlines() if "nothing can be learned" in line]
    assert line.startswith("sampling.ranges: every quantity is held fixed")
    assert not list(tmp_path.glob("results/few/runs/*"))
