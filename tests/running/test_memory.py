"""Too little memory is said in one line, by the command line and by the workflow."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from abradem.cli.main import LEAST_MEMORY
from abradem.running import memory
from abradem.store.errors import memory_limit, memory_problem

CONFIG = Path(__file__).parents[2] / "config.yaml"

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="limits and counters of Linux"
)


def limited(megabytes, *arguments, code="", cwd=None):
    """The command line, or other code, with a limit of its address space, as by ``ulimit -v``."""

    def limit():
        size = megabytes * 2**20
        resource.setrlimit(resource.RLIMIT_AS, (size, size))

    program = ["-c", code] if code else ["-m", "abradem.cli.main", *arguments]
    return subprocess.run(
        [sys.executable, *program],
        capture_output=True, text=True, check=False, preexec_fn=limit, timeout=300, cwd=cwd,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip


LOADING = """
import resource, sys
import numpy, abradem.dem.cache
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 50 * 2**20,) * 2)
from abradem.cli.main import main
import abradem.cli.main as cli
def load(options):
    import numba
cli._parser = lambda: type("P", (), {"parse_args": lambda self, a: type("O", (), {"run": load})})()
sys.exit(main([]))
"""
"""The engine's compiler is loaded where there is no room for it."""


@pytest.mark.parametrize("command", LEAST_MEMORY)
def test_a_limit_that_is_too_small_is_said_before_anything_is_loaded(command):
    """Without a check, what is loaded first ends, hangs or crashes the process."""
    least = LEAST_MEMORY[command]
    for megabytes in (50, least - 1):
        said = limited(megabytes, command, "--help")
        assert said.returncode == 3 and said.stdout == ""
        assert said.stderr == (
            f"there was too little memory (limited to {megabytes} MB by `ulimit -v`): "
            f"abradem {command} needs {least} MB\n"
        )


@pytest.mark.parametrize("megabytes", [175, 220, 250])
def test_a_library_that_finds_no_room_is_one_line(megabytes):
    """Libraries by what is loaded first, where the check of the limit is left out."""
    code = f"""
import sys
import abradem.cli.main as cli
cli.LEAST_MEMORY = dict.fromkeys(cli.LEAST_MEMORY, 0)
sys.exit(cli.main(["config", "--check", {str(CONFIG)!r}]))
"""
    said = limited(megabytes, code=code)
    (line,) = said.stderr.splitlines()
    assert said.returncode == 3 and line.startswith("there was too little memory (limited to ")


JOB = """
from types import SimpleNamespace
snakemake = SimpleNamespace(log=["job.log"], input=[], output=[])
from abradem.running.job_log import start_job
start_job(snakemake)
import pandas, numba
"""


@pytest.mark.parametrize("megabytes", [100, 999])
def test_a_job_with_too_small_a_limit_is_one_line(megabytes, tmp_path):
    said = limited(megabytes, code=JOB, cwd=tmp_path)
    assert said.returncode == 1 and said.stderr == (
        f"there was too little memory (limited to {megabytes} MB by `ulimit -v`): a job needs "
        "1000 MB (see job.log)\n"
    )


def test_a_compiler_that_finds_no_room_is_not_called_missing():
    done = subprocess.run([sys.executable, "-c", LOADING], capture_output=True, text=True,
                          check=False, timeout=300)  # fmt: skip
    (line,) = done.stderr.splitlines()
    assert done.returncode == 3 and line.startswith("there was too little memory (limited to")
    assert "not found" not in line and "cannot be found" not in line


def test_without_a_limit_a_missing_library_is_not_for_want_of_memory():
    assert memory_limit() is None
    error = OSError("Could not find/load shared object file 'libllvmlite.so'")
    assert memory_problem(error) is None
    assert memory_problem(ValueError("x")) is None


def test_processes_that_the_system_ended_are_counted(tmp_path, monkeypatch):
    counter = tmp_path / "vmstat"
    monkeypatch.setattr(memory, "COUNTERS", (tmp_path / "none", counter))
    assert memory.memory_kills() == 0
    counter.write_text("pgfault 7\noom_kill 3\nother 1\n")
    assert memory.memory_kills() == 3
    assert memory.killed_for_memory(3) is None
    assert "1 process was ended by the operating system" in memory.killed_for_memory(2)
    assert "3 processes were ended" in memory.killed_for_memory(0)


def test_the_counter_of_this_machine_is_read():
    assert memory.memory_kills() >= 0
    assert any(path.is_file() for path in memory.COUNTERS)
