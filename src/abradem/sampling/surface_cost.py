"""Estimate of the computing time of cases on a geometry, see `abradem.sampling.cost`.

A particle passes a chute in a second and touches it for a part of that; one that a turning part
stirs is pressed against others and against the surface until it is conveyed out. So the time is
that of the particles that are present, times a share of the cost of a contact for either way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.geometry.build import factory_of, geometry_described
from abradem.geometry.kinds import Geometry, Plates, Screw
from abradem.geometry.shape import GeometryError

PASSING, STIRRED = 0.29, 3.3
"""Cost of a particle that is present for a step, in that of a step in contact with the plate: where
particles pass, and where a part turns. The first is between those of the studies two_plates (0.44,
as bounces hold particles up) and curved_chute (0.19), the second from a full screw, in which 467
particles took 10 s for a simulated second. ``python benchmarks/order.py results/<study>`` compares
the estimate with a finished study."""


def presence(cases: pd.DataFrame, setup: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Estimate how long a particle of each case is present, and what it costs.

    Parameters
    ----------
    cases : pandas.DataFrame
        Table of cases, n rows, with the sampled quantities of the geometry.
    setup : mapping
        Plain values of a `Setup` with a geometry.

    Returns
    -------
    dwell : ndarray, shape (n,)
        s; 0 for a case that cannot be simulated.
    share : ndarray, shape (n,)
        `PASSING` or `STIRRED`.
    """
    values = Setup.from_dict(dict(setup))
    found = [_of_case(values, row) for row in cases.to_dict("records")]
    dwell, share = np.array(found).reshape(-1, 2).T
    return dwell, share


def _of_case(setup: Setup, row: Mapping) -> tuple[float, float]:
    try:
        feed = factory_of(setup, row)
        geometry = geometry_described(setup, row)
        shape = geometry.shape(setup.facet_size)
    except GeometryError:
        return 0.0, PASSING
    start = np.array(feed.centre)
    low = np.minimum(shape.vertices.min(axis=0), start)
    high = np.maximum(shape.vertices.max(axis=0), start)
    first = abs(row["particle_velocity_y"])
    last = math.sqrt(first**2 + 2.0 * setup.gravity * float(start[1] - low[1]))
    passing = float(np.linalg.norm(high - low)) / max(0.5 * (first + last), 1e-3)
    carried = _carried(geometry, float(start[0]))
    turns = any(motion.revolutions for motion in geometry.motions())
    return max(passing, carried), STIRRED if turns else PASSING


def _carried(geometry: Geometry, place: float) -> float:
    """How long a moving part carries a particle that enters at x = ``place`` (m), s; or 0."""
    if isinstance(geometry, Screw) and geometry.revolutions:
        return place / (geometry.pitch * abs(geometry.revolutions) / 60.0)
    if isinstance(geometry, Plates):
        return sum(plate.length / abs(plate.belt) for plate in geometry.plates if plate.belt)
    turning = [abs(one.revolutions) for one in geometry.motions() if one.revolutions]
    return 60.0 / min(turning) if turning else 0.0
