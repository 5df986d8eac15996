"""The house: who may import whom, and one name for one thing.

The floors are those of docs/architecture.md. The import graph is the one that the product itself
has for the hashes of its code (`abradem.running.code_hash`), so that no second reading of the
imports, such as that of import-linter, can differ from it; it counts imports inside functions and
leaves out those for type checkers.
"""

import ast
import json
import re
import sys
from collections import defaultdict
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import jsonschema
import pytest
import yaml

from abradem.running.code_hash import imported_modules, source_file

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src/abradem"
SCRIPTS = ROOT / "workflow/scripts"
RULES = ROOT / "workflow/rules"

FLOORS = {
    "cli": 10,
    "running": 9, "report": 9, "publish": 9, "cases": 9,
    "figures": 8,
    "verification": 7, "learning": 7, "calibration": 7,
    "surrogate": 6,
    "dataset": 5,
    "wear": 4,
    "simulation": 3, "sampling": 3,
    "geometry": 2,
    "dem": 1,
    "config": 0, "store": 0, "words": 0, "quantities": 0, "units": 0, "elastic": 0,
}  # fmt: skip
"""Floor of every package and of every module at the root."""

GROUND = {
    "config": {"quantities", "units", "words", "store", "elastic"},
    "store": {"quantities", "words"},
    "words": {"quantities"},
    "units": {"quantities"},
    "quantities": set(),
    "elastic": set(),
    "dem": {"elastic"},
}
"""All that the lowest packages may import from others."""

READERS_OF_CONFIG = {"cli", "running", "config"}
"""Packages that know the configuration; all others get plain values."""

ONE_PROTOCOL = {
    "advance": "both steppings, and the samples that drive them, move a state on",
    "checks": "parts of the verification study, whose checks need other tables, judge them",
    "draw": "modules of figures: the figure of a rule",
    "main": "commands",
    "simulate": "the engine runs a case; what users call adds the wear rates to its result",
    "study": "parts of the verification study: their tables",
    "train": "models of the paper: the outputs of a rule",
}
"""Public functions that may have one name in several modules, and what it promises."""

SAME_FILE_NAMES = {
    "checks.py": "of parameter sets (sampling) and of the engine (verification)",
    "model.py": "what goes into a simulation (dem) and what predicts (surrogate)",
    "rows.py": "the neighbours of a particle (dem) and the rows of a table (learning)",
    "tables.py": "tables as files (store) and as the report shows them (report)",
}
"""File names of several modules, beside figures of what a stage made."""

PYTHON = sorted(SOURCE.rglob("*.py"))
CALLERS = sorted([*SCRIPTS.rglob("*.py"), *(ROOT / "benchmarks").glob("*.py")])


def relative(path):
    return path.relative_to(ROOT).as_posix()


def package_of(path):
    """First name below ``abradem`` of a source file."""
    return path.relative_to(SOURCE).with_suffix("").parts[0]


@cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def packages_imported(path):
    """First names below ``abradem`` that a file imports; that of the package itself is light."""
    return {module.split(".")[1] for module in imported_modules(path) if "." in module}


def public_names(path):
    """Public functions and classes of a module."""
    return [
        node.name
        for node in tree_of(path).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
    ]


def test_every_package_has_a_floor_and_few_modules_are_loose():
    found = {package_of(path) for path in PYTHON} - {"__init__"}
    assert found == set(FLOORS)
    loose = {path.stem for path in SOURCE.glob("*.py")}
    assert loose == {"__init__", "quantities", "units", "elastic"}


@pytest.mark.parametrize("package", FLOORS)
def test_imports_go_down(package):
    wrong = [
        f"{relative(path)} imports {other} (floor {FLOORS[other]})"
        for path in PYTHON
        if package_of(path) == package
        for other in sorted(packages_imported(path) - {package})
        if not (
            FLOORS[other] < FLOORS[package] if package not in GROUND else other in GROUND[package]
        )
    ]
    assert wrong == []


def test_shared_modules_of_learning_do_not_import_its_two_parts():
    """Nor does one part import the other."""
    wrong = []
    for path in sorted((SOURCE / "learning").rglob("*.py")):
        part = path.relative_to(SOURCE).parts[1]
        parts = {"baselines", "physical"} - {part}
        wrong += [
            f"{relative(path)} imports {module}"
            for module in imported_modules(path)
            if module.split(".")[1:2] == ["learning"] and parts.intersection(module.split(".")[2:3])
        ]
    assert wrong == []


def test_the_engine_needs_numpy_and_numba_alone():
    found = set()
    for path in (SOURCE / "dem").glob("*.py"):
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.Import):
                found |= {name.name.split(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{relative(path)}: a relative import"
                found.add(node.module.split(".")[0])
    assert found - sys.stdlib_module_names == {"numpy", "numba", "abradem"}


def test_only_the_entrances_know_the_configuration():
    """The command line, what surrounds a run, and the rules; no script of the workflow."""
    readers = [path for path in PYTHON if package_of(path) not in READERS_OF_CONFIG]
    wrong = [
        relative(path)
        for path in [*readers, *SCRIPTS.rglob("*.py")]
        if "config" in packages_imported(path)
    ]
    assert wrong == []


def modules_bound(path):
    """Names that a file binds to modules of the package."""
    bound = set()
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("abradem"):
            for name in node.names:
                try:
                    source_file(f"{node.module}.{name.name}")
                except ValueError:
                    continue
                bound.add(name.asname or name.name)
        elif isinstance(node, ast.Import):
            bound |= {
                name.asname or name.name for name in node.names if name.name.startswith("abradem")
            }
    return bound


def test_no_module_uses_the_private_names_of_another():
    """Scripts and benchmarks neither; tests may."""
    private = re.compile("_(?!_)")
    wrong = []
    for path in [*PYTHON, *CALLERS]:
        bound = modules_bound(path)
        for node in ast.walk(tree_of(path)):
            found = []
            if isinstance(node, ast.ImportFrom) and node.module != "__future__":
                names = [*node.module.split("."), *(name.name for name in node.names)]
                found = [f"{node.module}: {name}" for name in names if private.match(name)]
            elif isinstance(node, ast.Attribute) and private.match(node.attr):
                owner = ast.unparse(node.value)
                found = [f"{owner}.{node.attr}"] if owner in bound else []
            wrong += [f"{relative(path)}: {name}" for name in found]
    assert wrong == []


@pytest.mark.parametrize("path", sorted(SOURCE.rglob("__init__.py")), ids=relative)
def test_packages_hold_names_alone(path):
    """Imports and lists of names: to `code_hash`, the import of a name is that of its package."""
    docstring, *rest = tree_of(path).body
    assert isinstance(docstring, ast.Expr) and isinstance(docstring.value.value, str)
    allowed = {"__all__", "_LAZY"} | ({"__version__"} if path.parent == SOURCE else set())
    wrong = []
    for node in rest:
        if isinstance(node, ast.Import | ast.ImportFrom):
            continue
        if isinstance(node, ast.FunctionDef) and node.name in ("__getattr__", "__dir__"):
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            assert all(isinstance(inner, ast.ImportFrom) for inner in node.body)
            continue
        if isinstance(node, ast.Assign) and {ast.unparse(name) for name in node.targets} <= allowed:
            continue
        wrong.append(f"line {node.lineno}: {ast.unparse(node).splitlines()[0]}")
    assert wrong == []


@pytest.mark.parametrize("rules", sorted(RULES.glob("*.smk")), ids=lambda path: path.stem)
def test_a_stage_has_one_name(rules):
    """Its rules, its scripts, its package and its tests."""
    if rules.stem == "common":
        return
    # A table from elsewhere takes the place of the data set's.
    stage = {"external": "dataset", "scenes": "report"}.get(rules.stem, rules.stem)
    parents = {"baselines": "learning", "physical": "learning"}
    folder = Path(parents.get(stage, ""), stage)
    assert (SCRIPTS / stage).is_dir(), f"workflow/scripts/{stage}"
    assert (SOURCE / folder / "__init__.py").is_file(), f"src/abradem/{folder}"
    assert any((ROOT / "tests" / folder).glob("test_*.py")), f"tests/{folder}"


def test_no_folder_of_scripts_is_without_rules():
    folders = {path.parent.name for path in SCRIPTS.rglob("*.py")}
    assert folders <= {path.stem for path in RULES.glob("*.smk")}


@pytest.mark.parametrize("script", sorted(SCRIPTS.rglob("*.py")), ids=lambda path: path.stem)
def test_no_script_hides_a_library(script):
    """Python looks for modules in the folder of the script first."""
    assert script.stem not in sys.stdlib_module_names
    assert script.stem not in packages_distributions()


REFERENCE = re.compile(r"`([\w./-]+\.py):([A-Za-z_][\w.]*)`")


def top_level_names(path):
    """Names that stand at the top of a module, and methods as ``Class.method``."""
    names = set()
    for node in tree_of(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {
                f"{node.name}.{inner.name}"
                for inner in node.body
                if isinstance(inner, ast.FunctionDef)
            }
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {name.id for name in targets if isinstance(name, ast.Name)}
    return names


DOCUMENTS = sorted([*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")])


@pytest.mark.parametrize("document", DOCUMENTS, ids=relative)
def test_code_that_documents_name_exists(document):
    """``path/file.py:name``, relative to src/abradem or to the root of the repository."""
    named = REFERENCE.findall(document.read_text(encoding="utf-8"))
    if document.name == "method.md":
        assert named, "the method names no function"
    wrong = []
    for file, name in dict.fromkeys(named):
        path = next((base / file for base in (SOURCE, ROOT) if (base / file).is_file()), None)
        if path is None or name not in top_level_names(path):
            wrong.append(f"{file}:{name}")
    assert wrong == []


def test_no_two_public_functions_or_classes_have_one_name():
    places = defaultdict(list)
    for path in PYTHON:
        for name in public_names(path):
            places[name].append(relative(path))
    twice = {name: paths for name, paths in places.items() if len(paths) > 1}
    assert {name: paths for name, paths in twice.items() if name not in ONE_PROTOCOL} == {}
    assert set(ONE_PROTOCOL) <= set(twice), "a name of the list is no longer in two modules"


def test_no_two_modules_have_one_name():
    """A figure may have the name of the module whose tables it shows."""
    places = defaultdict(list)
    for path in PYTHON:
        if path.stem not in ("__init__", "__main__"):
            places[path.name].append(path.relative_to(SOURCE).as_posix())
    twice = {
        name: paths
        for name, paths in places.items()
        if len([path for path in paths if path != f"figures/{name}"]) > 1
    }
    assert set(twice) == set(SAME_FILE_NAMES)


def test_files_that_name_the_schema_of_the_configuration_fit_it():
    """Editors complete and check their keys by it; the first line names it."""
    pattern = re.compile(r"# yaml-language-server: \$schema=(\S+)\n")
    named = {
        path: found[1]
        for path in [ROOT / "config.yaml", *(ROOT / "studies").glob("*.yaml")]
        if (found := pattern.match(path.read_text(encoding="utf-8")))
    }
    assert ROOT / "config.yaml" in named
    for path, schema in named.items():
        assert (path.parent / schema).resolve() == ROOT / "workflow/schemas/config.schema.json"
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
        jsonschema.validate(values, json.loads((path.parent / schema).read_text(encoding="utf-8")))
