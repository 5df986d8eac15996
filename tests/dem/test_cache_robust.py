"""The cache of compiled kernels: concurrent processes, damaged files, folders of other users."""

import os
import subprocess
import sys
from pathlib import Path

from abradem.dem import cache

PROCESSES = int(os.environ.get("ABRADEM_PROCESSES", "5"))
"""docs/reliability.md has them at 20."""

# Two signatures of one function and a caller of both, compiled in an order that the process
# chooses, so that index and machine code could be mixed up.
QUESTION = """
import sys
import numpy as np
from abradem.dem.cache import kernel

@kernel
def twice(x):
    return x + x

@kernel
def both(x, y):
    return twice(x) * 1.0 + twice(y)

values = [3, 3.5, np.float32(1.5), np.arange(2.0)]
turn = int(sys.argv[1]) % len(values)
for value in values[turn:] + values[:turn]:
    twice(value)
print(twice(3), twice(3.5), twice(np.float32(1.5)), twice(np.arange(2.0))[1], both(2, 0.25))
"""
ANSWER = "6 7.0 3.0 2.0 4.5"


def ask(folder, turn=0):
    # numba caches only functions that are defined in files.
    question = folder / "question.py"
    if not question.exists():
        question.write_text(QUESTION)
    return subprocess.Popen(
        [sys.executable, "question.py", str(turn)],
        cwd=folder, env=os.environ | {"ABRADEM_CACHE_DIR": str(folder / "cache")},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def answers(processes):
    said = [process.communicate(timeout=300) for process in processes]
    return {out.strip() or err for out, err in said}


def files(folder):
    return [path for path in (folder / "cache").rglob("*.nb*") if ".tmp." not in path.name]


def test_many_processes_may_fill_a_fresh_cache_at_once(tmp_path):
    assert answers([ask(tmp_path, turn) for turn in range(PROCESSES)]) == {ANSWER}
    kept = {path: path.stat().st_mtime_ns for path in files(tmp_path)}
    # The index names the code of all signatures, and the right one: nothing is compiled again.
    assert answers([ask(tmp_path, 2)]) == {ANSWER}
    assert kept and kept == {path: path.stat().st_mtime_ns for path in files(tmp_path)}


def test_damaged_files_of_the_cache_cost_a_compilation_only(tmp_path):
    """Files as after a power failure."""
    assert answers([ask(tmp_path)]) == {ANSWER}
    for content, suffix in ((b"", ".nbc"), (b"\x80\x04damaged", ".nbi")):
        for path in files(tmp_path):
            if path.suffix == suffix:
                path.write_bytes(content)
        assert answers([ask(tmp_path)]) == {ANSWER}
        assert all(path.read_bytes() != content for path in files(tmp_path))


def test_a_folder_in_a_temporary_place_is_ones_own(tmp_path, monkeypatch):
    """Kernels are read as code: a folder that others can write is not used."""
    monkeypatch.setattr(cache.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path))
    own = cache._private_folder()
    assert own.parent == tmp_path and own.stat().st_mode & 0o777 == 0o700
    assert cache._private_folder() == own
    own.chmod(0o777)
    other = cache._private_folder()
    assert other != own and other.stat().st_mode & 0o777 == 0o700
    own.rmdir()
    own.symlink_to(other)
    assert cache._private_folder() not in (own, other)


def test_a_cache_that_cannot_be_written_is_somewhere_else(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.ENVIRONMENT_VARIABLE, str(tmp_path / "file"))
    folder = cache.cache_folder.__wrapped__()
    assert not folder.is_relative_to(tmp_path / "file")
    assert folder.parent.stat().st_uid == os.getuid()
    assert isinstance(folder, Path)
