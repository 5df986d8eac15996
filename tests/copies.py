"""Copies of the workflow in folders of their own, and short runs of Snakemake in them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]


def workflow_in(root):
    """Copy the files of the workflow to a folder, and return it."""
    root.mkdir(parents=True, exist_ok=True)
    for name in ("Snakefile", "config.yaml", "Makefile"):
        shutil.copy2(ROOT / name, root)
    for name in ("workflow", "profiles", "studies", "paper"):
        shutil.copytree(ROOT / name, root / name)
    return root


def run_in(root, *arguments, overlay=None, python=(sys.executable,), **environment):
    """Run Snakemake on the smoke study; returns exit status and the lines that are not empty.

    ``overlay`` holds nested values of an override file.
    """
    (root / "overlay.yaml").write_text(yaml.safe_dump(overlay or {"seed": 1}), encoding="utf-8")
    done = subprocess.run(
        [
            *python, "-m", "snakemake", *arguments,
            "--configfile", "config.yaml", "studies/smoke.yaml", "overlay.yaml",
        ],
        cwd=root, env={**os.environ, "PYTHONPATH": str(ROOT / "src"), **environment}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300, check=False,
    )  # fmt: skip
    return done.returncode, [line for line in done.stdout.splitlines() if line.strip()]
