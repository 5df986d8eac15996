"""Sweeps: all combinations of some values, simulated or predicted by a surrogate, as one table.

Every combination is simulated by the functions of a study (`abradem.simulation.batch.run_case`,
`abradem.wear.rates.wear_rates`), so a row has the numbers that a study would give for that case.
All have the same seed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any

import pandas as pd

from abradem.cases.kept_rows import KeptRows
from abradem.dem.model import Setup
from abradem.quantities import GEOMETRY_NAMES, SAMPLED_NAMES, STDERR_COLUMNS, WEAR_COLUMNS
from abradem.sampling.checks import check_case
from abradem.simulation.batch import TABLES, run_case
from abradem.store.workers import end_with_parent
from abradem.surrogate.model import Surrogate
from abradem.wear.rates import wear_rates

MOST_CASES = 20_000
"""Largest number of cases of a sweep."""


def combinations(values: Mapping[str, float | Sequence[float]]) -> pd.DataFrame:
    """Return all combinations of the values, one row each, columns in the order given.

    Parameters
    ----------
    values : mapping of str to float or sequence of float
        By quantity; a number is the same in all rows. The last sequence varies fastest.

    Raises
    ------
    ValueError
        If there are more than `MOST_CASES`.
    """
    lists = [[one] if isinstance(one, (int, float)) else list(one) for one in values.values()]
    count = math.prod(map(len, lists))
    if count > MOST_CASES:
        raise ValueError(f"the sweep has {count} cases (allowed {MOST_CASES})")
    return pd.DataFrame(list(itertools.product(*lists)), columns=list(values), dtype=float)


def simulate_cases(
    cases: pd.DataFrame,
    setup: Mapping,
    seed: int,
    options: Mapping | None = None,
    cores: int = 1,
    finished: Callable[[int], object] | None = None,
    kept: KeptRows | None = None,
) -> pd.DataFrame:
    """Simulate all cases and return their wear rates.

    Parameters
    ----------
    cases : pandas.DataFrame
        All sampled quantities, n rows.
    setup : mapping
        Plain values of the `Setup`.
    seed : int
        Of every case.
    options : mapping, optional
        Options of `abradem.wear.rates.wear_rates`.
    cores : int
        Number of processes; the result does not depend on it.
    finished : callable, optional
        Called with the number of finished cases.
    kept : KeptRows, optional
        Finished cases of an interrupted sweep, which are not simulated again; the others are added
        as they end.

    Returns
    -------
    pandas.DataFrame
        n rows in the same order: the quantities, ``seed``, ``status``, ``simulated_time``, the
        wear rates and their standard errors (mm/s, nan where the status is not ok or there is no
        steady rate) and ``quality`` ("" where the status is not ok).
    """
    plain, wanted = dict(setup), dict(options or {})
    jobs = [
        (_row(number, seed, case, plain), plain, wanted)
        for number, case in enumerate(cases.to_dict("records"))
    ]
    with kept or KeptRows() as store:
        # The number of a case in its sweep decides nothing.
        keys = [store.key({**row, "case_id": 0}, plain, wanted) for row, _, _ in jobs]
        rows = {
            place: row for place, key in enumerate(keys) if (row := store.find(key)) is not None
        }
        if rows and finished is not None:
            finished(len(rows))
        waiting = [place for place in range(len(jobs)) if place not in rows]
        for number, row in _results([jobs[place] for place in waiting], cores):
            rows[waiting[number]] = row
            store.add(keys[waiting[number]], row)
            if finished is not None:
                finished(len(rows))
    added = pd.DataFrame([rows[place] for place in range(len(jobs))])
    return pd.concat([cases.reset_index(drop=True), added], axis=1)


def _row(number: int, seed: int, case: Mapping, setup: Mapping) -> dict[str, Any]:
    names = (*SAMPLED_NAMES, *(name for name in GEOMETRY_NAMES if name in case))
    values = {name: float(case[name]) for name in names}
    rejected = check_case(values, Setup.from_dict(setup))
    return {"case_id": number, "block": 0, "seed": seed, "rejected": rejected, **values}


def _results(jobs: Sequence[tuple], cores: int) -> Iterator[tuple[int, dict]]:
    """Place and result of every job, as they end."""
    if cores == 1 or len(jobs) < 2:
        yield from enumerate(itertools.starmap(_rates, jobs))
        return
    # A new interpreter: a copy of this one could hold a lock of a thread.
    processes, kind = min(cores, len(jobs)), get_context("spawn")
    with ProcessPoolExecutor(processes, kind, initializer=end_with_parent) as pool:
        places = {pool.submit(_rates, *job): place for place, job in enumerate(jobs)}
        try:
            for done in as_completed(places):
                yield places[done], done.result()
        except BaseException:
            # Cases that wait would be simulated before the error is seen.
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _rates(row: Mapping, setup: Mapping, options: Mapping) -> dict:
    """Simulate one case and return what the table adds to its quantities."""
    tables = run_case(row, setup)
    run = tables["runs"].iloc[0]
    rates = wear_rates(
        **{name: tables[name] for name in TABLES},
        cases=pd.DataFrame([row]),
        setup=Setup.from_dict(setup),
        **options,
    ).to_dict("records")
    found = rates[0] if rates else {}
    return {
        "seed": row["seed"],
        "status": run["status"],
        "simulated_time": float(run["simulated_time"]),
        **{name: found.get(name, math.nan) for name in (*WEAR_COLUMNS, *STDERR_COLUMNS)},
        "quality": found.get("quality", ""),
    }


def predict_cases(
    cases: pd.DataFrame, surrogate: Surrogate, level: float | None = None
) -> tuple[pd.DataFrame, list[str]]:
    """Predict all cases by a surrogate.

    Parameters
    ----------
    cases : pandas.DataFrame
        All sampled quantities, n rows.
    surrogate : Surrogate
    level : float, optional
        Level of the intervals.

    Returns
    -------
    table : pandas.DataFrame
        The quantities, ``wear_depth_rate``, ``wear_depth_rate_lower`` and
        ``wear_depth_rate_upper`` (mm/s).
    warnings : list of str
        Values outside the training ranges.
    """
    prediction = surrogate.predict(cases, level)
    table = cases.reset_index(drop=True).assign(
        wear_depth_rate=prediction.rate,
        wear_depth_rate_lower=prediction.lower,
        wear_depth_rate_upper=prediction.upper,
    )
    return table, prediction.warnings
