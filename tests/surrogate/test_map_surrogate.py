"""Files of a map surrogate that are missing or wrong are refused in one line."""

import numpy as np
import pytest
from flat_maps import flat_parts

from abradem.learning.model_files import write_model
from abradem.surrogate.maps import MapSurrogate, shapes
from abradem.surrogate.model import PredictionError


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(PredictionError, match=r"wear_maps\.json: there is no such file"):
        MapSurrogate.load(tmp_path / "wear_maps.json")


@pytest.mark.parametrize(
    ("part", "value", "line"),
    [
        ("kind", "surrogate", "kind must be 'wear_maps'"),
        ("groups", ["log_size"], "groups must be log_froude"),
        ("jet", {"gravity": 9.81}, "jet must have fall_height"),
        ("target", {"measure": "depth"}, "target.measure must be one of total, sliding, friction"),
        ("floor", 0.0, "floor must be a positive number"),
        ("plate", {"length": 0.3}, "plate must have a length and a width above 0"),
        ("modes", np.ones((3, 2)), "modes must have shape"),
        ("coefficients", np.zeros((65, 2)), r"coefficients must have shape \(66, 2\)"),
        ("mean_map", np.full((3, 2), np.nan), "mean_map must hold finite numbers"),
        ("group_scale", np.zeros(10), "group_scale must be positive"),
    ],
)
def test_a_wrong_part_is_named(tmp_path, part, value, line):
    description, arrays = flat_parts()
    (arrays if part in arrays else description)[part] = value
    write_model(description, arrays, tmp_path / "wear_maps.json")
    with pytest.raises(PredictionError, match=f"damaged, or no map surrogate .{line}"):
        MapSurrogate.load(tmp_path / "wear_maps.json")


def test_a_shape_has_the_mean_1_and_no_wear_where_it_would_be_negative():
    _, arrays = flat_parts(counts=(1, 2))
    arrays["mean_map"] = np.log([[0.05, 2.1]])
    found = shapes(arrays, np.zeros((1, 1)), 0.1)
    np.testing.assert_allclose(found, [[[0.0, 2.0]]])
    # Nothing above the floor anywhere: even.
    arrays["mean_map"] = np.log([[0.05, 0.05]])
    np.testing.assert_array_equal(shapes(arrays, np.zeros((1, 1)), 0.1), [[[1.0, 1.0]]])
