"""`abradem predict --map`: a table or a picture of the predicted wear map, or one line."""

import numpy as np
import pytest
from flat_maps import JET, flat_parts
from flat_surrogate import write_flat_surrogate

from abradem.cli.main import main
from abradem.learning.model_files import write_model
from abradem.quantities import SAMPLED
from abradem.store.tables import read_table, read_units
from abradem.surrogate.groups import wear_scale

VALUES = {row.name: float(np.mean(row.paper_range)) for row in SAMPLED}
GIVEN = [f"{name}={value!r}" for name, value in VALUES.items()]


@pytest.fixture
def models(tmp_path):
    """A folder with a surrogate and a map surrogate of even maps."""
    write_flat_surrogate(tmp_path / "surrogate", JET)
    write_model(*flat_parts(), tmp_path / "wear_maps.json")
    return tmp_path


def predict(models, *options):
    return main(["predict", *GIVEN, "--model", str(models / "surrogate"), *options])


def test_the_table_holds_the_depth_rate_of_every_element(models, capsys):
    assert predict(models, "--map", str(models / "map.parquet")) == 0
    table = read_table(models / "map.parquet")
    rate = 0.02 * wear_scale(VALUES, JET)
    np.testing.assert_allclose(table["depth_rate"], rate, rtol=1e-12)
    np.testing.assert_allclose(table["x"], np.repeat([-100.0, 0.0, 100.0], 2), atol=1e-9)
    assert read_units(models / "map.parquet") == {"x": "mm", "z": "mm", "depth_rate": "mm/s"}
    printed = capsys.readouterr().out
    assert f"wear map (friction), mean {rate:.4g} mm/s" in printed


def test_the_picture_is_drawn(models):
    from matplotlib.image import imread

    assert predict(models, "--map", str(models / "map.png")) == 0
    assert np.ptp(imread(models / "map.png")[:, :, 0]) > 0.5


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--map", "map.txt"], "--map map.txt: the name must end in one of .png, .pdf, .svg"),
        (
            ["--map", "map.png", "--table", "cases.csv"],
            "--map is for a single prediction",
        ),
    ],
)
def test_a_map_that_cannot_be_made_is_one_line(models, capsys, options, line):
    assert predict(models, *options) == 2
    said = capsys.readouterr().err
    assert said.startswith(line) and said.count("\n") == 1


def test_a_study_without_maps_is_one_line(models, capsys):
    (models / "wear_maps.json").unlink()
    assert predict(models, "--map", str(models / "map.png")) == 2
    assert "a table, which holds no maps" in capsys.readouterr().err


def test_the_map_is_scaled_to_the_mean_that_the_surrogate_predicts(tmp_path):
    # Wear number 0.02 of the surrogate, 0.03 of the map surrogate.
    write_flat_surrogate(tmp_path / "surrogate", JET, "wear_friction_mean")
    description, arrays = flat_parts()
    arrays["coefficients"][0, 0] = np.log(0.03)
    write_model(description, arrays, tmp_path / "wear_maps.json")
    assert predict(tmp_path, "--map", str(tmp_path / "map.csv")) == 0
    rates = np.loadtxt(tmp_path / "map.csv", delimiter=",", skiprows=1)[:, 2]
    np.testing.assert_allclose(rates, 0.02 * wear_scale(VALUES, JET), rtol=1e-6)
