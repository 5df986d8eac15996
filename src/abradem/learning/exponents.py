"""Exponents of a study's wear rate beside those of the data that the paper's authors published.

Both are least squares of ln y on the logarithms of the quantities, on the cases that are faster
than `LEAST_SPEED`: at lower speeds the fall decides the impact, and the rates scatter.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.power_fit import wear_exponents

LEAST_SPEED = 4.0
"""Cases count if their initial speed is above this, m/s."""


class Published(NamedTuple):
    """An exponent in the published table and its standard error."""

    exponent: float
    stderr: float


# Least squares of ln y on the 109 rows faster than 4 m/s of the 198 rows that the authors of
# arXiv:2509.08637 published (training_parameters_postprocessing_new.csv in their repository, see
# docs/published_data.md), with H = 0.25 m; a scatter of 9 % is left.
PUBLISHED = {
    "archard_constant": Published(1.00, 0.01),
    "particle_radius": Published(0.87, 0.02),
    "particle_density": Published(0.24, 0.05),
    "impact_speed": Published(0.99, 0.02),
    "static_friction": Published(-0.77, 0.10),
    "restitution": Published(-0.37, 0.09),
    "particle_shear_modulus": Published(0.00, 0.02),
    "equipment_shear_modulus": Published(0.00, 0.02),
}
"""Exponents in the published table by quantity: of v^2 + 2 g H for ``impact_speed``, of 1 + e for
``restitution``."""

AGREES, DIFFERS, UNKNOWN = "agrees", "differs", "not determined"

COMBINED_ERRORS = 2.0
"""Largest difference of two exponents that agree, in their combined standard errors."""


def exponents_beside_published(dataset: pd.DataFrame, target: str, setup: Mapping) -> pd.DataFrame:
    """Exponents of a wear rate, those of the published table, and whether they agree.

    ``ln y = a + sum b ln x + c phi + d phi^2 + f theta``, see
    `abradem.dataset.power_fit.wear_exponents`, on the cases faster than `LEAST_SPEED` with a
    positive rate.

    Parameters
    ----------
    dataset : pandas.DataFrame
        Holds the sampled quantities and ``target``.
    target : str
        A wear-rate column, mm/s.
    setup : mapping
        Plain values of the `Setup`, for the fall height H of each case.

    Returns
    -------
    pandas.DataFrame
        One row for each of `PUBLISHED`: quantity, exponent, exponent_stderr (nan if the cases do
        not determine them), rows (cases used), published_exponent, published_stderr,
        combined_errors (the difference by the root of the sum of both squared errors) and verdict:
        `AGREES` if it is at most `COMBINED_ERRORS`, `DIFFERS`, or `UNKNOWN`.
    """
    used = (dataset["particle_velocity_y"].abs() > LEAST_SPEED) & (dataset[target] > 0.0)
    rows = dataset[used]
    fit = wear_exponents(rows, rows[target].to_numpy(dtype=float), setup, full=True)
    own = fit.set_index("quantity").astype(float).reindex(list(PUBLISHED))
    published = pd.DataFrame(PUBLISHED.values(), index=own.index)
    errors = np.hypot(own["exponent_stderr"], published["stderr"])
    apart = (own["exponent"] - published["exponent"]).abs() / errors
    return pd.DataFrame(
        {
            "quantity": list(PUBLISHED),
            "exponent": own["exponent"].to_numpy(),
            "exponent_stderr": own["exponent_stderr"].to_numpy(),
            "rows": len(rows),
            "published_exponent": published["exponent"].to_numpy(),
            "published_stderr": published["stderr"].to_numpy(),
            "combined_errors": apart.to_numpy(),
            "verdict": np.where(
                apart.isna(), UNKNOWN, np.where(apart <= COMBINED_ERRORS, AGREES, DIFFERS)
            ).astype(object),
        }
    )
