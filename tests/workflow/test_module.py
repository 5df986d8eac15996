"""The workflow as a module of another workflow, with its own configuration and folders."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from abradem.store.tables import read_table

ROOT = Path(__file__).parents[2]
SMOKE = yaml.safe_load((ROOT / "studies" / "smoke.yaml").read_text(encoding="utf-8"))
WEAR = {**SMOKE, "study": "theirs", "sampling": {**SMOKE["sampling"], "blocks": 1}}

SNAKEFILE = f"""
configfile: "theirs.yaml"

module wear:
    snakefile: "{ROOT / "Snakefile"}"
    config: config["wear"]
    prefix: "made"

use rule * from wear as wear_*

rule all:
    default_target: True
    input: rules.wear_dataset.output,
    output: "rows.txt",
    shell: "ls {{input}} > {{output}}"
"""


@pytest.fixture
def theirs(tmp_path):
    """Runs snakemake on a workflow that imports this one; returns exit status and output."""
    (tmp_path / "Snakefile").write_text(SNAKEFILE, encoding="utf-8")

    def snakemake(*arguments, wear=WEAR):
        # A file of the importing workflow with the same name is not used.
        (tmp_path / "config.yaml").write_text("[not ours]", encoding="utf-8")
        config = yaml.safe_dump({"study": "outer", "wear": wear})
        (tmp_path / "theirs.yaml").write_text(config, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-m", "snakemake", "--cores", "1", *arguments],
            cwd=tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            timeout=300, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout

    return snakemake


def test_a_study_is_made_within_another_workflow(theirs, tmp_path):
    status, text = theirs("made/results/theirs/cases.parquet")
    assert status == 0, text
    assert len(read_table(tmp_path / "made/results/theirs/cases.parquet")) == 6
    status, text = theirs("--dry-run", "all", "wear_all", "wear_publish", "wear_verification")
    assert status == 0, text
    assert "wear_dataset" in text and "wear_sample" not in text
    made = {path.name for path in tmp_path.iterdir()}
    assert made == {"Snakefile", "config.yaml", "theirs.yaml", "made", ".snakemake"}


def test_a_wrong_value_is_one_line_that_names_the_module(theirs):
    status, text = theirs("--dry-run", wear={**WEAR, "seed": -1})
    assert status != 0
    assert text.splitlines()[-1].startswith("config of the module: seed: -1: ")
