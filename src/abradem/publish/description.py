"""Texts and files that the data card and the descriptors share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

import pandas as pd

from abradem.words.escaping import for_bibtex, names_for_bibtex

LICENCE = "CC-BY-4.0"
LICENCE_NAME = "Creative Commons Attribution 4.0 International"
LICENCE_URL = "https://creativecommons.org/licenses/by/4.0/"

PARTITIONED = {
    "dataset": "The data set in one part per block",
    "series": "Worn volume (Archard constant 1 1/Pa) and particles present over time, by case",
    "maps": "Wear of each facet within the averaging window, for an Archard constant of 1 1/Pa",
    "runs": "Outcome of each simulation: status, times, feed, standard error",
}
"""Folders with one table in parts, by block."""

_WORDS = {
    "README.md": "Data card: origin of the data, ranges, units, known limits",
    "croissant.json": "Croissant descriptor of the tables",
    "ro-crate-metadata.json": "RO-Crate descriptor of the run",
    "dataset.parquet": "The data set, one row per case: quantities and wear depth rates",
    "cases.parquet": "Parameter sets of all cases, including those that gave no rate",
    "failures.parquet": "Cases that gave no wear rate, with reasons",
    "config.yaml": "Configuration of the run, with defaults",
    "versions.json": "Versions of all packages, commit, seed, hashes of the code of each step",
    "summary.json": "Headline numbers",
}
_FOLDER_WORDS = {
    "figures": "Figure",
    "tables": "Table",
    "models": "Physics-informed model",
    "learning": "Model, its scores or predictions",
}
_MEDIA_TYPES = {
    ".parquet": "application/x-parquet",
    ".json": "application/json",
    ".yaml": "application/yaml",
    ".md": "text/markdown",
    ".csv": "text/csv",
    ".html": "text/html",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".safetensors": "application/octet-stream",
}


@dataclass(frozen=True)
class File:
    """A file of the published folder.

    Parameters
    ----------
    name : str
        Path within the folder, with slashes.
    size : int
        Size in bytes.
    sha256 : str
        Hexadecimal.
    columns : tuple
        Name, type, unit and meaning of each column of a Parquet table; empty for other files.
    """

    name: str
    size: int
    sha256: str
    columns: tuple[tuple[str, str, str, str], ...] = ()

    @property
    def media_type(self) -> str:
        """MIME type."""
        return _MEDIA_TYPES[PurePosixPath(self.name).suffix]

    @property
    def folder(self) -> str:
        """First folder of the path; empty for files at the top."""
        return self.name.partition("/")[0] if "/" in self.name else ""

    @property
    def words(self) -> str:
        """Description of the content."""
        if self.folder in PARTITIONED:
            return PARTITIONED[self.folder]
        return _WORDS.get(self.name) or f"{_FOLDER_WORDS[self.folder]}: {self.stem}"

    @property
    def stem(self) -> str:
        """Name without folders and suffix, with spaces instead of underscores."""
        return PurePosixPath(self.name).stem.replace("_", " ")


@dataclass(frozen=True)
class Description:
    """The content of the data card and the descriptors.

    Parameters
    ----------
    study, title, version, date : str
        ``date`` as YYYY-MM-DD.
    creators : tuple of str
    url : str or None
        Address of the published data set.
    config, setup, summary, noise, versions : mapping
        The configuration, plain values of the `Setup`, and the contents of summary.json,
        learning/noise_floor.json and versions.json.
    dataset, failures : pandas.DataFrame
    cases : pandas.DataFrame
        The parameter sets of all cases, those of the failures included.
    files : tuple of File
    """

    study: str
    title: str
    creators: tuple[str, ...]
    version: str
    date: str
    url: str | None
    config: Mapping
    setup: Mapping
    dataset: pd.DataFrame
    failures: pd.DataFrame
    cases: pd.DataFrame
    summary: Mapping
    noise: Mapping
    versions: Mapping
    files: tuple[File, ...]

    def with_files(self, files: Iterable[File]) -> Description:
        """The same description with other files."""
        return replace(self, files=tuple(files))

    @property
    def abstract(self) -> str:
        """Abstract of the data set, three sentences."""
        return (
            f"Wear depth rates of an inclined plate under a jet of spheres for "
            f"{len(self.dataset)} sets of material and geometry parameters. They were simulated "
            f"with abradem {self.versions['versions']['abradem']}, using the discrete element "
            "method (Hertz-Mindlin contact) and Archard's wear law. Each rate has a standard error "
            "and quality flags."
        )

    @property
    def reference(self) -> str:
        """Creators, year, title and version of the data set as text."""
        return (
            f"{', '.join(self.creators)} ({self.date[:4]}). {self.title} (version "
            f"{self.version}) [data set]."
        )

    @property
    def citation(self) -> str:
        """Citation of the data set as text, with its address."""
        return f"{self.reference} {self.url}" if self.url else self.reference

    @property
    def bibtex(self) -> str:
        """Citation of the data set as BibTeX."""
        fields = {
            "author": names_for_bibtex(self.creators),
            "title": for_bibtex(self.title),
            "year": self.date[:4],
            "version": self.version,
            **({"url": self.url} if self.url else {}),
        }
        lines = (f"  {name} = {{{value}}}" for name, value in fields.items())
        return "\n".join([f"@misc{{abradem_{self.study},", ",\n".join(lines), "}"])
