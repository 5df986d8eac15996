"""A failing job writes the traceback to its log and one line to the user; a good one, checksums."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from abradem.running.outputs import record_outputs
from abradem.store.checksums import FOLDER, damage, recorded

ROOT = Path(__file__).parents[2]


def run(tmp_path, code):
    code = f"from abradem.running.job_log import log_to\nlog_to('job.log')\n{code}"
    return subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_a_failure_is_one_line_with_the_name_of_the_log(tmp_path):
    job = run(tmp_path, "raise ValueError('case 7: too soft')")
    assert job.returncode == 1
    assert job.stderr == "case 7: too soft (see job.log)\n"
    assert "Traceback" in (tmp_path / "job.log").read_text()


def test_warnings_go_to_the_log(tmp_path):
    job = run(tmp_path, "import warnings\nwarnings.warn('steep')")
    assert job.returncode == 0 and job.stderr == ""
    assert "steep" in (tmp_path / "job.log").read_text()


def test_a_log_is_there_though_nothing_was_said(tmp_path):
    run(tmp_path, "")
    assert (tmp_path / "job.log").read_text() == ""


def test_too_little_memory_is_said_in_words(tmp_path):
    job = run(tmp_path, "raise MemoryError")
    assert job.stderr == "there was too little memory (see job.log)\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_does_not_swallow_the_line(tmp_path):
    (tmp_path / "job.log").symlink_to("/dev/full")
    job = run(tmp_path, "raise ValueError('case 7: too soft')")
    assert job.returncode != 0
    assert job.stderr.splitlines()[0] == "case 7: too soft (see job.log)"


# Records of finished files


SCRIPT = """
from types import SimpleNamespace
from pathlib import Path
snakemake = SimpleNamespace(
    log=["results/a/logs/linear.log"], input=["results/a/in.json"],
    output=["results/a/learning/linear.json", "results/a/vtk", "elsewhere.json"],
)
from abradem.running.job_log import start_job
start_job(snakemake, *FOLDERS)
from abradem.store.files import write_json
write_json({"a": 1}, snakemake.output[0])
write_json({"b": 1}, "results/a/vtk/b.json")
write_json({"c": 1}, snakemake.output[2])
write_json({"d": 1}, "results/a/publish/d.json")
"""


def job(folder, code="", folders="[]"):
    (folder / "results" / "a" / "logs").mkdir(parents=True, exist_ok=True)
    script = f"FOLDERS = {folders}\n{SCRIPT}\n{code}"
    return subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True,
                          text=True, check=False)  # fmt: skip


def test_a_job_records_what_it_wrote_once_it_has_ended(tmp_path):
    done = job(tmp_path, "assert not Path('results/a/checksums').exists()")
    assert (done.returncode, done.stderr) == (0, "")
    study = tmp_path / "results" / "a"
    assert list(recorded(study)) == ["learning/linear.json", "vtk/b.json"]
    record = json.loads((study / FOLDER / "vtk" / "b.json.sha256").read_text())
    assert (record["job"], record["target"]) == ("linear", "vtk")
    first = {path: path.read_bytes() for path in (study / FOLDER).rglob("*.sha256")}
    assert job(tmp_path).returncode == 0
    assert first == {path: path.read_bytes() for path in (study / FOLDER).rglob("*.sha256")}


def test_a_folder_that_a_job_writes_as_a_whole_is_recorded_too(tmp_path):
    assert job(tmp_path, folders="['results/a/publish']").returncode == 0
    record = tmp_path / "results" / "a" / FOLDER / "publish" / "d.json.sha256"
    assert json.loads(record.read_text())["target"] == "learning/linear.json"


@pytest.mark.parametrize(
    "end", ["raise ValueError('x')", "import os; os.kill(os.getpid(), 9)", "import nowhere"]
)
def test_a_job_that_fails_or_is_killed_records_nothing(tmp_path, end):
    assert job(tmp_path, end).returncode != 0
    assert not (tmp_path / "results" / "a" / FOLDER).exists()


def test_children_of_a_job_record_nothing(tmp_path):
    code = """
import os, sys
if os.fork() == 0:
    Path(snakemake.output[0]).write_text("{")
    sys.exit()
os.wait()
write_json({"a": 2}, snakemake.output[0])
"""
    assert job(tmp_path, code).returncode == 0
    assert damage(tmp_path / "results" / "a" / "learning" / "linear.json") is None


def test_a_record_that_cannot_be_written_fails_the_job_in_one_line(tmp_path):
    (tmp_path / "results" / "a").mkdir(parents=True)
    (tmp_path / "results" / "a" / FOLDER).write_text("in the way")
    failed = job(tmp_path)
    assert failed.returncode == 1
    (line,) = failed.stderr.splitlines()
    assert FOLDER in line and line.endswith("(see results/a/logs/linear.log)")


def test_a_damaged_input_ends_a_job_before_it_is_read(tmp_path):
    """A flipped digit of a JSON would be read as another number."""
    study = tmp_path / "results" / "a"
    study.mkdir(parents=True)
    (study / "in.json").write_text('{"wear": 1}')
    record_outputs(study, "other", [study / "in.json"])
    assert job(tmp_path).returncode == 0
    (study / "in.json").write_text('{"wear": 7}')
    failed = job(tmp_path, "Path('read').touch()")
    assert failed.returncode == 1 and not (tmp_path / "read").exists()
    assert failed.stderr == (
        "results/a/in.json: damaged, differs from what its job wrote; `abradem doctor results/a "
        "--delete` removes what is damaged, and the next run makes it again "
        "(see results/a/logs/linear.log)\n"
    )


@pytest.mark.parametrize(
    "script", sorted((ROOT / "workflow" / "scripts").rglob("*.py")), ids=lambda path: path.stem
)
def test_every_script_starts_its_job_before_it_imports_what_may_fail(script):
    text = script.read_text(encoding="utf-8")
    before, _, after = text.partition("start_job(snakemake")
    imported = set(re.findall(r"^(?:from|import) (\S+)", before, re.MULTILINE))
    assert after and imported <= {"abradem.running.job_log", "pathlib"}


def test_what_starts_a_job_needs_the_standard_library_alone():
    code = (
        "import sys, abradem.running.job_log\n"
        "print({'numpy', 'pandas', 'pyarrow', 'numba'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


# Memory


@pytest.mark.parametrize(
    "error",
    [
        "MemoryError('7 GB')",
        "OSError(12, 'Cannot allocate memory')",
        "ImportError('/x/join.so: failed to map segment from shared object')",
        'RuntimeError("can\'t start new thread")',
        "OSError('Unknown error: Failed to launch worker thread')",
    ],
)
def test_too_little_memory_is_said_whatever_a_library_calls_it(tmp_path, error):
    failed = run(tmp_path, f"raise {error}")
    (line,) = failed.stderr.splitlines()
    assert line.startswith("there was too little memory")
    failed = run(tmp_path, f"try:\n    raise {error}\nexcept Exception:\n    1 / 0")
    assert failed.stderr.startswith("there was too little memory")


@pytest.mark.parametrize(
    "error", ["OSError('libllvmlite.so not found')", "ImportError('no module named x')",
              "OSError(28, 'No space left on device')", "ValueError('out of range')"]
)  # fmt: skip
def test_other_errors_are_no_lack_of_memory(tmp_path, error):
    assert "memory" not in run(tmp_path, f"raise {error}").stderr
