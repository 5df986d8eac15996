"""Short simulations for figures of the plate and factory angles."""

from pathlib import Path

import numpy as np
import pytest

from abradem.config import ConfigError, load_config, typical_case
from abradem.dem.model import Setup
from abradem.quantities import WEAR_MEASURES
from abradem.simulation.snapshots import write_scene
from abradem.store.tables import read_table
from abradem.wear.angles import depth_by_angle
from abradem.wear.depths import depth_frames

ROOT = Path(__file__).parents[2]
CASE = typical_case(load_config({"study": "x"})) | {"particle_radius": 0.02}
SETUP = Setup(facet_size=0.05)


def test_a_particle_of_the_pictures_that_is_wider_than_the_plate_is_one_line():
    values = {
        "study": "x",
        "simulation": {"plate": {"length_mm": 150.0}},
        "sampling": {"ranges": {"particle_radius_mm": 10.0}},
        "figures": {"typical": {"particle_radius_mm": 80.0}},
    }
    with pytest.raises(ConfigError, match=r"figures\.typical\.particle_radius_mm: 80\.0: .* 75 mm"):
        load_config(values)


@pytest.mark.parametrize("measure", WEAR_MEASURES)
def test_depth_by_angle_varies_one_angle_and_holds_the_other(measure):
    from abradem import Case, simulate

    angles = {"plate_angle": [30.0, 60.0], "factory_angle": [0.0]}
    curves, rates = depth_by_angle(CASE, SETUP, angles, 2.0, measure)
    assert rates["angle"].tolist() == [30.0, 60.0, 0.0]
    alone = simulate(Case(**{**CASE, "factory_angle": 0.0}), Setup(facet_size=0.05, duration=2.0))
    mine = curves[curves["varied"] == "factory_angle"]
    worn = dict(zip(("total", "sliding", "friction"), alone.worn.T, strict=True))[measure]
    depth = 1e3 * CASE["archard_constant"] / SETUP.plate_area * worn
    np.testing.assert_array_equal(mine["wear_depth"], depth)
    for row in rates.itertuples():
        curve = curves[(curves["varied"] == row.varied) & (curves["angle"] == row.angle)]
        assert curve["wear_depth"].is_monotonic_increasing
        assert row.rate == pytest.approx(curve["wear_depth"].iloc[-1] / 2.0, rel=0.3)


@pytest.mark.parametrize("measure", WEAR_MEASURES)
def test_a_depth_of_the_frames_is_the_plate_mean_of_the_series(tmp_path, measure):
    write_scene(CASE, SETUP, tmp_path, 1.0, 0.25)
    wear = read_table(tmp_path / "wear.parquet")
    times, depth = depth_frames(wear, CASE, SETUP, measure)
    assert depth.shape == (len(times), *SETUP.facets) and times[0] == 0.0
    worn = wear.groupby("time")[f"wear_{measure}"].sum()
    mean = 1e3 * CASE["archard_constant"] / SETUP.plate_area * worn
    np.testing.assert_allclose(depth.mean(axis=(1, 2)), mean, rtol=1e-12)
