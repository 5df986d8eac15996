"""Part 6: the steady-state study of the paper.

The plate angle is varied at a factory angle of 45 deg, and the factory angle at a plate angle of
45 deg; particles start at rest, W = 1e-10 /Pa. The sampled factory angles are -90 to 0 deg, which
does not include +45 deg, so both signs are simulated. The tilt of the patch does not rotate the
velocity but spreads the fall heights: for a plate that rises along +x (positive plate angles), the
particles above its upper half start higher at +45 deg and lower at -45 deg.
"""

from __future__ import annotations

import itertools

import numpy as np
import pandas as pd
from scipy import stats

from abradem.verification.checks import Check, checks_table
from abradem.verification.jets import JET, jet_case, rate_of, run_jet
from abradem.wear.rates import straightness

PART = 6
ARCHARD_CONSTANT = 1e-10
PLATE_ANGLES = (0.0, 10.0, 20.0, 30.0, 40.0, 45.0, 50.0, 60.0, 70.0)
FACTORY_ANGLES = (-90.0, -75.0, -60.0, -45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0)
GOOD_R2 = 0.98
_DURATION = 30.0
_MM = 1e3


def cases() -> list[tuple[str, float, float]]:
    """Return (scene, plate angle, factory angle) of every run; angles in deg."""
    plate = [
        (f"plate angle varied, factory {factory:+g} deg", angle, factory)
        for factory, angle in itertools.product((45.0, -45.0), PLATE_ANGLES)
    ]
    factory = [("factory angle varied, plate 45 deg", 45.0, angle) for angle in FACTORY_ANGLES]
    return plate + factory


def runs() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the rates of all runs, and the wear depth over time."""
    rates, series, known = [], [], {}
    setup = JET.setup(duration=_DURATION, sample_interval=0.1)
    depth = ARCHARD_CONSTANT * _MM / setup.plate_area
    for scene, plate, factory in cases():
        if (plate, factory) not in known:
            case = jet_case(plate_angle=plate, factory_angle=factory, particle_velocity_y=0.0)
            known[plate, factory] = run_jet(case, setup)
        result = known[plate, factory]
        rate = rate_of(result)
        steady = result.time >= rate.start
        r2 = straightness(result.time[steady], result.worn[steady, 0])
        place = {"scene": scene, "plate_angle": plate, "factory_angle": factory}
        rates.append(
            place
            | {"depth_rate": rate.value * depth, "depth_stderr": rate.stderr * depth, "r2": r2}
        )
        series.append(
            pd.DataFrame({"time": result.time, "depth": result.worn[:, 0] * depth}).assign(**place)
        )
    return pd.DataFrame(rates), pd.concat(series, ignore_index=True)


def checks(rates: pd.DataFrame) -> list[Check]:
    """Return checks that R2 is above 0.98 and that the rate is not linear in the angle."""
    found = []
    for scene, part in rates.groupby("scene", sort=False):
        found.append(
            Check(f"{scene}: least R2 of depth against time", part["r2"].min(), GOOD_R2,
                  kind="at least", note="of the steady part; it describes, it does not judge")
        )  # fmt: skip
        angle = part["plate_angle"] if "plate angle varied" in scene else part["factory_angle"]
        line = np.polyfit(angle, part["depth_rate"], 1, w=1.0 / part["depth_stderr"])
        residual = (part["depth_rate"] - np.polyval(line, angle)) / part["depth_stderr"]
        freedom = len(part) - 2
        chi2 = float((residual**2).sum() / freedom)
        chance = float(stats.chi2.ppf(0.999, freedom)) / freedom
        found.append(
            Check(f"{scene}: chi2 per freedom of a straight line of slope against angle", chi2,
                  chance, kind="at least",
                  note="not linear: a straight line stays below the bound in 99.9 % of studies")
        )  # fmt: skip
    return found


def study() -> dict[str, pd.DataFrame]:
    """Return the tables of this part."""
    rates, series = runs()
    return {"checks": checks_table(PART, checks(rates)), "rates": rates, "series": series}
