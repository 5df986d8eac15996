"""Part 8: exponents of trends in dilute jets.

Wear per unit mass is proportional to the square of the impact speed. Without gravity this is the
release speed v; with a fall height H the square is v^2 + 2 g H. The plate is small, so that almost
all impacts are first impacts. The wear does not depend on the mass of a particle at a fixed mass
rate and is proportional to it at a fixed number rate. A common factor on all moduli has no effect.
Replicates differ in the seed; an exponent is fitted to each.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd

from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import JET, run_jet, spread
from abradem.verification.scenes import solid
from abradem.verification.time_step import LARGEST_BIAS

PART = 8
REPLICATES = 8
_FACTORS = (1.0, 2.0, 4.0)
_DURATION = 20.0
_PLATE_ANGLE = 55.0
_GRAVITY = 9.81
_HEIGHT = 0.25 - JET.radius / math.cos(math.radians(_PLATE_ANGLE))
"""Mean fall height, m: the centre of a touching particle is R / cos phi above the plate."""


def _setup(**changes):
    base = {
        "mass_rate": None, "number_rate": 8.0, "duration": _DURATION, "sample_interval": 0.1,
        "time_step_fraction": 0.1, "plate_length": 0.15, "plate_width": 0.15,
        "patch_length": 0.04, "patch_width": 0.04,
    }  # fmt: skip
    return JET.setup(**(base | changes))


def _stiffer(factor: float):
    particle, plate = JET.particle, JET.plate
    return replace(
        JET,
        particle=replace(particle, shear_modulus=factor * particle.shear_modulus),
        plate=replace(plate, shear_modulus=factor * plate.shear_modulus),
    )


def _denser(factor: float):
    density = 1000.0 * factor
    return replace(JET, particle=solid(10e9, 0.25, density))


def _case(scene, seed: int, **changes):
    return scene.case(
        plate_angle=_PLATE_ANGLE, seed=seed, **({"particle_velocity_y": -3.0} | changes)
    )


def _per_mass(result) -> float:
    """Return ``total`` per mass delivered, J/kg."""
    return result.worn[-1, 0] / (result.delivered_mass[-1])


def _rate(result) -> float:
    return result.worn[-1, 0] / result.simulated_time


def measurements() -> pd.DataFrame:
    """Return the wear for changes of each quantity, one row per replicate and factor.

    ``factor`` is the value, or the factor of change, of the quantity whose exponent is fitted.
    """
    mass_rate = 8.0 * jet_mass(1.0)
    rows = []
    for seed in range(REPLICATES):
        for factor in _FACTORS:
            speed = 2.0 * factor
            still = run_jet(_case(JET, seed, particle_velocity_y=-speed), _setup(gravity=1e-9))
            rows.append(("speed, gravity off", factor, seed, _per_mass(still)))
            fallen = run_jet(_case(JET, seed, particle_velocity_y=-speed), _setup())
            effective = math.sqrt(speed**2 + 2.0 * _GRAVITY * _HEIGHT)
            rows.append(("speed with v^2 + 2 g H", effective, seed, _per_mass(fallen)))
            scene = _denser(factor)
            rows.append(
                (
                    "mass, fixed number rate",
                    factor,
                    seed,
                    _rate(run_jet(_case(scene, seed), _setup())),
                )
            )
            setup = _setup(mass_rate=mass_rate, number_rate=None)
            rows.append(
                ("mass, fixed mass rate", factor, seed, _rate(run_jet(_case(scene, seed), setup)))
            )
            scene = _stiffer(factor)
            rows.append(("all moduli", factor, seed, _rate(run_jet(_case(scene, seed), _setup()))))
    return pd.DataFrame(rows, columns=["quantity", "factor", "replicate", "value"])


def jet_mass(factor: float) -> float:
    """Return the mass of a particle of the density series, kg."""
    return _denser(factor).mass


EXPECTED = {
    "speed, gravity off": 2.0, "speed with v^2 + 2 g H": 2.0, "mass, fixed number rate": 1.0,
    "mass, fixed mass rate": 0.0, "all moduli": 0.0,
}  # fmt: skip

SYSTEMATIC = 2.0 * LARGEST_BIAS / math.log(_FACTORS[-1] / _FACTORS[0])
"""Error of an exponent if the time step biases the wear at both ends of the range, in opposite
directions, by the largest bias that `time_step` allows."""


def exponents(measurements: pd.DataFrame) -> pd.DataFrame:
    """Return the mean exponent over the replicates and its standard error."""
    rows = []
    for quantity, part in measurements.groupby("quantity", sort=False):
        slopes = [
            np.polyfit(np.log(one["factor"]), np.log(one["value"]), 1)[0]
            for _, one in part.groupby("replicate")
        ]
        mean, error = spread(slopes)
        rows.append(
            {"quantity": quantity, "exponent": mean, "exponent_stderr": error,
             "expected": EXPECTED[quantity]}
        )  # fmt: skip
    return pd.DataFrame(rows)


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    values = measurements()
    table = exponents(values)
    checks = [
        Check(f"exponent of {row.quantity}", row.exponent, row.expected,
              SYSTEMATIC + 2.0 * row.exponent_stderr, kind="absolute",
              note=f"standard error {row.exponent_stderr:.2g}")
        for row in table.itertuples()
    ]  # fmt: skip
    return {"checks": checks_table(PART, checks), "measurements": values, "exponents": table}
