"""The tutorial: its cells run one after the other, as a reader runs them."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

from test_end_to_end import Project

ROOT = Path(__file__).parents[2]
NOTEBOOK = "docs/tutorial.ipynb"


def outputs(notebook):
    """Kinds of the outputs of each code cell."""
    return [
        [sorted(output.get("data", [output["output_type"]])) for output in cell["outputs"]]
        for cell in notebook["cells"]
        if cell["cell_type"] == "code"
    ]


def test_every_cell_runs_and_gives_what_the_page_shows(tmp_path):
    project = Project(tmp_path)
    (tmp_path / "docs").mkdir()
    for name in (NOTEBOOK, "docs/notebooks.py"):
        shutil.copy(ROOT / name, tmp_path / name)
    stored = json.loads((tmp_path / NOTEBOOK).read_text(encoding="utf-8"))
    done = subprocess.run(
        [sys.executable, "docs/notebooks.py", NOTEBOOK],
        cwd=tmp_path, env=project.environment, text=True, capture_output=True, check=False,
        timeout=1800,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / NOTEBOOK).read_text(encoding="utf-8"))
    assert [cell["source"] for cell in found["cells"]] == [
        cell["source"] for cell in stored["cells"]
    ]
    assert outputs(found) == outputs(stored)
    assert sum("image/png" in kinds for cell in outputs(found) for kinds in cell) == 3
