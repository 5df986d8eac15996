"""A trial: rows of the table simulated under one set-up, with every measure and statistic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.quantities import WEAR_COLUMNS
from abradem.sampling.checks import check_case
from abradem.sampling.draw import case_seed
from abradem.simulation.batch import run_case
from abradem.wear.rates import wear_rates

RUN_COLUMNS = ["trial", "case_id", "replicate", "element_size", "status", *WEAR_COLUMNS]


def run_trial(
    trial: int,
    rows: pd.DataFrame,
    setup: Mapping,
    replicates: int,
    element_sizes: Sequence[float],
    footprint_share: float = 0.95,
) -> pd.DataFrame:
    """Simulate rows of a table under a set-up.

    The seeds of a row are the same in every trial, so that set-ups are compared on the same
    particles.

    Parameters
    ----------
    trial : int
        Number of the set-up.
    rows : pandas.DataFrame
        From `abradem.calibration.rows.arranged_rows`.
    setup : mapping
        Plain values of the `Setup`.
    replicates : int
        Simulations of each row, with different seeds.
    element_sizes : sequence of float
        Edges of the elements of the statistics, m; all come from one simulation.
    footprint_share : float
        See `abradem.wear.rates.wear_rates`.

    Returns
    -------
    pandas.DataFrame
        `RUN_COLUMNS`: one row for each row of the table, replicate and element size; wear rates in
        mm/s, nan where the simulation has none, with the reason in ``status``.
    """
    found = []
    built = Setup.from_dict(setup)
    for row in rows.to_dict("records"):
        refused = check_case(row, built)
        for replicate in range(replicates):
            case = {**row, "seed": case_seed(int(row["seed"]), replicate), "rejected": refused}
            tables = run_case(case, setup)
            status = str(tables["runs"]["status"].iloc[0])
            for size in element_sizes:
                rates = wear_rates(
                    tables["series"],
                    tables["maps"],
                    tables["runs"],
                    pd.DataFrame([case]),
                    built,
                    footprint_share=footprint_share,
                    element_size=size,
                )
                values = (
                    {name: float(rates[name].iloc[0]) for name in WEAR_COLUMNS}
                    if len(rates)
                    else dict.fromkeys(WEAR_COLUMNS, np.nan)
                )
                found.append(
                    {
                        "trial": trial,
                        "case_id": int(row["case_id"]),
                        "replicate": replicate,
                        "element_size": size,
                        "status": status,
                        **values,
                    }
                )
    return pd.DataFrame(found, columns=RUN_COLUMNS).astype(
        {"trial": "int64", "case_id": "int64", "replicate": "int32", "element_size": "float64"}
    )


def run_place(
    chosen: Sequence[int | None],
    place: int,
    setups: Sequence[Mapping],
    rows: pd.DataFrame,
    count: int,
    held_out: bool,
    replicates: int,
    element_sizes: Sequence[float],
    footprint_share: float,
) -> pd.DataFrame:
    """Run the trial at a place of a rung; an empty table if there is none.

    Parameters
    ----------
    chosen : sequence of int or None
        Trials of the rung.
    place : int
    setups : sequence of mapping
        Of all trials, by number.
    rows : pandas.DataFrame
        From `abradem.calibration.rows.arranged_rows`.
    count : int
        Number of rows used.
    held_out : bool
        Whether the rows held out are simulated too.
    replicates, element_sizes, footprint_share
        See `run_trial`.
    """
    parts = [rows[rows["part"] == "used"].head(count)]
    if held_out:
        parts.append(rows[rows["part"] == "held out"])
    here = pd.concat(parts, ignore_index=True)
    trial = chosen[place]
    if trial is None:
        here, trial = here.iloc[:0], 0
    return run_trial(trial, here, setups[trial], replicates, element_sizes, footprint_share)
