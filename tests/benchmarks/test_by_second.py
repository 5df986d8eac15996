"""Cost of each simulated second: the table, and releases kept in a file."""

from dataclasses import replace

import by_second
import numpy as np
import pytest
from speed import Scenario, particle

from abradem.dem import Setup

SHORT = Setup(
    plate_length=0.2, plate_width=0.2, patch_length=0.05, patch_width=0.05, fall_height=0.05,
    mass_rate=None, number_rate=300.0, duration=0.08,
)  # fmt: skip


def test_table_has_the_cost_of_a_particle_and_step_and_the_ratio_to_this_engine():
    # A million steps in each second.
    lines = by_second.table(
        {
            "abradem": np.array([[1.0, 100.0], [3.0, 300.0]]),
            "other": np.array([[4.0, 100.0], [6.0, 200.0]]),
        },
        1e-6,
    )
    assert list(lines.index) == ["1", "2", "all"]
    np.testing.assert_allclose(lines["abradem, s"], [1.0, 3.0, 4.0])
    np.testing.assert_allclose(lines["abradem, ns"], [10.0, 10.0, 10.0])
    np.testing.assert_allclose(lines["other, ns"], [40.0, 30.0, 10e9 / (150.0 * 2e6)])
    np.testing.assert_allclose(lines["other, ratio"], [4.0, 2.0, 2.5])


def test_releases_in_a_file_are_taken_from_it(tmp_path):
    scenario = Scenario(particle(0.01, 0.0), SHORT, "", 1.0, 1.0)
    path = tmp_path / "jet.npz"
    made = by_second.kept_pour(path, scenario, SHORT)
    kept = by_second.kept_pour(path, scenario, SHORT)
    assert made.step.size > 10
    assert kept.end == made.end
    for name in ("step", "place", "velocity", "present", "energy", "low", "high"):
        np.testing.assert_array_equal(getattr(kept, name), getattr(made, name))
    with pytest.raises(SystemExit, match="this one has"):
        by_second.kept_pour(path, scenario, replace(SHORT, duration=0.2))


def test_each_second_of_this_engine_is_timed():
    scenario = Scenario(particle(0.01, 0.0), SHORT, "", 1.0, 1.0)
    poured = by_second.pour(scenario.case, SHORT)
    seconds = by_second.ours(scenario, SHORT, poured)
    assert seconds.shape == (1, 2)
    assert seconds[0, 0] > 0.0
    assert seconds[0, 1] == pytest.approx(poured.present.mean())
