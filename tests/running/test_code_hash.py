"""Every rule depends on all the code that its script imports, and on no other code."""

import ast
import re
from pathlib import Path

import pytest

import abradem
from abradem.figures.catalogue import FIGURES
from abradem.running.code_hash import (
    NEUTRAL,
    closure,
    files_hash,
    imported_modules,
    source_file,
    step_hash,
)

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "workflow" / "scripts"
RULES = "\n".join(path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk"))
PACKAGE = Path(abradem.__path__[0])


def reached(script, *modules):
    return closure(SCRIPTS / f"{script}.py", modules)


def test_every_script_is_hashed_by_its_rule_and_every_rule_has_its_script():
    scripts = {
        path.relative_to(SCRIPTS).with_suffix("").as_posix() for path in SCRIPTS.rglob("*.py")
    }
    used = set(re.findall(r'"\.\./scripts/([\w/]+)\.py"', RULES))
    assert used == scripts
    for rule in re.split(r"^ *rule (?=\w+:)", RULES, flags=re.MULTILINE)[1:]:
        script = re.search(r'"\.\./scripts/([\w/]+)\.py"', rule)
        if script is None:
            continue
        hashed = re.search(r'code_of\(\s*"([\w/]+)"', rule)
        given = {"drawn_as": "figures/figure", "module_of": "baselines/baseline"}
        helper = re.search(r"\*\*(drawn_as|module_of|part)\(", rule)
        name = hashed[1] if hashed else given.get(helper[1], "verification/part")
        assert name == script[1], rule.splitlines()[0]


def test_simulations_depend_on_every_file_of_the_engine_but_the_single_impact():
    files = {source_file(module) for module in reached("simulation/simulate")}
    assert files >= set((PACKAGE / "dem").rglob("*.py"))


def test_simulations_do_not_depend_on_what_comes_after_them():
    floors = {module.split(".")[1] for module in reached("simulation/simulate")}
    assert floors == {"simulation", "geometry", "dem", "quantities", "elastic"}


@pytest.mark.parametrize(
    "script",
    ["simulation/simulate", "wear/wear_rates", "dataset/dataset", "dataset/failures",
     "baselines/ga_ann", "physical/physical", "physical/intervals", "physical/surrogate",
     "physical/sensitivity", "physical/reach", "physical/noise_floor", "learning/scores",
     "calibration/setups", "calibration/trial", "calibration/scores", "calibration/best_trial"],
)  # fmt: skip
def test_no_simulation_and_no_training_depends_on_words_or_figures(script):
    floors = {module.split(".")[1] for module in reached(script)}
    assert not floors & {"words", "figures", "report", "config", "running", "cli", "publish"}


@pytest.mark.parametrize("model", ["linear", "penalised", "pca", "selection", "trees"])
def test_no_baseline_depends_on_words_or_figures_or_another_rules_model(model):
    modules = reached("baselines/baseline", f"abradem.learning.baselines.{model}")
    assert not {module.split(".")[1] for module in modules} & {"words", "figures", "report"}
    assert f"abradem.learning.baselines.{model}" in modules
    assert "abradem.learning.baselines.trees" in modules or model != "trees"
    assert "abradem.learning.baselines.ga_ann" not in modules


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_depends_on_its_own_module_style_and_words(name):
    entry = FIGURES[name]
    modules = reached("figures/figure", entry.module)
    assert {entry.module, "abradem.figures.style", "abradem.words.labels"} <= modules
    drawn = {one for one in modules if one.startswith("abradem.figures.")}
    shared = {
            "style", "cases_shown", "render", "maps", "score_axis", "wear_colours",
            # The set-up of a geometry.
            "render_surface", "setup_geometry",
        }  # fmt: skip
    assert {one.rpartition(".")[2] for one in drawn} <= {*shared, entry.module.rpartition(".")[2]}


def test_nothing_depends_on_the_guess_of_computing_times():
    for path in SCRIPTS.rglob("*.py"):
        assert "abradem.sampling.cost" not in closure(path)


def test_neutral_modules_exist_and_are_in_no_closure():
    for module in NEUTRAL:
        assert source_file(module).is_file() or module == "abradem"
    for path in SCRIPTS.rglob("*.py"):
        for found in closure(path):
            assert found not in NEUTRAL and not found.startswith("abradem.store")


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package that replaces abradem, and a script that uses a part of it."""
    files = {
        "abradem/__init__.py": "",
        "abradem/one.py": "from abradem.inner.two import y\n",
        "abradem/unused.py": "x = 1\n",
        "abradem/typed.py": "x = 1\n",
        "abradem/late.py": "x = 1\n",
        "abradem/named.py": "x = 1\n",
        "abradem/inner/__init__.py": "from abradem.inner.three import z\n",
        "abradem/inner/two.py": "y = 2\n",
        "abradem/inner/three.py": "z = 3\n",
        "abradem/store/__init__.py": "",
        "abradem/store/files.py": "import abradem.unused\n",
        "script.py": (
            "from typing import TYPE_CHECKING\n"
            "import abradem.one\n"
            "from abradem.store.files import anything\n"
            "if TYPE_CHECKING:\n    from abradem.typed import x\n"
            "def f():\n    from abradem import late\n"
        ),
    }
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(abradem, "__path__", [str(tmp_path / "abradem")])
    return tmp_path


def test_a_closure_follows_imports_within_functions_and_not_those_for_type_checkers(package):
    assert closure(package / "script.py") == {"abradem.one", "abradem.inner.two", "abradem.late"}


def test_a_closure_holds_the_modules_that_a_script_is_given(package):
    assert "abradem.named" in closure(package / "script.py", ["abradem.named"])


def test_a_name_of_a_package_reaches_what_the_package_imports(package):
    (package / "script.py").write_text("from abradem.inner import z\n")
    assert closure(package / "script.py") == {"abradem.inner", "abradem.inner.three"}


@pytest.mark.parametrize("file", ["script.py", "abradem/one.py", "abradem/inner/two.py",
                                  "abradem/late.py"])  # fmt: skip
def test_an_edit_changes_the_hash_and_its_revert_restores_it(package, file):
    script = package / "script.py"
    before, text = step_hash(script), (package / file).read_text()
    (package / file).write_text(text + "# edited\n")
    assert step_hash(script) != before
    (package / file).write_text(text)
    assert step_hash(script) == before


@pytest.mark.parametrize("file", ["abradem/unused.py", "abradem/typed.py", "abradem/__init__.py",
                                  "abradem/inner/three.py", "abradem/store/files.py"])  # fmt: skip
def test_an_edit_elsewhere_leaves_the_hash(package, file):
    before = step_hash(package / "script.py")
    (package / file).write_text("# edited\n")
    assert step_hash(package / "script.py") == before


def test_a_touch_leaves_the_hash(package):
    before = step_hash(package / "script.py")
    (package / "abradem" / "one.py").touch()
    assert step_hash(package / "script.py") == before


def test_the_hash_does_not_depend_on_the_folder(package, monkeypatch):
    before = step_hash(package / "script.py")
    moved = package.rename(package.with_name("moved"))
    monkeypatch.setattr(abradem, "__path__", [str(moved / "abradem")])
    assert step_hash(moved / "script.py") == before


def test_an_unknown_module_is_an_error(package):
    with pytest.raises(ValueError, match=r"abradem\.four: no such module"):
        closure(package / "script.py", ["abradem.four"])


def imports_of_tree(path):
    """Reference for `imported_modules`: from the syntax tree, without imports for type checkers."""
    found = []

    class Finder(ast.NodeVisitor):
        def visit_If(self, node):
            if "TYPE_CHECKING" not in ast.dump(node.test):
                self.generic_visit(node)

        def visit_Import(self, node):
            found.extend(one.name for one in node.names)

        def visit_ImportFrom(self, node):
            assert node.level == 0, f"{path}: relative import"
            for one in node.names:
                inner = f"{node.module}.{one.name}"
                folder = PACKAGE.joinpath(*inner.split(".")[1:])
                is_module = folder.is_dir() or folder.with_suffix(".py").is_file()
                found.append(inner if is_module else node.module)

    Finder().visit(ast.parse(path.read_text()))
    return list(dict.fromkeys(one for one in found if one.split(".")[0] == "abradem"))


@pytest.mark.parametrize(
    "path", [*PACKAGE.rglob("*.py"), *SCRIPTS.rglob("*.py")], ids=lambda path: path.stem
)
def test_imports_found_in_the_text_are_those_of_the_syntax_tree(path):
    assert imported_modules(path) == imports_of_tree(path)


def test_imports_are_in_the_order_of_the_text_and_once(package):
    assert imported_modules(package / "script.py") == [
        "abradem.one", "abradem.store.files", "abradem.late",
    ]  # fmt: skip


def test_a_hash_of_files_follows_their_names_and_content(tmp_path):
    (tmp_path / "a.csv").write_text("1\n")
    before = files_hash(tmp_path / "a.csv")
    (tmp_path / "a.csv").rename(tmp_path / "b.csv")
    assert files_hash(tmp_path / "b.csv") != before
