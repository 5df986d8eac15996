"""Free text of the configuration is no pattern of Snakemake: braces in it are braces."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from tables import product_law

from abradem.quantities import SAMPLED_NAMES

ROOT = Path(__file__).parents[2]
TEXTS = ["Wear by {DEM}", "{block}", "{{a}} {", "} {wildcards.case} {0}", "{a,\\d+}"]


def project(root):
    """The files of the workflow in a folder of its own."""
    for name in ("Snakefile", "config.yaml"):
        shutil.copy2(ROOT / name, root)
    for name in ("workflow", "profiles", "studies", "paper"):
        shutil.copytree(ROOT / name, root / name)
    return root


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    return project(tmp_path_factory.mktemp("braces"))


def snakemake(root, overlay, *arguments, **environment):
    """Run with nested values as an override file; returns exit status and output."""
    (root / "overlay.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
    done = subprocess.run(
        [
            sys.executable, "-m", "snakemake", *arguments,
            "--configfile", "config.yaml", "studies/smoke.yaml", "overlay.yaml",
        ],
        cwd=root, env={**os.environ, "PYTHONPATH": str(ROOT / "src"), **environment}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout


@pytest.mark.parametrize("text", TEXTS)
def test_braces_in_the_metadata_of_a_study_are_no_wildcards(copied, text):
    overlay = {"publish": {"title": text, "creators": [text, "Ada"]}}
    status, said = snakemake(copied, overlay, "--dry-run", "all", "publish", "provenance")
    assert status == 0, said
    if text == TEXTS[0]:
        status, said = snakemake(copied, overlay, "results/smoke/config.yaml")
        assert status == 0, said
        written = yaml.safe_load((copied / "results/smoke/config.yaml").read_text())
        assert written["publish"]["title"] == text


@pytest.mark.parametrize("text", TEXTS)
def test_braces_in_the_path_and_the_columns_of_a_table_are_no_wildcards(copied, text):
    column = f"slope {text}"
    table = product_law(24)[[*SAMPLED_NAMES, "wear_total_mean"]]
    name = f"{text}, 'my_table_\".csv"
    table.rename(columns={"plate_angle": column}).to_csv(copied / name, index=False)
    overlay = {
        "study": "elsewhere",
        "dataset": {"external": name, "columns": {"plate_angle": column}},
    }
    status, said = snakemake(copied, overlay, "--dry-run")
    assert status == 0, said
    assert "Missing input" not in said
    if text == TEXTS[0]:
        files = [f"results/elsewhere/{name}" for name in ("dataset.parquet", "rule_graph.parquet")]
        status, said = snakemake(copied, overlay, *files)
        assert status == 0, said
        assert all((copied / file).is_file() for file in files)
