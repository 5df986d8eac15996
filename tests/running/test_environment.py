"""The command, the engine and figures in environments that were meant for other programs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from abradem.running.environment import FORCED, environment_problems, force_environment

ROOT = Path(__file__).parents[2]

FIGURE = """
import sys
from abradem.figures import style
with style.style():
    figure = style.new_figure(2.0, 1.0)
    figure.add_subplot().plot([1, 2])
    style.save(figure, sys.argv[1], ["png"])
print("drawn")
"""
COMPILED = """
import abradem.dem.vectors
from abradem.dem.cache import kernel
@kernel
def twice(x):
    return 2.0 * x
print(twice(1.5), twice.signatures)
"""
BEFORE = "import numba\n"


def python(code, *arguments, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], text=True, capture_output=True,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src"), **environment}, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


def command(*arguments, **environment):
    return python(
        "import sys; from abradem.cli.main import main; sys.exit(main())", *arguments, **environment
    )


@pytest.mark.parametrize(
    "value",
    ["PYTHONOPTIMIZE=1", "PYTHONOPTIMIZE=2", "PYTHONWARNINGS=error", "PYTHONIOENCODING=ascii",
     "LC_ALL=C", "NUMBA_NUM_THREADS=0", "NUMBA_DISABLE_JIT=1", "MPLBACKEND=garbage"],
)  # fmt: skip
def test_the_command_explains_itself_in_any_environment(value):
    name, _, text = value.partition("=")
    usual = command("--help")
    assert usual[0] == 0 and "Wear data sets, models and figures" in usual[1]
    assert command("--help", **{name: text}) == usual


@pytest.mark.parametrize("encoding", ["ascii", "ascii:strict", "ascii:surrogateescape"])
@pytest.mark.parametrize("name", ["", "predict", "simulate", "config", "doctor"])
def test_help_is_printed_in_any_encoding(encoding, name):
    given = [*filter(None, [name]), "--help"]
    for utf8 in ("0", "1"):
        status, said = command(*given, PYTHONIOENCODING=encoding, PYTHONUTF8=utf8)
        assert status == 0 and said.startswith("usage: abradem") and "Traceback" not in said
    status, said = command("predict", "--ünknown", PYTHONIOENCODING=encoding)
    assert status == 2 and len(said.splitlines()) == 1


def test_characters_that_a_terminal_lacks_are_escaped(tmp_path):
    (tmp_path / "config.yaml").write_text("study: a\npublish: {titlé: 水}\n", encoding="utf-8")
    strict = {"PYTHONIOENCODING": "ascii:strict", "PYTHONUTF8": "0"}
    status, said = command("config", "--check", tmp_path / "config.yaml", **strict)
    assert status == 2 and "did you mean title?" in said and "Traceback" not in said


@pytest.mark.parametrize(
    "value", ["NUMBA_DISABLE_JIT=1", "NUMBA_NUM_THREADS=0", "NUMBA_CACHE_DIR=/proc/none"]
)
def test_kernels_are_compiled_whatever_numba_would_be_told(value, tmp_path):
    name, _, text = value.partition("=")
    # numba caches functions of files alone.
    (tmp_path / "compiled.py").write_text(COMPILED)
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import compiled"
    status, said = python(code, **{name: text, "ABRADEM_CACHE_DIR": str(tmp_path)})
    assert status == 0, said
    assert said.strip() == "3.0 [(float64,)]"


def test_numba_that_was_imported_without_compilation_is_named():
    status, said = python(BEFORE + COMPILED, NUMBA_DISABLE_JIT="1")
    assert status != 0
    assert said.splitlines()[-1].startswith("RuntimeError: NUMBA_DISABLE_JIT was set when numba")


@pytest.mark.parametrize("folder", ["HOME", "XDG_CACHE_HOME", "ABRADEM_CACHE_DIR"])
def test_a_folder_for_kernels_is_found_where_the_usual_one_cannot_be_written(folder, tmp_path):
    code = "from abradem.dem.cache import cache_folder; print(cache_folder())"
    environment = {"TMPDIR": str(tmp_path), folder: "/proc/none"}
    status, said = python(code, **{"XDG_CACHE_HOME": "", "ABRADEM_CACHE_DIR": "", **environment})
    assert status == 0 and said.startswith(str(tmp_path)), said


def test_a_user_without_a_home_has_a_folder_for_kernels(tmp_path, monkeypatch):
    code = (
        "import pathlib\n"
        "def no_home():\n    raise RuntimeError('Could not determine home directory.')\n"
        "pathlib.Path.home = staticmethod(no_home)\n"
        "from abradem.dem.cache import cache_folder; print(cache_folder())"
    )
    given = {"XDG_CACHE_HOME": "", "ABRADEM_CACHE_DIR": "", "TMPDIR": str(tmp_path)}
    status, said = python(code, **given)
    assert status == 0 and said.startswith(str(tmp_path)), said


@pytest.mark.parametrize("backend", ["module://no_such_module.backend", "agg", "module://json"])
def test_figures_are_drawn_with_any_backend_of_a_notebook(backend, tmp_path):
    status, said = python(FIGURE, tmp_path / "figure", MPLBACKEND=backend)
    assert status == 0 and said.strip() == "drawn", said


def test_the_backend_of_the_user_stays_where_it_exists():
    code = "import abradem.figures.style, matplotlib; print(matplotlib.get_backend())"
    assert python(code, MPLBACKEND="svg")[1].strip() == "svg"


def test_processes_that_are_started_get_the_forced_values(monkeypatch):
    for name in FORCED:
        monkeypatch.setenv(name, "garbage")
    force_environment()
    for name, value in FORCED.items():
        assert os.environ.get(name) == value


@pytest.mark.parametrize(
    ("path", "fits"),
    [
        ("/usr/bin/python3", True), ("/home/müller/.venv/bin/python", True),
        ("/a/b+c@d~e/python", True), ("/my files/python", False), ("/a/$b/python", False),
        ("/a/it's/python", False), ("/a/(b)/python", False), ("/a\tb/python", False),
    ],
)  # fmt: skip
def test_paths_of_python_that_a_shell_would_divide_are_named(path, fits, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = environment_problems(Path("/clone"), path)
    assert found == [] if fits else [line for line in found if line.startswith(f"{path}: ")]
    assert len(found) == (not fits)
    assert all(len(line.splitlines()) == 1 for line in found)
