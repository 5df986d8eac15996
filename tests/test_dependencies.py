"""Dependencies: few, pinned, and listed with reason and free licence."""

import re
import tomllib
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

import pytest
import yaml

import abradem
from abradem.running.provenance import versions

ROOT = Path(__file__).parents[1]
COMPATIBLE = {"MIT", "ISC", "BSD-2-Clause", "BSD-3-Clause", "Apache-2.0", "PSF-2.0", "MPL-2.0"}
WORDS = {
    "MIT": "MIT", "ISC": "ISC", "BSD-2-Clause": "BSD", "BSD-3-Clause": "BSD",
    "Apache-2.0": "Apache", "PSF-2.0": "Python Software Foundation|PSF", "MPL-2.0": "Mozilla|MPL",
}  # fmt: skip
"""How the metadata of packages name these licences."""


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
DECLARED = sorted({
    plain(re.match(r"[A-Za-z0-9._-]+", line).group())
    for lines in (PROJECT["dependencies"], *PROJECT["optional-dependencies"].values())
    for line in lines
})  # fmt: skip
PINNED = {
    plain(line.split("==")[0]): line.split("==")[1].strip()
    for line in (ROOT / "constraints.txt").read_text().splitlines()
    if "==" in line
}
LISTED = {
    plain(cells[0]): cells[1]
    for line in (ROOT / "docs/dependencies.md").read_text(encoding="utf-8").splitlines()
    if len(cells := [cell.strip() for cell in line.strip("|").split("|")]) == 3
    and cells[0] not in ("package", "---")
}


def test_the_list_is_that_of_the_project():
    assert sorted(LISTED) == DECLARED


@pytest.mark.parametrize("name", DECLARED)
def test_each_is_pinned_and_its_licence_is_compatible(name):
    assert PINNED[name] and LISTED[name] in COMPATIBLE


@pytest.mark.parametrize("name", DECLARED)
def test_the_licence_is_the_one_that_the_package_names(name):
    try:
        of = metadata(name)
    except PackageNotFoundError:
        pytest.skip("is not installed")
    named = [of.get("License-Expression"), of.get("License"), *of.get_all("Classifier", [])]
    if not any(named):
        pytest.skip("its metadata name no licence")
    assert re.search(WORDS[LISTED[name]], " ".join(filter(None, named)), re.IGNORECASE)


def test_all_that_is_installed_for_the_project_is_pinned():
    """The dependencies of the declared packages are pinned as well."""
    from importlib.metadata import requires

    seen, waiting = set(), list(DECLARED)
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        try:
            needed = requires(name) or []
        except PackageNotFoundError:
            continue
        for line in needed:
            other = plain(re.match(r"[A-Za-z0-9._-]+", line).group())
            try:
                metadata(other)
            except PackageNotFoundError:
                continue
            if "extra ==" not in line:
                waiting.append(other)
    assert seen - PINNED.keys() == set()


def test_there_is_one_version():
    """The package's, which descriptors of published data sets and `abradem --version` take."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    latest = re.search(r"^## (\d\S*?),? ", changes, re.MULTILINE)[1]
    # As it was installed; after a change of the version, `pip install --editable .` again.
    installed = metadata("abradem")["Version"]
    assert {cited, latest, installed, versions()["abradem"]} == {abradem.__version__}


def test_no_source_holds_a_version_of_its_own():
    """For example a descriptor that is not updated at the next release."""
    wrong = [
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "src").rglob("*.py")
        if path != ROOT / "src/abradem/__init__.py" and abradem.__version__ in path.read_text()
    ]
    assert wrong == []


def test_no_source_reads_what_could_run_code():
    """Models and tables contain only numbers and text; pickle files are never read."""
    forbidden = re.compile(
        r"\b(pickle|marshal|shelve|dill|joblib|cloudpickle)\b.*\b(load|import)\b|import pickle"
        r"|torch\.load|allow_pickle=True|read_pickle|yaml\.(unsafe_load|full_load|load)\("
        r"|\beval\(|\bexec\(|weights_only=False"
    )
    found = [
        f"{path.name}: {line.strip()}"
        for path in (ROOT / "src").rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if forbidden.search(line) and not line.strip().startswith("#")
    ]
    assert found == []
