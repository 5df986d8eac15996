"""A job that fails leaves all it knows in its log and one line for the user."""

import subprocess
import sys


def run(tmp_path, code):
    return subprocess.run(
        [sys.executable, "-c", f"from abradem.joblog import log_to\nlog_to('job.log')\n{code}"],
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
