"""A failing job writes the traceback to its log and one line to the user."""

import subprocess
import sys
from pathlib import Path

import pytest


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
