"""An edit of the engine takes effect although compiled kernels are cached on disk."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import abradem

QUESTION = """
from abradem.dem.factory import _is_off_the_walls
from abradem.dem.state import make_problem
from abradem.verification.scenes import Scene
problem, _ = make_problem(Scene().case(), Scene().plane())
print(_is_off_the_walls(problem, None, None, 0.0, 0.02, 0.0))
"""


def answer(folder, cache):
    environment = os.environ | {"PYTHONPATH": str(folder), "ABRADEM_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", QUESTION], env=environment, text=True, capture_output=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_an_edited_callee_in_another_file_is_really_used(tmp_path):
    package, cache = tmp_path / "abradem", tmp_path / "cache"
    shutil.copytree(Path(abradem.__file__).parent, package)
    assert answer(tmp_path, cache) == "True"
    compiled = len(list(cache.glob("kernels-*")))
    # The caller is in factory.py; the edited callee returns a smaller distance to the plate.
    source = package / "dem" / "plate.py"
    text = source.read_text()
    assert text.count("return height, (-plate.sin, plate.cos, 0.0)") == 1
    source.write_text(
        text.replace(
            "return height, (-plate.sin, plate.cos, 0.0)",
            "return height - 0.015, (-plate.sin, plate.cos, 0.0)",
        )
    )
    assert answer(tmp_path, cache) == "False"
    assert len(list(cache.glob("kernels-*"))) == compiled + 1
    source.write_text(text)
    assert answer(tmp_path, cache) == "True"


def test_another_clone_of_the_same_engine_compiles_nothing(tmp_path):
    """Neither the path of the sources nor their times matter."""
    cache, first, second = (tmp_path / name for name in ("cache", "first", "second"))
    for clone in (first, second):
        shutil.copytree(Path(abradem.__file__).parent, clone / "abradem", copy_function=shutil.copy)
    assert answer(first, cache) == "True"
    made = {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb*")}
    assert made and len({path.parent for path in made}) == 1
    assert answer(second, cache) == "True"
    assert {path: path.stat().st_mtime_ns for path in cache.rglob("*.nb*")} == made
