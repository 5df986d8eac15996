"""Exponents of the quantities in a wear rate, by least squares of its logarithm."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

MODULI = ("particle_shear_modulus", "equipment_shear_modulus")
"""Further quantities of `wear_exponents`, on which the wear of a dilute jet does not depend."""

SQUARED_ANGLE = "plate_angle_squared"


def wear_exponents(
    rows: pd.DataFrame, wear: np.ndarray, setup: Mapping, full: bool = False
) -> pd.DataFrame:
    """Exponents of the quantities in a wear rate, by least squares of its logarithm.

    ``ln y = a + sum b ln x + c phi / 70 deg + d theta / 90 deg``, with x the Archard constant, the
    radius, the density, v^2 + 2 g H, the friction and 1 + e. Quantities that do not vary are left
    out.

    Parameters
    ----------
    rows : pandas.DataFrame
        The sampled quantities, n rows.
    wear : ndarray, shape (n,)
        Positive.
    setup : mapping
        Plain values of the `Setup`, for the fall height H of each case.
    full : bool
        Also with ``(phi / 70 deg)^2`` and the logarithms of `MODULI`.

    Returns
    -------
    pandas.DataFrame
        quantity, exponent, exponent_stderr. Empty if there are too few rows.
    """
    none = pd.DataFrame(columns=["quantity", "exponent", "exponent_stderr"])
    if rows.empty:
        return none
    terms = design(rows, setup, full)
    varied = [name for name in terms if np.ptp(terms[name]) > 1e-9 * np.abs(terms[name]).max()]
    x = np.column_stack([np.ones(len(rows)), *(terms[name] for name in varied)])
    freedom = len(rows) - x.shape[1]
    if freedom < 1 or np.linalg.matrix_rank(x) < x.shape[1]:
        return none
    solution, *_ = np.linalg.lstsq(x, np.log(wear), rcond=None)
    residual = np.log(wear) - x @ solution
    covariance = np.linalg.inv(x.T @ x) * float(residual @ residual) / freedom
    return pd.DataFrame(
        {
            "quantity": varied,
            "exponent": solution[1:],
            "exponent_stderr": np.sqrt(np.diag(covariance))[1:],
        }
    )


def design(rows: pd.DataFrame, setup: Mapping, full: bool = False) -> dict[str, np.ndarray]:
    """Return the terms of `wear_exponents` by name, each of shape (n,)."""
    from abradem.dem.model import Setup

    built = Setup.from_dict(setup)
    height = np.array([built.patch_place(angle)[0] for angle in rows["factory_angle"]])
    speed = rows["particle_velocity_y"].to_numpy(dtype=float) ** 2 + 2.0 * built.gravity * height
    positive = {
        "archard_constant": rows["archard_constant"],
        "particle_radius": rows["particle_radius"],
        "particle_density": rows["particle_density"],
        "impact_speed": speed,
        "static_friction": rows["static_friction"],
        "restitution": 1.0 + rows["restitution"],
        **({name: rows[name] for name in MODULI} if full else {}),
    }
    terms = {
        name: np.log(np.asarray(values, dtype=float))
        for name, values in positive.items()
        if (np.asarray(values) > 0.0).all()
    }
    terms["plate_angle"] = rows["plate_angle"].to_numpy(dtype=float) / 70.0
    # Two angles determine a line alone.
    if full and rows["plate_angle"].nunique() > 2:
        terms[SQUARED_ANGLE] = terms["plate_angle"] ** 2
    terms["factory_angle"] = rows["factory_angle"].to_numpy(dtype=float) / 90.0
    return terms
