"""Which code made which result: content hashes for the workflow, versions for the reader.

Snakemake does not see an edit in an imported package. Every rule therefore carries, as a
parameter, a hash of the *content* of its script and of the modules that the script uses: an
edit reruns that step and what follows, a touch or a revert reruns nothing.

`STEPS` names the modules of each script. A test derives the same from the imports.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import subprocess
from collections.abc import Iterable
from pathlib import Path

import abradem

NEUTRAL = {
    "abradem": "names and the version only",
    "abradem.joblog": "says what went wrong",
    "abradem.locks": "keeps two processes from one place",
    "abradem.provenance": "records results, does not make them",
}
"""Modules whose content cannot change a result, and why; no step depends on them."""

HARMLESS = {
    "abradem.dataset": (
        "COLUMNS", "Column", "TableError", "WEAR_COLUMNS", "concatenate", "content_hash",
        "read_json", "read_table", "read_units", "replacing", "wear_column", "write_json",
        "write_table",
    ),
    "abradem.parameters": ("READINGS", "SAMPLED_NAMES", "STATISTICS"),
}  # fmt: skip
"""What a step may use of a module without depending on it: storage, which leaves values as they
are, and names, which would change the tables themselves. So a column added to the data set, or
the label of a quantity, does not repeat the simulations."""

_JOIN = ("abradem.dataset", "abradem.features", "abradem.parameters")
_RATES = ("abradem.wear_rate", "abradem.dem")
_LEARNING = (
    "abradem.learning.evaluation", "abradem.learning.modelfile", "abradem.learning.protocols",
    "abradem.learning.scores", "abradem.learning.table", "abradem.parameters",
)  # fmt: skip
_FIGURE = ("abradem.figures.style", "abradem.parameters")
_OF_MODELS = (*_FIGURE, "abradem.figures.words")
_CHECKS = ("abradem.dem", "abradem.verification.scenes", "abradem.verification.table")
_LAWS = (
    *_CHECKS, "abradem.verification.closed_forms", "abradem.verification.experiments",
    "abradem.verification.laws",
)  # fmt: skip

_SIMULATED = (*_RATES, "abradem.parameters", "abradem.sampling", "abradem.shards")
_PHYSICAL = (
    *_LEARNING, "abradem.features", "abradem.learning.ensembles",
    "abradem.learning.gaussian_process", "abradem.learning.groups", "abradem.learning.network",
    "abradem.learning.physical", "abradem.learning.power_law",
)  # fmt: skip

STEPS: dict[str, tuple[str, ...]] = {
    "sample": ("abradem.sampling", "abradem.parameters", "abradem.shards", "abradem.dem"),
    "join_cases": (),
    "simulate": ("abradem.shards", "abradem.dem"),
    "export": ("abradem.export", "abradem.shards", "abradem.dem"),
    "wear_rates": (*_RATES, "abradem.shards"),
    "failures": _JOIN,
    "dataset": _JOIN,
    "external": (
        "abradem.external", "abradem.features", "abradem.parameters", "abradem.units",
    ),
    "linear": (*_LEARNING, "abradem.learning.linear", "abradem.learning.paper"),
    "penalised": (*_LEARNING, "abradem.learning.penalised"),
    "pca": (*_LEARNING, "abradem.learning.principal"),
    "selection": (
        *_LEARNING, "abradem.learning.paper", "abradem.learning.penalised",
        "abradem.learning.principal", "abradem.learning.selection",
    ),
    "trees": (*_LEARNING, "abradem.learning.trees"),
    "ga_ann": (
        *_LEARNING, "abradem.learning.ga_ann", "abradem.learning.genetic",
        "abradem.learning.network", "abradem.learning.paper", "abradem.learning.penalised",
        "abradem.learning.principal", "abradem.learning.selection",
    ),
    "scores": (
        "abradem.learning.comparison", "abradem.learning.modelfile", "abradem.learning.paper",
        "abradem.learning.protocols", "abradem.learning.scores", "abradem.learning.table",
        "abradem.parameters",
    ),
    "physical": _PHYSICAL,
    "intervals": (*_PHYSICAL, "abradem.learning.intervals", "abradem.surrogate"),
    "surrogate": (*_PHYSICAL, "abradem.learning.distil", "abradem.surrogate"),
    "sensitivity": (*_PHYSICAL, "abradem.learning.sensitivity"),
    "reach": (
        *_PHYSICAL, "abradem.learning.intervals", "abradem.learning.reach", "abradem.surrogate",
    ),
    "replicates": (*_SIMULATED, "abradem.learning.noise_floor"),
    "noise_floor": (
        *_SIMULATED, "abradem.learning.modelfile", "abradem.learning.noise_floor",
        "abradem.learning.table",
    ),
    "speed_up": (
        "abradem.dem", "abradem.features", "abradem.learning.groups", "abradem.parameters",
        "abradem.shards", "abradem.speed_up", "abradem.surrogate",
    ),
    "findings": (*_PHYSICAL, "abradem.learning.findings"),
    "figure_models": (*_OF_MODELS, "abradem.figures.models"),
    "figure_sensitivity": (*_OF_MODELS, "abradem.figures.models"),
    "figure_reach": (*_OF_MODELS, "abradem.figures.models"),
    "figure_series": (*_FIGURE, *_RATES, "abradem.figures.series", "abradem.shards"),
    "figure_quality": (*_FIGURE, *_RATES, "abradem.figures.series"),
    "figure_coefficients": (*_FIGURE, "abradem.figures.linear"),
    "figure_predicted": (*_FIGURE, "abradem.figures.linear"),
    "figure_residuals": (*_OF_MODELS, "abradem.figures.regression"),
    "figure_penalised": (*_OF_MODELS, "abradem.figures.regression"),
    "figure_selection": (*_OF_MODELS, "abradem.figures.regression"),
    "figure_pca": (*_OF_MODELS, "abradem.figures.components"),
    "figure_trees": (*_OF_MODELS, "abradem.figures.trees"),
    "figure_ga_ann": (*_OF_MODELS, "abradem.figures.networks"),
    "figure_comparison": (*_OF_MODELS, "abradem.figures.comparison"),
    "figure_maps": (*_FIGURE, *_RATES, "abradem.figures.maps", "abradem.shards"),
    "scene": (*_RATES, "abradem.export", "abradem.scenes", "abradem.shards"),
    "angles": (*_RATES, "abradem.export", "abradem.scenes", "abradem.shards"),
    "figure_setup": (
        *_FIGURE, *_RATES, "abradem.export", "abradem.figures.render", "abradem.figures.setup",
        "abradem.scenes", "abradem.shards",
    ),
    "figure_angles": (*_FIGURE, "abradem.figures.angles"),
    "figure_gallery": (
        *_FIGURE, *_RATES, "abradem.figures.gallery", "abradem.gallery", "abradem.shards",
    ),
    "rule_graph": ("abradem.rulegraph",),
    "figure_flow": (
        *_FIGURE, "abradem.dem", "abradem.figures.flow", "abradem.rulegraph", "abradem.shards",
    ),
    "figure_architecture": (*_OF_MODELS, "abradem.figures.architecture"),
    "figure_distributions": (
        *_OF_MODELS, "abradem.figures.distributions", "abradem.learning.distributions",
    ),
    "figure_verification": (
        *_FIGURE, "abradem.figures.verdicts", "abradem.verification.margins",
        "abradem.verification.page", "abradem.verification.table",
    ),
    "figure_speed": (*_FIGURE, "abradem.figures.engine"),
    "latex": (
        *_OF_MODELS, "abradem.latex", "abradem.verification.page", "abradem.verification.table",
    ),
    "paper": ("abradem.typeset",),
    "movie": (
        *_FIGURE, *_RATES, "abradem.export", "abradem.figures.film", "abradem.figures.render",
        "abradem.figures.setup", "abradem.movie", "abradem.scenes", "abradem.shards",
    ),
    "vtk": (*_RATES, "abradem.export", "abradem.scenes", "abradem.shards", "abradem.vtk"),
    "publish": ("abradem.parameters", "abradem.publish"),
    "table": (),
    "summary": (*_RATES, *_JOIN, "abradem.summary"),
    "provenance": (),
    "verification_laws": (*_LAWS,),
    "verification_chung_ooi": (*_LAWS, "abradem.verification.chung_ooi"),
    "verification_codes": (
        *_CHECKS, "abradem.verification.closed_forms", "abradem.verification.codes",
        "abradem.verification.experiments", "abradem.verification.plain_impact",
    ),
    "verification_time_step": (
        *_LAWS, "abradem.verification.jets", "abradem.verification.time_step",
    ),
    "verification_statistics": (
        *_CHECKS, "abradem.verification.jets", "abradem.verification.statistics",
        "abradem.wear_rate",
    ),
    "verification_steady_state": (
        *_CHECKS, "abradem.verification.jets", "abradem.verification.steady_state_study",
        "abradem.wear_rate",
    ),
    "verification_conveyor": (
        *_CHECKS, "abradem.verification.conveyor", "abradem.verification.jets",
    ),
    "verification_trends": (
        *_LAWS, "abradem.verification.jets", "abradem.verification.time_step",
        "abradem.verification.trends",
    ),
    "verification_facets_and_bed": (
        *_CHECKS, "abradem.verification.facets_and_bed", "abradem.verification.jets",
    ),
    "verification_page": ("abradem.verification.page", "abradem.verification.table"),
    "verification_figure": (*_OF_MODELS, "abradem.figures.verification"),
}  # fmt: skip
"""Modules (a package means all below it) that the script ``workflow/scripts/<step>.py`` uses."""

PACKAGES = (
    "matplotlib", "numba", "numpy", "pandas", "pyarrow", "safetensors", "scikit-learn", "scipy",
    "snakemake", "torch",
)  # fmt: skip
"""Distributions whose versions are recorded."""


def source_files(module: str) -> list[Path]:
    """Source files of a module, or of all modules of a package, without importing it.

    Parameters
    ----------
    module : str
        Dotted name that begins with ``abradem``.
    """
    folder = Path(abradem.__path__[0])
    path = folder.joinpath(*module.split(".")[1:])
    if path.is_dir():
        return sorted(path.rglob("*.py"))
    if path.with_suffix(".py").is_file():
        return [path.with_suffix(".py")]
    raise ValueError(f"{module}: no such module in {folder}")


def code_hash(modules: Iterable[str], *files: Path) -> str:
    """Hash of the content of modules and of further files; independent of where they lie.

    Parameters
    ----------
    modules : iterable of str
        Dotted names; a package means all modules below it.
    files : path
        Further sources, such as the script of a rule.

    Returns
    -------
    str
        16 hexadecimal digits.
    """
    root = Path(abradem.__path__[0])
    named = {
        path.relative_to(root).as_posix(): path
        for module in modules
        for path in source_files(module)
    }
    named.update({f"file {Path(path).name}": Path(path) for path in files})
    digest = hashlib.sha256()
    for name in sorted(named):
        digest.update(name.encode() + b"\0" + hashlib.sha256(named[name].read_bytes()).digest())
    return digest.hexdigest()[:16]


def step_hash(step: str, scripts: Path) -> str:
    """Hash of all code that a step of the workflow depends on.

    Parameters
    ----------
    step : str
        Key of `STEPS`.
    scripts : path
        Folder of the workflow's scripts.
    """
    return code_hash(STEPS[step], Path(scripts) / f"{step}.py")


def versions() -> dict[str, str]:
    """Versions of Python, of this package and of those it computes with."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"abradem": abradem.__version__, "python": platform.python_version()}
    for name in PACKAGES:
        with contextlib.suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def source() -> dict | None:
    """Commit of the repository that the package lies in, and whether files of it were changed.

    None where it was installed without one, or there is no git to ask. For the reader alone: a
    commit may change what no result depends on, so nothing is rerun for it.
    """
    root = Path(abradem.__path__[0]).parents[1]
    if not (root / ".git").exists():
        return None
    try:
        commit, changed = (
            subprocess.run(
                ["git", "-C", str(root), *words], capture_output=True, text=True, check=True
            ).stdout.strip()
            for words in (["rev-parse", "HEAD"], ["status", "--porcelain"])
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return {"commit": commit, "changed": bool(changed)}


def environment() -> dict:
    """System, processor and every package that is installed beside this one."""
    from importlib.metadata import distributions

    packages = {found.name: found.version for found in distributions() if found.name}
    return {
        "system": platform.platform(),
        "machine": platform.machine(),
        "packages": dict(sorted(packages.items(), key=lambda item: item[0].lower())),
    }


def write_text(text: str, path: str | Path) -> None:
    """Write a text file, complete or not at all."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_provenance(config: str, recorded: dict, config_path: Path, versions_path: Path) -> None:
    """Write the resolved configuration and, as JSON, what else identifies a run.

    Parameters
    ----------
    config : str
        The whole configuration as YAML, defaults filled in.
    recorded : dict
        Seed, `versions`, code hashes; no time stamps, so that the same run writes the same
        bytes. `source` and `environment` are added.
    config_path, versions_path : path
        Where they go.
    """
    write_text(config, config_path)
    recorded = {**recorded, "source": source(), "environment": environment()}
    write_text(json.dumps(recorded, indent=2, sort_keys=True) + "\n", versions_path)
