"""Full disks, folders without write permission, too little memory, files of killed writers."""

import errno
import os
import subprocess
import sys

import pytest
from cases import SETUP, table_of_cases

from abradem.simulation.batch import FILES
from abradem.store.files import replacing, write_json
from abradem.store.tables import write_table

LIMITED = """
import resource, signal, sys
import abradem.dem, numpy, pandas, pyarrow.parquet
from abradem.running.job_log import log_to
from abradem.store.tables import read_table
from abradem.simulation.batch import FILES, run_batch
log_to("job.log")
kind, most, setup = sys.argv[1], int(sys.argv[2]), dict(eval(sys.argv[3]))
cases = read_table("cases.parquet")
if kind == "file":
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
elif kind == "memory":
    abradem.dem.simulate  # its kernels are loaded before the limit is set
    from abradem.dem.warm import warm
    warm()
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + most, used + most))
run_batch(cases, setup, {name: f"{name}.parquet" for name in FILES}, "finished/batch", "code")
"""
"""A batch in a process of its own, under a limit."""


def batch_job(folder, kind, most, setup=SETUP):
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-c", LIMITED, kind, str(most), repr(list(setup.items()))],
        cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip


def written(folder):
    return sorted(path.name for path in folder.glob("*.parquet") if path.name != "cases.parquet")


@pytest.fixture
def cases(tmp_path):
    found = table_of_cases(2).assign(particle_radius=0.03, plate_angle=[30.0, 60.0])
    write_table(found, tmp_path / "cases.parquet")
    return found


@pytest.mark.skipif(sys.platform == "win32", reason="limits of resources are of Unix")
def test_a_disk_that_fills_up_is_one_line_and_the_batch_goes_on_later(cases, tmp_path):
    """No file may grow beyond a limit that a series needs: the same error paths as a full disk."""
    refused = batch_job(tmp_path, "file", 4000)
    assert refused.returncode != 0
    (line,) = refused.stderr.splitlines()
    assert os.strerror(errno.EFBIG) in line and ".parquet" in line and "job.log" in line
    assert written(tmp_path) == [] and not list(tmp_path.rglob("*.tmp"))
    assert batch_job(tmp_path, "none", 0).returncode == 0
    assert written(tmp_path) == [f"{name}.parquet" for name in sorted(FILES)]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks Linux for what is used")
def test_a_case_without_memory_is_one_line_and_the_others_are_kept(cases, tmp_path):
    """Maps of 9 million facets do not fit; nothing is recorded as a result of the case."""
    refused = batch_job(tmp_path, "memory", 100_000_000, {**SETUP, "facet_size": 0.0001})
    assert refused.returncode != 0
    lines = refused.stderr.splitlines()
    assert [line.split(":")[0] for line in lines] == ["case 0", "case 1"]
    assert all("too little memory" in line for line in lines)
    assert written(tmp_path) == []


def test_an_error_of_the_file_system_names_the_file(tmp_path):
    (tmp_path / "folder").write_text("")
    with pytest.raises(OSError, match="folder"):
        write_json({}, tmp_path / "folder" / "a.json")
    with (
        pytest.raises(OSError, match=r"No space left on device: .*b\.json"),
        replacing(tmp_path / "b.json"),
    ):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert not list(tmp_path.glob("*.json")) and not list(tmp_path.glob(".*"))


def test_what_a_killed_writer_left_is_removed_by_the_next(tmp_path):
    ended = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"],
                           capture_output=True, text=True, check=True)  # fmt: skip
    left = tmp_path / f".a.json.{int(ended.stdout)}.tmp"
    living = tmp_path / f".a.json.{os.getppid()}.tmp"
    other = tmp_path / ".b.json.1.tmp"
    for path in (left, living, other):
        path.write_text("half")
    write_json({}, tmp_path / "a.json")
    assert not left.exists() and living.exists() and other.exists()
