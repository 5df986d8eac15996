"""Many batches: the longest start first, and the job graph grows linearly with their number."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# If a rule takes a file of another rule in addition to a named list, Snakemake hashes the whole
# list for each of its files. The number of hashed files shows this more reliably than the time.
COUNTING = """
import sys
from snakemake import cli, iocontainers

hashed = 0

def counted(items):
    global hashed
    hashed += len(items)
    return hash(tuple(items))

iocontainers.Namedlist.__hash__ = counted
try:
    cli.main(sys.argv[1:])
finally:
    print(f"hashed {hashed}")
"""

OVERLAY = """
study: many
sampling: {blocks: 6, cases_per_block: 60}
simulation: {cases_per_job: 3}
"""


@pytest.fixture(scope="module")
def dry_run(tmp_path_factory):
    """Output of a dry run of a study with 120 batches, with every job."""
    root = tmp_path_factory.mktemp("many")
    for name in ("Snakefile", "config.yaml"):
        shutil.copy2(ROOT / name, root)
    for name in ("workflow", "profiles"):
        shutil.copytree(ROOT / name, root / name)
    (root / "many.yaml").write_text(OVERLAY)
    done = subprocess.run(
        [
            sys.executable, "-c", COUNTING, "--dry-run", "--quiet", "host",
            "--configfile", "config.yaml", "many.yaml",
        ],
        cwd=root, env={**os.environ, "PYTHONPATH": str(ROOT / "src")}, text=True, check=False,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300,
    )  # fmt: skip
    assert "This was a dry-run" in done.stdout, done.stdout
    return done.stdout


def test_work_on_the_graph_of_jobs_is_in_proportion_to_the_jobs(dry_run):
    assert re.search(r"^simulate +120$", dry_run, re.MULTILINE)
    assert int(re.search(r"^hashed (\d+)$", dry_run, re.MULTILINE)[1]) < 1000


def test_the_longest_simulations_start_first_and_samples_before_them(dry_run):
    jobs = re.findall(r"^rule (\w+):\n((?:    .*\n)+)", dry_run, re.MULTILINE)
    order = {rule: [] for rule, _ in jobs}
    for rule, job in jobs:
        order[rule].append(float((re.findall(r"priority: (\S+)", job) or [0])[0]))
    assert len(set(order["simulate"])) == 120
    assert min(order["sample"]) > max(order["simulate"]) > 10.0 * min(order["simulate"]) > 0.0
    assert set(order["wear_rates"]) == {0.0}
