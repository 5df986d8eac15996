"""Part 7: the screw-conveyor check of the paper, a test of the order of magnitude only.

Materials and constants follow the paper (Yang et al. 2021). The load on the blade is not known, so
any rate in the range of reasonable loads agrees. A depth rate of 1e-6 mm/s at W = 1e-11 /Pa is
F_n v_t = 100 W per square metre. There are two estimates: a filling that slides along the trough
under its own weight, q = p v, and a jet on an inclined plate.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pandas as pd

from abradem.dem.model import Interaction
from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import rate_of, run_jet
from abradem.verification.scenes import Scene, solid

PART = 7
ARCHARD_CONSTANT = 1e-11
PUBLISHED = 1e-6
"""Published depth rate, mm/s, an order of magnitude."""

CONVEYOR = Scene(
    particle=solid(1e9, 0.3, 1500.0),
    plate=solid(210e9, 0.3, 7800.0),
    radius=0.008,
    interaction=Interaction(0.50, 0.46, 0.05),
)
"""Poisson ratios and rolling friction are not published; 0.3 and 0.05 are assumed."""

PARTICLES = Interaction(0.35, 0.56, 0.05)
_GRAVITY = 9.81
_MM = 1e3


def filling() -> pd.DataFrame:
    """Return the depth rates of sliding fillings for several heights and speeds, mm/s."""
    rows = []
    bulk_density = 0.6 * CONVEYOR.particle.density
    for height, speed in itertools.product((0.05, 0.1, 0.2), (0.05, 0.1, 0.3)):
        load = bulk_density * _GRAVITY * height * speed
        rows.append(
            {"scene": f"filling of {height:g} m at {speed:g} m/s",
             "depth_rate": load * ARCHARD_CONSTANT * _MM, "depth_stderr": 0.0}
        )  # fmt: skip
    return pd.DataFrame(rows)


def jet_rates() -> pd.DataFrame:
    """Return the depth rates of jets on an inclined plate, mm/s."""
    rows = []
    for mass_rate, angle in itertools.product((1.0, 4.0), (25.0, 45.0)):
        setup = CONVEYOR.setup(
            pair_interaction=PARTICLES, mass_rate=mass_rate, fall_height=0.15, duration=2.0,
            sample_interval=0.02,
        )  # fmt: skip
        result = run_jet(CONVEYOR.case(plate_angle=angle, particle_velocity_y=-0.5, seed=1), setup)
        rate = rate_of(result)
        depth = ARCHARD_CONSTANT * _MM / setup.plate_area
        rows.append(
            {"scene": f"jet of {mass_rate:g} kg/s on {angle:g} deg",
             "depth_rate": rate.value * depth, "depth_stderr": rate.stderr * depth}
        )  # fmt: skip
    return pd.DataFrame(rows)


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    rates = pd.concat([filling(), jet_rates()], ignore_index=True)
    low, high = rates["depth_rate"].min(), rates["depth_rate"].max()
    middle = float(np.exp(np.log(rates["depth_rate"]).mean()))
    words = f"band of the assumed loads {low:.2g} to {high:.2g} mm/s"
    checks = [
        Check("screw conveyor: log10 of the depth rate (mm/s), middle of the assumptions",
              math.log10(middle), math.log10(PUBLISHED), 1.0, kind="absolute",
              note=f"{words}; tests the order of magnitude only"),
        Check("screw conveyor: the band holds the published order", float(low <= PUBLISHED <= high),
              1.0, kind="at least", note=words),
    ]  # fmt: skip
    return {"checks": checks_table(PART, checks), "rates": rates}
