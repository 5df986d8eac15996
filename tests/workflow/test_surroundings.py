"""Environment variables and folders with which a run cannot do: forced, or named in one line."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from copies import run_in, workflow_in

ROOT = Path(__file__).parents[2]
TARGET = "results/smoke/cases.parquet"
# A process of root without these obeys the permissions of files.
OBEY = ["setpriv", "--bounding-set=-dac_override,-dac_read_search",
        "--inh-caps=-dac_override,-dac_read_search"]  # fmt: skip


@pytest.fixture
def copied(tmp_path):
    return workflow_in(tmp_path / "project")


def run(root, *arguments, **options):
    return run_in(root, *(arguments or (TARGET,)), **options)


def assert_one_line(status, lines, expected):
    assert status != 0, lines
    assert lines[-1].startswith(expected), lines
    assert not any("Traceback" in line or 'File "' in line for line in lines), lines


FOR_OTHERS = {
    "PYTHONOPTIMIZE": "2", "PYTHONWARNINGS": "error", "PYTHONIOENCODING": "ascii",
    "MPLBACKEND": "module://matplotlib_inline.backend_inline", "MATPLOTLIBRC": "/nonexistent",
    "MPLCONFIGDIR": "/proc/none", "SOURCE_DATE_EPOCH": "never", "LC_ALL": "C",
    "OMP_NUM_THREADS": "0", "NUMBA_NUM_THREADS": "0", "NUMBA_DISABLE_JIT": "1",
}  # fmt: skip
SETTINGS = "font.size: 30\nsavefig.dpi: 20\ntext.usetex: True\n"
FIGURE = "results/smoke/figures/rules.png"


def test_values_and_settings_meant_for_other_programs_change_no_figure(copied):
    status, lines = run(copied, FIGURE)
    assert status == 0, lines
    before = (copied / FIGURE).read_bytes()
    shutil.rmtree(copied / "results")
    (copied / "matplotlibrc").write_text(SETTINGS)
    status, lines = run(copied, FIGURE, **FOR_OTHERS)
    assert status == 0, lines
    assert (copied / FIGURE).read_bytes() == before


def test_settings_of_matplotlib_that_cannot_be_read_are_named(copied):
    (copied / "matplotlibrc").write_bytes(b"\xff\xfe")
    assert_one_line(*run(copied, "--dry-run", TARGET), f"{copied / 'matplotlibrc'}: matplotlib ")


def test_a_blank_in_the_path_of_python_is_one_line(copied, tmp_path):
    (tmp_path / "with blank").mkdir()
    python = tmp_path / "with blank" / "python"
    python.symlink_to(sys.executable)
    site = next(path for path in sys.path if path.endswith("site-packages"))
    status, lines = run(
        copied, python=[str(python)], PYTHONPATH=os.pathsep.join([str(ROOT / "src"), site])
    )
    assert_one_line(status, lines, f"{python}: the path of Python holds a blank")


def test_a_workflow_in_a_folder_with_a_blank_runs(tmp_path):
    root = workflow_in(tmp_path / "with blank")
    assert run(root)[0] == 0
    assert (root / TARGET).is_file()


@pytest.mark.parametrize("name", ["a{b}", "half{"])
def test_braces_in_the_path_of_the_workflow_are_one_line(tmp_path, name):
    root = workflow_in(tmp_path / name)
    assert_one_line(*run(root, "--dry-run", TARGET), f"{root}: the path of the workflow holds brac")


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_make_says_in_one_line_that_it_cannot_work_with_blanks(tmp_path):
    root = workflow_in(tmp_path / "with blank")
    done = subprocess.run(
        ["make", "help"], cwd=root, text=True, capture_output=True, timeout=60, check=False,
        # The tests may be run by make themselves.
        env={name: value for name, value in os.environ.items() if not name.startswith("MAKE")},
    )  # fmt: skip
    assert done.returncode != 0 and not done.stdout
    (line,) = done.stderr.splitlines()
    assert f"{root}: make and Snakemake cannot work in a folder with a blank" in line


def file_for_results(root):
    (root / "results").write_text("a file")
    return "results: is a file, where a folder must be"


def file_for_study(root):
    (root / "results").mkdir()
    (root / "results" / "smoke").write_text("a file")
    return "results/smoke: is a file, where a folder must be"


def dangling(root):
    (root / "results").symlink_to("/nonexistent/place")
    return "results: is a link to /nonexistent/place, which does not exist"


def loop(root):
    (root / "results").symlink_to("results")
    return "results: is a link to results, which does not exist"


@pytest.mark.parametrize("make", [file_for_results, file_for_study, dangling, loop])
def test_results_that_are_no_folder_are_one_line(copied, make):
    expected = make(copied)
    assert_one_line(*run(copied, "--dry-run", TARGET), expected)


@pytest.mark.parametrize("folder", ["results", "results/smoke", "results/smoke/cases"])
def test_a_folder_that_cannot_be_written_is_one_line_before_any_job(copied, folder):
    (copied / folder).mkdir(parents=True)
    (copied / folder).chmod(0o555)
    obey = [*OBEY, sys.executable] if os.geteuid() == 0 else [sys.executable]
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        pytest.skip("root writes everywhere")
    try:
        # What is there can still be looked at.
        assert run(copied, "--dry-run", TARGET, python=obey)[0] == 0
        status, lines = run(copied, python=obey)
    finally:
        (copied / folder).chmod(0o755)
    assert_one_line(status, lines, f"{folder}: cannot be written: Permission denied")
    assert not list((copied / "results").rglob("*.parquet"))


def test_a_folder_of_the_system_is_one_line(copied):
    (copied / "results").symlink_to("/proc")
    assert_one_line(*run(copied), "results: cannot be written: ")
