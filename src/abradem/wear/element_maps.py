"""Wear maps of many cases as arrays, from the tables of the simulations.

The depth rate of an element is W J / (A t) by Archard's law (Archard 1953, J. Appl. Phys. 24:981),
with its area A, the work J = F_n ds in the window and the length t of the window.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.units import MM_PER_M
from abradem.wear.rates import depth_map, element_counts, element_wear


def element_maps(
    batches: Iterable[tuple[pd.DataFrame, pd.DataFrame]],
    dataset: pd.DataFrame,
    setup: Setup,
    measure: str,
    element_size: float | None = None,
) -> np.ndarray:
    """Wear depth rate of the elements of the plate, for all cases of a data set.

    Parameters
    ----------
    batches : iterable of (maps, runs)
        Tables of the batches of simulations (W = 1).
    dataset : pandas.DataFrame
        case_id and archard_constant (1/Pa); gives the cases and their order.
    setup : Setup
    measure : str
        One of `abradem.quantities.WEAR_MEASURES`.
    element_size : float, optional
        Edge of the elements, m, see `abradem.wear.rates.element_counts`; by default a facet.

    Returns
    -------
    ndarray, shape (n, nx, nz)
        mm/s; x is along the slope, z across. All nan for a case without a completed window.

    Raises
    ------
    ValueError
        If the plate does not consist of such elements, or a case is in no batch.
    """
    counts = element_counts(setup, element_size)
    area = setup.plate_area / (counts[0] * counts[1])
    keys = dataset["case_id"].to_numpy()
    place = {int(key): row for row, key in enumerate(keys)}
    constants = dataset["archard_constant"].to_numpy(dtype=float)
    rates = np.full((len(keys), *counts), np.nan)
    left = set(place)
    for maps, runs in batches:
        rows_of = {int(key): rows for key, rows in maps.groupby("case_id", sort=False)}
        for run in runs[runs["case_id"].isin(place)].to_dict("records"):
            key = int(run["case_id"])
            left.discard(key)
            window = run["window_end"] - run["window_start"]
            if not window > 0.0:
                continue
            work = depth_map(rows_of.get(key, maps.iloc[:0]), setup.facets)[measure]
            rate = constants[place[key]] * element_wear(work, counts) / (area * window)
            rates[place[key]] = MM_PER_M * rate
    if left:
        raise ValueError(f"case {min(left)} of the data set is in no batch of simulations")
    return rates
