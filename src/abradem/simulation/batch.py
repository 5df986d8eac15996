"""Simulations in batches: a run of neighbouring cases of one block, one job, three tables.

A batch is a pure function of the block's cases, the set-up and the code, so that a study can
grow without touching what it has. A fourth table, of what each case cost, is of the machine.
Each case that is finished is kept at once, under a name made of everything that determines it;
a batch that was interrupted takes these up again and gives the same bytes as one that was not
(times excepted).
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import shutil
import time
import traceback
from collections.abc import Mapping
from pathlib import Path

from abradem.dem.model import Case, Setup
from abradem.quantities import SAMPLED_NAMES, WEAR_MEASURES
from abradem.store.locks import locked

TABLES = ("series", "maps", "runs")
"""Tables of a case's result."""

FILES = ("series", "maps", "times", "runs")
"""Tables that are kept of a case, in the order they are written: if there are runs, so are the
others."""


STARTED = "started"
"""File in a batch's folder of finished cases, renewed whenever the batch starts; it holds the
number of cases that were finished before."""


def case_key(row: Mapping, setup: Mapping, code: str) -> str:
    """Name of a finished case: a hash of all that determines it.

    Parameters
    ----------
    row : mapping
        Row of a table of cases.
    setup : mapping
        Plain values of the `Setup`.
    code : str
        Hash of the code that simulates.
    """
    values = {name: float(row[name]) for name in SAMPLED_NAMES}
    identity = {name: int(row[name]) for name in ("case_id", "block", "seed")}
    content = [values, identity, str(row["rejected"]), setup, code]
    text = json.dumps(content, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def run_case(row: Mapping, setup: Mapping) -> dict:
    """Simulate one case.

    Parameters
    ----------
    row : mapping
        Row of a table of cases.
    setup : mapping
        Plain values of the `Setup`.

    Returns
    -------
    dict
        Under each name of `TABLES` a DataFrame; ``series`` and ``maps`` are empty for a
        case that was not simulated, because it is rejected, the engine refuses it or its
        numbers fail.

    Raises
    ------
    Exception
        What does not follow from the case: too little memory, a full disk, a damaged
        installation. Another attempt may end well, so it must not become a result.
    """
    if row["rejected"]:
        return _without_result(row, f"rejected: {row['rejected']}")
    from abradem.dem import simulate

    try:
        result = simulate(Case.from_row(row), Setup.from_dict(setup))
    except ValueError as error:
        # The engine refuses what it cannot integrate; the other cases go on.
        return _without_result(row, f"refused: {error}")
    except ArithmeticError as error:
        return _without_result(row, f"failed: {type(error).__name__}: {error}")
    return _tables(row, result)


def run_batch(cases, setup: Mapping, outputs: Mapping, finished: Path, code: str = "") -> None:
    """Simulate the cases of a batch and write its tables.

    Parameters
    ----------
    cases : pandas.DataFrame
        Rows of ``cases/block-*.parquet``.
    setup : mapping
        Plain values of the `Setup`.
    outputs : mapping of str to path
        Where each of `FILES` goes: ``times`` holds the processor time of each case, s, however
        many attempts the batch took. Snakemake's own figure of a job in ``benchmarks/`` is up to
        30 s short: after its first 15 s it looks at a job every 30 s, and not at its end.
    finished : path
        Folder of this batch alone in which finished cases are kept until all are done.
    code : str
        Hash of the code that simulates; cases finished by other code are not used.

    Raises
    ------
    RuntimeError
        With one line for each case that could not be simulated, see `run_case`; the other
        cases are finished and kept.
    """
    from abradem.store.tables import concatenate, write_table

    finished = Path(finished)
    with locked(finished.with_name(f"{finished.name}.lock")):
        finished.mkdir(parents=True, exist_ok=True)
        rows = cases.to_dict("records")
        keys = [case_key(row, setup, code) for row in rows]
        _drop_others(finished, keys)
        (finished / STARTED).write_text(str(finished_cases(finished)), encoding="utf-8")

        frames = {name: [] for name in FILES}
        problems = []
        parent = os.getppid()
        for row, key in zip(rows, keys, strict=True):
            if os.getppid() != parent:
                raise RuntimeError("the run that started this job is gone; finished cases are kept")
            paths = {name: finished / f"{key}.{name}.parquet" for name in FILES}
            try:
                tables = _kept(paths) or _simulated(row, setup, paths)
            except Exception as error:
                if isinstance(error, OSError):
                    # Without a place for results, no other case can end well.
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


def _simulated(row: Mapping, setup: Mapping, paths: Mapping) -> dict:
    """Simulate a case and keep its tables."""
    import pandas as pd

    from abradem.dem import warm
    from abradem.dem.model import Setup
    from abradem.store.tables import write_table

    if not row["rejected"]:
        # Else the first case of a job would take half a second more.
        warm.load(setup.get("stepping", Setup.stepping))
    start = time.process_time()
    tables = run_case(row, setup)
    spent = time.process_time() - start
    tables["times"] = pd.DataFrame({"case_id": [int(row["case_id"])], "processor_time": [spent]})
    for name in FILES:
        write_table(tables[name], paths[name])
    return tables


def _kept(paths: Mapping) -> dict | None:
    """Tables of a case that was finished before, or None."""
    from abradem.store.files import TableError
    from abradem.store.tables import read_table

    try:
        return {name: read_table(paths[name]) for name in reversed(FILES)}
    except TableError:
        # Not there, or damaged by a machine that went down.
        return None


def finished_cases(folder: Path) -> int:
    """Number of finished cases that a batch's folder holds."""
    return sum(1 for _ in Path(folder).glob("*.runs.parquet"))


def resumed_cases(folder: Path) -> int:
    """Number of cases that a running batch took over from an earlier, interrupted run."""
    try:
        return int((Path(folder) / STARTED).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return 0


def _drop_others(folder: Path, keys: list[str]) -> None:
    """Remove what belongs to none of ``keys``: remains of other values or other code."""
    wanted = {f"{key}.{name}.parquet" for key in keys for name in FILES}
    for path in folder.iterdir():
        if path.name not in wanted and path.name != STARTED:
            path.unlink()


def _tables(row: Mapping, result) -> dict:
    """Tables of one simulated case."""
    import numpy as np
    import pandas as pd

    case_id = int(row["case_id"])
    series = pd.DataFrame({"case_id": np.full(len(result.time), case_id), "time": result.time})
    for index, measure in enumerate(WEAR_MEASURES):
        series[f"worn_{measure}"] = result.worn[:, index]
    series["delivered_mass"] = result.delivered_mass
    series["particles_present"] = result.present

    facet_x, facet_z = np.indices(result.facet_wear.shape[1:], dtype=np.int32)
    maps = pd.DataFrame(
        {
            "case_id": np.full(facet_x.size, case_id),
            "facet_x": facet_x.ravel(),
            "facet_z": facet_z.ravel(),
        }
    )
    for index, measure in enumerate(WEAR_MEASURES):
        maps[f"wear_{measure}"] = result.facet_wear[index].ravel()

    numbers = {name: float(getattr(result, name)) for name in _RUN_NUMBERS}
    numbers["window_start"], numbers["window_end"] = (float(end) for end in result.window)
    counts = {name: int(getattr(result, name)) for name in ("released", "removed")}
    counts["settled"] = bool(result.settled)
    return {"series": series, "maps": maps, "runs": _run_row(row, result.status, numbers, counts)}


def _without_result(row: Mapping, status: str) -> dict:
    """Tables of a case that was not simulated."""
    import pandas as pd

    numbers = dict.fromkeys((*_RUN_NUMBERS, "window_start", "window_end"), math.nan)
    numbers["simulated_time"] = 0.0
    counts = {"settled": False, "released": 0, "removed": 0}
    series = ("time", *(f"worn_{measure}" for measure in WEAR_MEASURES), "delivered_mass")
    present = {"case_id": "int64", "particles_present": "int32"}
    wear = tuple(f"wear_{measure}" for measure in WEAR_MEASURES)
    integers = dict.fromkeys(("case_id", "facet_x", "facet_z"), "int64")
    return {
        "series": pd.DataFrame(
            columns=("case_id", *series, "particles_present"), dtype=float
        ).astype(present),
        "maps": pd.DataFrame(columns=(*integers, *wear), dtype=float).astype(integers),
        "runs": _run_row(row, status, numbers, counts),
    }


_RUN_NUMBERS = (
    "simulated_time", "steady_from", "stderr", "time_step", "requested_rate", "delivered_rate",
    "face_share", "edge_share", "missed_share", "max_overlap",
)  # fmt: skip

_RUN_COLUMNS = (
    "case_id", "block", "seed", "status", "simulated_time", "steady_from", "settled",
    "window_start", "window_end", "stderr", "time_step", "requested_rate", "delivered_rate",
    "face_share", "edge_share", "missed_share", "max_overlap", "released", "removed",
)  # fmt: skip


def _run_row(row: Mapping, status: str, numbers: Mapping, counts: Mapping):
    import pandas as pd

    identity = {name: int(row[name]) for name in ("case_id", "block", "seed")}
    values = {**identity, "status": status, **numbers, **counts}
    return pd.DataFrame([values], columns=_RUN_COLUMNS)
