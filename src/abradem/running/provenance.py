"""Provenance of a run: resolved configuration, versions, commit and environment."""

from __future__ import annotations

import contextlib
import platform
import subprocess
from pathlib import Path

import abradem
from abradem.store.files import write_json, write_text

PACKAGES = (
    "matplotlib", "numba", "numpy", "pandas", "pyarrow", "safetensors", "scikit-learn", "scipy",
    "snakemake", "torch",
)  # fmt: skip
"""Packages whose versions are recorded as the main ones."""


def versions() -> dict[str, str]:
    """Versions of Python, of this package and of the packages it computes with."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"abradem": abradem.__version__, "python": platform.python_version()}
    for name in PACKAGES:
        with contextlib.suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def source() -> dict | None:
    """Commit of the repository that contains the package, and whether files were changed.

    None if the package is not in a repository or git is not available. The commit is recorded for
    information only: it may change without any effect on the results, so nothing is rerun for it.
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
    """Operating system, processor and all installed packages."""
    from importlib.metadata import distributions

    packages = {found.name: found.version for found in distributions() if found.name}
    return {
        "system": platform.platform(),
        "machine": platform.machine(),
        "packages": dict(sorted(packages.items(), key=lambda item: item[0].lower())),
    }


def write_provenance(config: str, recorded: dict, config_path: Path, versions_path: Path) -> None:
    """Write the resolved configuration and, as JSON, everything else that identifies a run.

    Parameters
    ----------
    config : str
        The whole configuration as YAML, with defaults.
    recorded : dict
        Seed, `versions` and code hashes, without time stamps, so that the same run writes the
        same bytes. `source` and `environment` are added.
    config_path, versions_path : path
        The files written.
    """
    write_text(config, config_path)
    recorded = {**recorded, "source": source(), "environment": environment()}
    write_json(recorded, versions_path)
