"""The filled screw: rates of its parts from sums by cell, and checks from numbers."""

import numpy as np
import pandas as pd
import pytest

from abradem.verification import conveyor


def test_rates_of_a_part_are_means_over_its_area_and_over_what_was_worn():
    """Three cells of 1, 1 and 2 m2, the last never worn; J for W = 1 /Pa to mm/s at 1e-11 /Pa."""
    area = np.array([1.0, 1.0, 2.0])
    worn = np.array([[1.0, 3.0, 0.0], [3.0, 5.0, 0.0]])
    unit = conveyor.ARCHARD_CONSTANT * 1e3 / conveyor.TURN
    found = conveyor.part_rates(worn, area)
    # Of the two revolutions: 4 and 8 J on 4 m2, 4 and 8 J on 2 m2, 3 and 5 J on 1 m2.
    assert found["mean"] == pytest.approx((1.5 * unit, 0.5 * unit))
    assert found["worn cells"] == pytest.approx((3.0 * unit, 1.0 * unit))
    assert found["99th percentile"] == pytest.approx((4.0 * unit, 1.0 * unit))


def test_the_screw_turns_in_a_trough_at_rest_and_is_not_full_by_its_feed():
    setup = conveyor.screw_setup()
    surface = setup.surface
    spin = dict(zip(surface.part_names, surface.angular_velocity, strict=True))
    assert spin["trough"] == 0.0
    assert spin["flight"] == spin["shaft"] == pytest.approx(2.0 * np.pi / conveyor.TURN)
    size = conveyor.SCREW
    section = np.pi * (size["radius"] ** 2 - size["shaft_radius"] ** 2)
    most = section * size["pitch"] / conveyor.TURN * 0.6 * conveyor.CONVEYOR.particle.density
    assert 0.15 < conveyor.FEED / most < 0.45
    assert conveyor.screw_setup(turns=2).duration == 2 * conveyor.TURN


def test_a_screw_that_still_fills_fails_its_check():
    found = pd.DataFrame(
        {"part": "flight", "statistic": ["mean", "worn cells", "99th percentile"],
         "depth_rate": 5e-7, "depth_stderr": 1e-8, "filling": 0.3, "throughput": 0.7,
         "drift": 0.2}
    )  # fmt: skip
    verdicts = {check.law: check.holds for check in conveyor.screw_checks(found)}
    assert not verdicts["filled screw: throughput over feed"]
    assert not verdicts["filled screw: drift of the filling"]
    judged = [law for law in verdicts if "flight" in law]
    assert len(judged) == 1 and verdicts[judged[0]]
    far = conveyor.screw_checks(found.assign(depth_rate=5e-8))
    assert not far[-1].holds
