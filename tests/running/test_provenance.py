"""Every step of the workflow depends on the code it uses: on all of it, and on no other."""

import ast
import json
import subprocess
from pathlib import Path

import pytest

import abradem
from abradem.running import provenance
from abradem.running.provenance import HARMLESS, NEUTRAL, STEPS, code_hash, source_files, step_hash

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "workflow" / "scripts"


def is_module(name):
    folder = Path(abradem.__path__[0]).joinpath(*name.split(".")[1:])
    return folder.is_dir() or folder.with_suffix(".py").is_file()


def own_source(module):
    """The file of a module, of a package its ``__init__.py``."""
    path = Path(abradem.__path__[0]).joinpath(*module.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def imported(path):
    """(module, name) of all imports from the package, those inside functions included."""

    class Finder(ast.NodeVisitor):
        found = ()

        def visit_If(self, node):
            if "TYPE_CHECKING" not in ast.dump(node.test):
                self.generic_visit(node)

        def visit_Import(self, node):
            self.found += tuple((alias.name, None) for alias in node.names)

        def visit_ImportFrom(self, node):
            assert node.level == 0, f"{path}: relative import"
            self.found += tuple((node.module, alias.name) for alias in node.names)

    finder = Finder()
    finder.visit(ast.parse(path.read_text(encoding="utf-8")))
    return [pair for pair in finder.found if pair[0].split(".")[0] == "abradem"]


def dependencies(path):
    """Modules whose content can change what a script writes, found from the imports."""
    found, waiting = set(), [path]
    while waiting:
        for module, name in imported(waiting.pop()):
            if name and is_module(f"{module}.{name}"):
                module, name = f"{module}.{name}", None
            if module in NEUTRAL or module in found or name in HARMLESS.get(module, ()):
                continue
            found.add(module)
            waiting.append(own_source(module))
    return found


def covers(listed, module):
    return module == listed or module.startswith(f"{listed}.")


@pytest.mark.parametrize("step", STEPS)
def test_a_step_lists_every_module_its_script_reaches(step):
    reached = dependencies(SCRIPTS / f"{step}.py")
    missing = {m for m in reached if not any(covers(listed, m) for listed in STEPS[step])}
    assert not missing


@pytest.mark.parametrize("step", STEPS)
def test_a_step_lists_no_module_that_its_script_does_not_reach(step):
    reached = dependencies(SCRIPTS / f"{step}.py")
    assert [m for m in STEPS[step] if not any(covers(m, one) for one in reached)] == []


def test_every_script_is_a_step():
    assert {path.stem for path in SCRIPTS.glob("*.py")} == set(STEPS)


def test_simulations_do_not_depend_on_what_comes_after_them():
    files = {path.stem for module in STEPS["simulate"] for path in source_files(module)}
    assert not files & {"wear_rate", "dataset", "features", "linear", "config", "progress"}


def test_simulations_depend_on_every_file_of_the_engine():
    files = {path for module in STEPS["simulate"] for path in source_files(module)}
    assert files >= set((Path(abradem.__path__[0]) / "dem").rglob("*.py"))


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of two modules in the place of abradem."""
    folder = tmp_path / "abradem"
    (folder / "inner").mkdir(parents=True)
    (folder / "one.py").write_text("x = 1\n")
    (folder / "inner" / "two.py").write_text("y = 2\n")
    monkeypatch.setattr(abradem, "__path__", [str(folder)])
    return folder


def test_an_edit_changes_the_hash_and_its_revert_restores_it(package):
    before = code_hash(["abradem.one"])
    (package / "one.py").write_text("x = 3\n")
    assert code_hash(["abradem.one"]) != before
    (package / "one.py").write_text("x = 1\n")
    assert code_hash(["abradem.one"]) == before


def test_a_touch_leaves_the_hash(package):
    before = code_hash(["abradem"])
    (package / "one.py").touch()
    assert code_hash(["abradem"]) == before


def test_a_hash_sees_only_the_modules_named(package):
    before = code_hash(["abradem.one"])
    (package / "inner" / "two.py").write_text("y = 4\n")
    assert code_hash(["abradem.one"]) == before


def test_a_package_means_all_below_it(package):
    before = code_hash(["abradem.inner"])
    (package / "inner" / "new.py").write_text("")
    assert code_hash(["abradem.inner"]) != before


def test_a_renamed_module_changes_the_hash(package):
    before = code_hash(["abradem.inner"])
    (package / "inner" / "two.py").rename(package / "inner" / "three.py")
    assert code_hash(["abradem.inner"]) != before


def test_an_unknown_module_is_an_error(package):
    with pytest.raises(ValueError, match=r"abradem\.four: no such module"):
        code_hash(["abradem.four"])


def test_a_step_depends_on_its_script(tmp_path):
    (tmp_path / "table.py").write_text("1\n")
    before = step_hash("table", tmp_path)
    (tmp_path / "table.py").write_text("2\n")
    assert step_hash("table", tmp_path) != before


def test_provenance_is_the_same_bytes_every_time(tmp_path):
    recorded = {"seed": 1, "versions": provenance.versions()}
    for name in ("a", "b"):
        provenance.write_provenance(
            "study: x\n", recorded, tmp_path / name / "config.yaml", tmp_path / name / "v.json"
        )
    for file in ("config.yaml", "v.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    assert json.loads((tmp_path / "a" / "v.json").read_text())["versions"]["numpy"]


def test_provenance_names_commit_system_and_every_package(tmp_path):
    provenance.write_provenance("a: 1\n", {}, tmp_path / "config.yaml", tmp_path / "v.json")
    found = json.loads((tmp_path / "v.json").read_text())
    packages = found["environment"]["packages"]
    assert {"numba", "llvmlite", "numpy", "snakemake"} <= packages.keys()
    assert packages["numpy"] == provenance.versions()["numpy"]
    assert found["environment"]["machine"] and found["environment"]["system"]


def test_the_commit_is_that_of_the_repository_around_the_package(tmp_path, monkeypatch):
    package = tmp_path / "src" / "abradem"
    package.mkdir(parents=True)
    monkeypatch.setattr(provenance.abradem, "__path__", [str(package)])
    assert provenance.source() is None

    def git(*words):
        names = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
        command = ["git", "-C", str(tmp_path), *names, *words]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    git("init")
    assert provenance.source() is None  # No commit yet.
    (package / "a.py").write_text("1\n")
    git("add", "-A")
    git("commit", "-m", "first")
    assert provenance.source() == {"commit": git("rev-parse", "HEAD"), "changed": False}
    (package / "a.py").write_text("2\n")
    assert provenance.source()["changed"] is True
    monkeypatch.setenv("PATH", "")
    assert provenance.source() is None
