"""Simulations in batches: consecutive cases of one block, simulated by one job, in four tables.

A batch is a pure function of the cases of the block, the set-up and the code, so a study can be
enlarged without a change of existing results. A fifth table, the processor time of each case,
depends on the machine. Each finished case is saved immediately, under a name derived from
everything that determines it and with the checksums of its files. An interrupted batch continues
with the saved cases and gives the same bytes as an uninterrupted one (except for the times); a
saved case that is damaged is simulated again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import shutil
import time
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path

from abradem.dem.model import Case, Setup, SimulationResult
from abradem.geometry.build import mesh_file, prepared
from abradem.quantities import GEOMETRY_NAMES, SAMPLED_NAMES, WEAR_MEASURES
from abradem.simulation.cell_columns import CELL_TYPES, cell_columns
from abradem.store.checksums import sha256_of
from abradem.store.locks import locked

TABLES = ("series", "maps", "parts", "runs")
"""Tables with the result of a case."""

FILES = ("series", "maps", "parts", "times", "runs")
"""Tables saved for a case, in the order of writing: if ``runs`` exists, so do the others."""

SUMS = "sums"
"""The last file of a saved case, JSON: the SHA-256 of each of its tables."""


STARTED = "started"
"""File in the folder of finished cases of a batch. It is rewritten at every start of the batch and
contains the number of cases that were finished before."""


def case_key(row: Mapping, setup: Mapping, code: str) -> str:
    """Return the name of a finished case: a hash of everything that determines it.

    Parameters
    ----------
    row : mapping
        Row of a table of cases.
    setup : mapping
        Plain values of the `Setup`.
    code : str
        Hash of the simulation code.
    """
    names = (*SAMPLED_NAMES, *(name for name in GEOMETRY_NAMES if name in row))
    values = {name: float(row[name]) for name in names}
    identity = {name: int(row[name]) for name in ("case_id", "block", "seed")}
    content = [values, identity, str(row["rejected"]), setup, code]
    if mesh := mesh_file(setup.get("geometry")):
        content.append(sha256_of(mesh))
    text = json.dumps(content, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def run_case(
    row: Mapping,
    setup: Mapping,
    progress: Callable[[float], object] | None = None,
    threads: int = 1,
) -> dict:
    """Simulate one case.

    Parameters
    ----------
    row : mapping
        Row of a table of cases.
    setup : mapping
        Plain values of the `Setup`.
    progress : callable, optional
        Called with the simulated time, s.
    threads : int, optional
        Number of threads of the simulation; the result does not depend on it.

    Returns
    -------
    dict
        A DataFrame for each name in `TABLES`. All but ``runs`` are empty for a case that
        was not simulated because it is rejected, because the engine refuses it, or because of an
        arithmetic error.

    Raises
    ------
    Exception
        An error that is not caused by the case: too little memory, a full disk, a damaged
        installation. Another attempt may succeed, so the error must not become a result.
    """
    if row["rejected"]:
        return _without_result(row, setup, f"rejected: {row['rejected']}")
    from abradem.dem import simulate

    options = {"progress": progress, "threads": threads if threads > 1 else None}
    given = {name: value for name, value in options.items() if value is not None}
    try:
        built = prepared(Setup.from_dict(setup), row)
        result = simulate(Case.from_row(row), built, **given)
    except ValueError as error:
        # The engine refuses a case that it cannot integrate; the other cases continue.
        return _without_result(row, setup, f"refused: {error}")
    except ArithmeticError as error:
        return _without_result(row, setup, f"failed: {type(error).__name__}: {error}")
    return result_tables(row, result)


def kernels_needed(setup: Mapping, threads: int = 1) -> list[tuple[str, bool]]:
    """Return the arguments of `abradem.dem.warm.load` for the kernels of a set-up.

    Several threads share a crowd on the plate alone.

    Parameters
    ----------
    setup : mapping
        Plain values of the `Setup`.
    threads : int
        Number of threads of a simulation.
    """
    on_surface = bool(setup.get("geometry"))
    needed = [(setup.get("stepping", Setup.stepping), on_surface)]
    if threads > 1 and not on_surface:
        needed.append(("parallel", False))
    return needed


def run_batch(
    cases,
    setup: Mapping,
    outputs: Mapping,
    finished: Path,
    code: str = "",
    threads: int = 1,
) -> None:
    """Simulate the cases of a batch and write its tables.

    Parameters
    ----------
    cases : pandas.DataFrame
        Rows of ``cases/block-*.parquet``.
    setup : mapping
        Plain values of the `Setup`.
    outputs : mapping of str to path
        Path for each of `FILES`. ``times`` contains the processor time of each case, s,
        independent of the number of attempts. Snakemake's own figure for a job in ``benchmarks/``
        is up to 30 s too low: after the first 15 s it samples a job every 30 s, and not at the
        end.
    finished : path
        Folder, used only by this batch, for finished cases until all cases are done.
    code : str
        Hash of the simulation code; cases finished by other code are not used.
    threads : int, optional
        Number of threads of each simulation; no table but ``times`` depends on it.

    Raises
    ------
    RuntimeError
        With one line for each case that could not be simulated, see `run_case`. The other cases
        are finished and saved.
    """
    from abradem.store.tables import concatenate, write_table

    finished = Path(finished)
    with locked(finished.with_name(f"{finished.name}.lock")):
        finished.mkdir(parents=True, exist_ok=True)
        rows = cases.to_dict("records")
        keys = [case_key(row, setup, code) for row in rows]
        _drop_others(finished, keys)
        (finished / STARTED).write_text(str(finished_cases(finished)), encoding="utf-8")

        frames: dict[str, list] = {name: [] for name in FILES}
        problems = []
        parent = os.getppid()
        for row, key in zip(rows, keys, strict=True):
            if os.getppid() != parent:
                raise RuntimeError("the run that started this job is gone; finished cases are kept")
            paths = _paths(finished, key)
            try:
                tables = _kept(paths) or _simulated(row, setup, paths, threads)
            except Exception as error:
                if isinstance(error, OSError):
                    # If results cannot be written, no other case can succeed.
                    raise
                traceback.print_exc()
                reason = str(error) or type(error).__name__
                if isinstance(error, MemoryError):
                    reason = f"too little memory: {reason}"
                problems.append(f"case {row['case_id']}: {reason}")
                continue
            for name in FILES:
                frames[name].append(tables[name])
        if problems:
            raise RuntimeError("\n".join(problems))
        for name in FILES:
            write_table(concatenate(frames[name]), outputs[name])
        shutil.rmtree(finished)


def _simulated(row: Mapping, setup: Mapping, paths: Mapping, threads: int) -> dict:
    """Simulate a case and save its tables."""
    import pandas as pd

    from abradem.dem import warm
    from abradem.store.files import write_json
    from abradem.store.tables import write_table

    if not row["rejected"]:
        # Otherwise the time of the first case of a job would include half a second of loading.
        for stepping, on_surface in kernels_needed(setup, threads):
            warm.load(stepping, on_surface)
        if mesh_file(setup.get("geometry")):
            # So would the library that reads the file. What is wrong with it is told below.
            with contextlib.suppress(ValueError):
                prepared(Setup.from_dict(setup), row)
    start = time.process_time()
    tables = run_case(row, setup, threads=threads)
    spent = time.process_time() - start
    tables["times"] = pd.DataFrame({"case_id": [int(row["case_id"])], "processor_time": [spent]})
    for name in FILES:
        write_table(tables[name], paths[name])
    write_json({name: sha256_of(paths[name]) for name in FILES}, paths[SUMS])
    return tables


def _kept(paths: Mapping) -> dict | None:
    """Return the tables of a case that was finished before, or None.

    The checksums are compared because a table with a damaged name or type may still be read.
    """
    from abradem.store.files import TableError, read_json
    from abradem.store.tables import read_table

    try:
        if read_json(paths[SUMS]) != {name: sha256_of(paths[name]) for name in FILES}:
            return None
        return {name: read_table(paths[name]) for name in FILES}
    except (TableError, OSError):
        # Missing, damaged by a crash of the machine, or on a bad place of the disk.
        return None


def _paths(folder: Path, key: str) -> dict[str, Path]:
    """Paths of the files of a saved case."""
    tables = {name: folder / f"{key}.{name}.parquet" for name in FILES}
    return {**tables, SUMS: folder / f"{key}.{SUMS}.json"}


def finished_cases(folder: Path) -> int:
    """Return the number of finished cases in the folder of a batch."""
    return sum(1 for _ in Path(folder).glob("*.runs.parquet"))


def resumed_cases(folder: Path) -> int:
    """Return the number of cases that a running batch reuses from an interrupted run."""
    try:
        return int((Path(folder) / STARTED).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return 0


def _drop_others(folder: Path, keys: list[str]) -> None:
    """Remove files that belong to none of ``keys``: results of other values or other code."""
    wanted = {path.name for key in keys for path in _paths(folder, key).values()}
    for path in folder.iterdir():
        if path.name not in wanted and path.name != STARTED:
            path.unlink()


def result_tables(row: Mapping, result: SimulationResult) -> dict:
    """Return the tables of one simulated case, a DataFrame for each name in `TABLES`.

    Parameters
    ----------
    row : mapping
        Has case_id, block and seed.
    result : SimulationResult
    """
    import numpy as np
    import pandas as pd

    case_id = int(row["case_id"])
    series = pd.DataFrame({"case_id": np.full(len(result.time), case_id), "time": result.time})
    for index, measure in enumerate(WEAR_MEASURES):
        series[f"worn_{measure}"] = result.worn[:, index]
    series["delivered_mass"] = result.delivered_mass
    series["particles_present"] = result.present

    # The cells of a surface are a column of facets.
    wear, parts = result.facet_wear, result.facet_wear_parts
    if result.setup.surface is not None:
        wear, parts = wear[..., None], parts[..., None]
    facet_x, facet_z = np.indices(wear.shape[1:], dtype=np.int32)
    maps = pd.DataFrame(
        {
            "case_id": np.full(facet_x.size, case_id),
            "facet_x": facet_x.ravel(),
            "facet_z": facet_z.ravel(),
        }
    )
    for index, measure in enumerate(WEAR_MEASURES):
        maps[f"wear_{measure}"] = wear[index].ravel()
    if result.setup.surface is not None:
        maps = maps.assign(**cell_columns(result.setup.surface, result.cell_sums))

    numbers = {name: float(getattr(result, name)) for name in _RUN_NUMBERS}
    numbers["window_start"], numbers["window_end"] = (float(end) for end in result.window)
    counts = {name: int(getattr(result, name)) for name in ("released", "removed")}
    counts["settled"] = bool(result.settled)
    counts["window_parts"] = len(parts)
    return {
        "series": series,
        "maps": maps,
        "parts": _parts(case_id, parts),
        "runs": _run_row(row, result.status, numbers, counts),
    }


PART_BITS = 12
"""Significant bits of the wear in the parts of a window. They only tell standard errors, and
rounded they take half of the space."""


def _parts(case_id: int, wear):
    """Return the table of the parts of a window, shape (parts, 3, nx, nz), where there is wear."""
    import numpy as np
    import pandas as pd

    part, facet_x, facet_z = (
        index.astype(np.int32) for index in np.nonzero((wear != 0.0).any(axis=1))
    )
    table = pd.DataFrame(
        {
            "case_id": np.full(part.size, case_id, dtype=np.int64),
            "window_part": part,
            "facet_x": facet_x,
            "facet_z": facet_z,
        }
    )
    for index, measure in enumerate(WEAR_MEASURES):
        mantissa, exponent = np.frexp(wear[part, index, facet_x, facet_z])
        rounded = np.ldexp(np.round(mantissa * 2**PART_BITS), exponent - PART_BITS)
        table[f"part_wear_{measure}"] = rounded.astype(np.float32)
    return table


def _without_result(row: Mapping, setup: Mapping, status: str) -> dict:
    """Return the tables of a case that was not simulated."""
    import numpy as np
    import pandas as pd

    numbers = dict.fromkeys((*_RUN_NUMBERS, "window_start", "window_end"), math.nan)
    numbers["simulated_time"] = 0.0
    counts = {"settled": False, "window_parts": 0, "released": 0, "removed": 0}
    series = ("time", *(f"worn_{measure}" for measure in WEAR_MEASURES), "delivered_mass")
    present = {"case_id": "int64", "particles_present": "int32"}
    wear = tuple(f"wear_{measure}" for measure in WEAR_MEASURES)
    integers = dict.fromkeys(("case_id", "facet_x", "facet_z"), "int64")
    cells = CELL_TYPES if setup.get("geometry") else {}
    return {
        "series": pd.DataFrame(
            columns=("case_id", *series, "particles_present"), dtype=float
        ).astype(present),
        "maps": pd.DataFrame(columns=(*integers, *wear, *cells), dtype=float).astype(
            {**integers, **cells}
        ),
        "parts": _parts(int(row["case_id"]), np.empty((0, len(WEAR_MEASURES), 0, 0))),
        "runs": _run_row(row, status, numbers, counts),
    }


_RUN_NUMBERS = (
    "simulated_time", "steady_from", "stderr", "time_step", "requested_rate", "delivered_rate",
    "face_share", "edge_share", "missed_share", "max_overlap",
)  # fmt: skip

_RUN_COLUMNS = (
    "case_id", "block", "seed", "status", "simulated_time", "steady_from", "settled",
    "window_start", "window_end", "window_parts", "stderr", "time_step", "requested_rate",
    "delivered_rate", "face_share", "edge_share", "missed_share", "max_overlap", "released",
    "removed",
)  # fmt: skip


def _run_row(row: Mapping, status: str, numbers: Mapping, counts: Mapping):
    import pandas as pd

    identity = {name: int(row[name]) for name in ("case_id", "block", "seed")}
    values = {**identity, "status": status, **numbers, **counts}
    return pd.DataFrame([values], columns=_RUN_COLUMNS)
