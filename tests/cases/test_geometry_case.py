"""A case on a geometry, from the description to rates, cells and files."""

import numpy as np
import pandas as pd
import pytest

import abradem
from abradem.cli.main import main
from abradem.geometry.mesh_files import write_stl
from abradem.geometry.shapes import Rectangle, plates
from abradem.store.tables import read_table

pytestmark = pytest.mark.slow

CASE = abradem.Case(
    particle_shear_modulus=2e7,
    particle_radius=0.02,
    particle_velocity_y=-2.0,
    plate_angle=40.0,
    # The patch of a geometry is level.
    factory_angle=0.0,
    static_friction=0.4,
)
OPTIONS = {
    "facet_size": 0.05,
    "patch_length": 0.1,
    "patch_width": 0.1,
    "mass_rate": 4.0,
    "window": 0.5,
    "max_time": 1.5,
    "sample_interval": 0.01,
    "target_stderr": 1.0,
    "time_step_fraction": 0.1,
}
ONE_PLATE = {"kind": "plates", "plates": [{"length": 0.3, "width": 0.3, "angle": "plate_angle"}]}


@pytest.fixture(scope="module")
def result():
    return abradem.simulate(CASE, abradem.Setup(geometry=ONE_PLATE, **OPTIONS))


def test_a_chain_of_one_plate_wears_as_the_plate(result):
    """The same particles fall on the same rectangle; only the cells differ."""
    plate = abradem.simulate(CASE, abradem.Setup(**OPTIONS))
    assert result.released == plate.released
    assert result.worn[-1] == pytest.approx(plate.worn[-1], rel=1e-6)
    assert result.wear_rate("friction").rate == pytest.approx(
        plate.wear_rate("friction").rate, rel=1e-6
    )


def test_cells_add_up_to_the_plate(result):
    cells = result.cells()
    assert cells["cell_area"].sum() == pytest.approx(0.09)
    window = result.window[1] - result.window[0]
    rate = (cells["depth_rate_total"] * cells["cell_area"]).sum() / cells["cell_area"].sum()
    worn = result.facet_wear[0].sum()
    assert rate == pytest.approx(1e3 * CASE.archard_constant * worn / (0.09 * window))
    assert cells["impacts"].sum() > 0
    hit = cells[cells["impacts"] > 0]
    assert hit["impact_angle"].between(0.0, 90.0).all() and (hit["impact_speed"] > 0.0).all()
    with pytest.raises(ValueError, match="see cells"):
        result.wear_map()


def test_the_series_of_a_geometry_is_over_its_area(result):
    depth = result.series()["depth_total"].iloc[-1]
    assert depth == pytest.approx(1e3 * CASE.archard_constant * result.worn[-1, 0] / 0.09)


def test_the_command_writes_map_cells_and_a_file_for_paraview(tmp_path, capsys):
    write_stl(plates([Rectangle(0.3, 0.3, 40.0)], 0.05), tmp_path / "plate.stl")
    sets = [
        f"--set={name}"
        for name in (
            "facet_size_mm=50", "patch_length_mm=100", "patch_width_mm=100", "mass_rate_kg_s=4",
            "window_s=0.5", "max_time_s=1.5", "stop.sample_interval_s=0.01", "fall_height_mm=250",
            "unplaced=wait", "factory.attempts=100",
            "stop.target_stderr=1", "time_step_rayleigh_fraction=0.1",
        )
    ]  # fmt: skip
    maps = [tmp_path / name for name in ("map.png", "cells.parquet", "cells.csv", "wear.vtp")]
    code = main(
        [
            "simulate", f"--geometry={tmp_path / 'plate.stl'}", "particle_radius=20mm",
            "particle_velocity_y=-2m/s", "particle_shear_modulus=20MPa", *sets,
            *(f"--map={path}" for path in maps),
        ]
    )  # fmt: skip
    assert code == 0, capsys.readouterr().err
    assert "wear depth rate" in capsys.readouterr().out
    cells = read_table(maps[1])
    assert set(cells["part_name"]) == {"plate_1"} or set(cells["part_name"]) == {"plate"}
    assert len(pd.read_csv(maps[2])) == len(cells)
    assert (maps[0]).stat().st_size > 10_000
    text = maps[3].read_text()
    assert f'NumberOfPolys="{len(cells)}"' in text and 'Name="depth_rate_friction"' in text
    assert np.isfinite(cells["depth_rate_friction"]).all()


def test_the_command_tells_a_wrong_unit(tmp_path, capsys):
    write_stl(plates([Rectangle(0.3, 0.3, 40.0)], 0.05), tmp_path / "plate.stl")
    code = main(["simulate", f"--geometry={tmp_path / 'plate.stl'}", "--unit=m"])
    assert code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "300 m large with unit m" in line and "is the unit mm (0.3 m)" in line
