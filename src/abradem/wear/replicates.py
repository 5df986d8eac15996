"""Repeated simulations with other seeds, for the random part of a wear rate."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.quantities import STDERR_COLUMNS, WEAR_COLUMNS
from abradem.sampling.draw import case_seed
from abradem.simulation.batch import TABLES, run_case
from abradem.wear.rates import wear_rates

CHEAP_SHARE = 0.5
"""Share of the cases, those with the largest particles, from which replicates are chosen."""

TYPES = {"case_id": "int64", "replicate": "int32", "seed": "int64"} | dict.fromkeys(
    (*WEAR_COLUMNS, *STDERR_COLUMNS), "float64"
)
COLUMNS = list(TYPES)


def choose_cases(cases: pd.DataFrame, count: int) -> pd.DataFrame:
    """Return the cases to repeat: ``count`` cases with large particles, evenly over their ranks.

    Parameters
    ----------
    cases : pandas.DataFrame
        Cases of the first block of a study.
    count : int
        Number of cases to choose.
    """
    sound = cases[cases["rejected"] == ""].sort_values("particle_radius", ignore_index=True)
    large = sound.iloc[int(len(sound) * (1.0 - CHEAP_SHARE)) :]
    places = np.unique(np.linspace(0, len(large) - 1, min(count, len(large))).round().astype(int))
    return large.iloc[places].reset_index(drop=True)


def replicate(
    cases: pd.DataFrame, replicates: int, setup: Mapping, options: Mapping | None = None
) -> pd.DataFrame:
    """Simulate cases again with other seeds.

    Parameters
    ----------
    cases : pandas.DataFrame
        Rows of `choose_cases`.
    replicates : int
        Number of simulations of each case.
    setup : mapping
        Plain values of the `Setup`.
    options : mapping, optional
        Options of `abradem.wear.rates.wear_rates`.

    Returns
    -------
    pandas.DataFrame
        case_id, replicate, seed, and all wear rates with their standard errors (mm/s). Simulations
        without a wear rate are left out.
    """
    found = [pd.DataFrame(columns=COLUMNS).astype(TYPES)]
    for case in cases.to_dict("records"):
        for number in range(replicates):
            row = {**case, "seed": case_seed(int(case["seed"]), number)}
            tables = run_case(row, setup)
            rates = wear_rates(
                **{name: tables[name] for name in TABLES},
                cases=pd.DataFrame([row]),
                setup=Setup.from_dict(setup),
                **(options or {}),
            )
            found.append(rates.assign(replicate=number, seed=row["seed"])[COLUMNS])
    return pd.concat(found, ignore_index=True).astype(TYPES)
