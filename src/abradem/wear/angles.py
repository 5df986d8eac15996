"""Short simulations for figures: wear depth over time for several plate and factory angles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import pandas as pd

from abradem.dem.model import Case, Setup
from abradem.dem.steady import steady_start
from abradem.quantities import WEAR_MEASURES
from abradem.units import MM_PER_M
from abradem.wear.rates import steady_rate

ANGLES = ("plate_angle", "factory_angle")


def depth_by_angle(
    case: Mapping[str, Any],
    setup: Setup,
    angles: Mapping[str, Iterable[float]],
    duration: float,
    measure: str,
    min_batches: int = 20,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Simulate the wear depth of the plate over time, with each angle varied separately.

    Parameters
    ----------
    case : mapping
        Arguments of `abradem.Case`; each of its angles is fixed while the other is varied.
    setup : Setup
    angles : mapping
        Values of each of `ANGLES`, degrees.
    duration : float
        Simulated time of each case, s.
    measure : str
        One of `abradem.quantities.WEAR_MEASURES`.
    min_batches : int
        Number of batches for slope and standard error.

    Returns
    -------
    curves : pandas.DataFrame
        varied, angle (deg), time (s), wear_depth (mm).
    rates : pandas.DataFrame
        varied, angle (deg), rate and rate_stderr (mm/s; nan without wear).

    Raises
    ------
    RuntimeError
        If a simulation ends early.
    """
    from abradem.dem import simulate

    setup = replace(setup, duration=duration)
    curves, rates, known = [], [], {}
    for varied in ANGLES:
        for angle in map(float, angles[varied]):
            values = {**case, varied: angle}
            place = (values["plate_angle"], values["factory_angle"])
            if place not in known:
                known[place] = simulate(Case(**values), setup)
            result = known[place]
            if result.status != "ok":
                raise RuntimeError(f"{varied} = {angle:g} deg: ended early: {result.status}")
            worn = result.worn[:, WEAR_MEASURES.index(measure)]
            depth = MM_PER_M * case["archard_constant"] / setup.plate_area * worn
            row = {"varied": varied, "angle": angle}
            curves.append(pd.DataFrame({**row, "time": result.time, "wear_depth": depth}))
            start = steady_start(result.time, depth).time
            fit = steady_rate(result.time, depth, start, min_batches, result.release_interval)
            rates.append({**row, "rate": fit.rate, "rate_stderr": fit.stderr})
    return pd.concat(curves, ignore_index=True), pd.DataFrame(rates)
