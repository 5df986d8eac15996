"""The published folder: copies of results, tables partitioned by block, data card, descriptors.

The folder is built under a temporary name and renamed when it is complete. Its content does not
depend on the time at which it is built, so that the same results give the same bytes.
"""

from __future__ import annotations

import contextlib
import datetime
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import pandas as pd

from abradem.publish.card import card
from abradem.publish.crate import ABOUT, crate
from abradem.publish.croissant import croissant
from abradem.publish.description import Description, File
from abradem.store.checksums import sha256_of
from abradem.store.files import read_json, write_json, write_text
from abradem.store.tables import read_columns, read_table, write_table

DATASET = "dataset.parquet"
BATCH = re.compile(r"block-(\d+)-batch-(\d+)\.parquet")


@dataclass(frozen=True)
class Study:
    """Name and configuration of the study to be published.

    Parameters
    ----------
    name : str
    config : mapping
        The whole configuration.
    setup : mapping
        Plain values of the `Setup`.
    said : mapping
        The section ``publish`` of the configuration.
    """

    name: str
    config: Mapping
    setup: Mapping
    said: Mapping


def publish(folder: Path, results: Path, files: Iterable[Path], study: Study) -> None:
    """Build the published folder.

    Parameters
    ----------
    folder : path
        Path of the folder; an existing one is replaced when the new one is complete.
    results : path
        Results of the study.
    files : iterable of path
        Files below ``results``, copied under the same names. They must include dataset.parquet,
        failures.parquet, cases.parquet, config.yaml, versions.json, summary.json and
        learning/noise_floor.json. Tables ``<name>/block-<block>-batch-<batch>.parquet`` become
        ``<name>/block=<block>/batch-<batch>.parquet``.
    study : Study

    Raises
    ------
    RuntimeError
        If mlcroissant is installed and rejects the descriptor.
    """
    results = Path(results)
    with replacing_folder(folder) as new:
        for source in map(Path, files):
            if batch := BATCH.fullmatch(source.name):
                _add_batch(source, new, *batch.groups())
            else:
                _copy(source, new / source.relative_to(results))
        _partition(new / DATASET, new / Path(DATASET).stem)
        description = Description(
            study=study.name,
            title=study.said["title"]
            or f"Wear of an inclined plate under a jet of particles: study {study.name}",
            creators=tuple(study.said["creators"]),
            version=study.said["version"],
            date=study.said["date"] or _day(results / DATASET),
            url=study.said["url"],
            config=study.config,
            setup=study.setup,
            dataset=read_table(new / DATASET),
            failures=read_table(new / "failures.parquet"),
            cases=read_table(new / "cases.parquet"),
            summary=read_json(new / "summary.json"),
            noise=read_json(new / "learning" / "noise_floor.json"),
            versions=read_json(new / "versions.json"),
            files=tuple(listed(new)),
        )
        # The crate also lists the two other descriptors; the data are hashed only once.
        write_json(croissant(description), new / "croissant.json")
        _validate(new / "croissant.json")
        write_text(card(description), new / "README.md")
        every = [*description.files, *(_file(new / name, name) for name in ABOUT)]
        every.sort(key=lambda file: PurePosixPath(file.name))
        write_json(crate(description.with_files(every)), new / "ro-crate-metadata.json")


@contextlib.contextmanager
def replacing_folder(folder: str | Path) -> Iterator[Path]:
    """Context with an empty folder that replaces ``folder`` if the block ends without error."""
    folder = Path(folder)
    new, old = (folder.with_name(f".{folder.name}.{word}") for word in ("new", "old"))
    for left in (new, old):
        shutil.rmtree(left, ignore_errors=True)
    new.mkdir(parents=True)
    try:
        yield new
        if folder.exists():
            folder.rename(old)
        new.rename(folder)
    finally:
        for left in (new, old):
            shutil.rmtree(left, ignore_errors=True)


def listed(folder: Path) -> list[File]:
    """All files below a folder, sorted by path, with sizes, hashes and the columns of tables."""
    return [
        _file(path, path.relative_to(folder).as_posix())
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    ]


def _file(path: Path, name: str) -> File:
    columns: tuple[tuple[str, str, str, str], ...] = ()
    if path.suffix == ".parquet":
        columns = tuple(read_columns(path))
    return File(name, path.stat().st_size, sha256_of(path), columns)


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _partition(table: Path, folder: Path) -> None:
    """Write the rows of each block as a part, with Hive-style names of the folders."""
    for block, rows in read_table(table).groupby("block", sort=True):
        _write_part(rows, folder / f"block={block}" / "part-0.parquet")


def _add_batch(source: Path, folder: Path, block: str, batch: str) -> None:
    target = folder / source.parent.name / f"block={int(block)}" / f"batch-{batch}.parquet"
    if any(column.name == "block" for column in read_columns(source)):
        _write_part(read_table(source), target)
    else:
        _copy(source, target)


def _write_part(rows: pd.DataFrame, path: Path) -> None:
    # Readers take the block from the name of the folder, which would conflict with a column.
    write_table(rows.drop(columns="block").reset_index(drop=True), path)


def _validate(path: Path) -> None:
    try:
        import mlcroissant
    except ImportError:
        print(f"{path.name}: not validated, as mlcroissant is not installed")
        return
    try:
        mlcroissant.Dataset(jsonld=path)
    except mlcroissant.ValidationError as error:
        raise RuntimeError(f"{path.name}: {error}") from None


def _day(path: Path) -> str:
    modified = datetime.datetime.fromtimestamp(path.stat().st_mtime, datetime.UTC)
    return modified.date().isoformat()
