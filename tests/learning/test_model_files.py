"""Model files: complete, without code, with warnings outside the training ranges."""

import json

import numpy as np
import pytest
from tables import linear_law

from abradem.learning.baselines import linear
from abradem.learning.model_files import load_model, write_model, write_stage
from abradem.store.files import TableError, read_arrays

NAMES = {
    "summary": "linear.json", "summary_arrays": "linear.safetensors",
    **{n: f"{n}.parquet" for n in
       ("coefficients", "residuals", "published", "scores", "predictions")},
}  # fmt: skip


@pytest.fixture
def stored(tmp_path):
    table, options = linear_law(60, 0.2), {"repeats": 2}
    result = linear.fit_linear(table, **options)
    found = linear.train(table, "wear_total_mean", "dataset", **options)
    write_stage({name: tmp_path / file for name, file in NAMES.items()}, **found)
    return result, tmp_path / "linear.json"


def test_a_stored_model_predicts_what_was_fitted(stored):
    result, path = stored
    rows = linear_law(60, 0.2)
    fit = linear.least_squares(
        rows[[f["name"] for f in result.summary["features"]]].to_numpy(),
        rows["wear_total_mean"].to_numpy(),
    )
    x = rows[[f["name"] for f in result.summary["features"]]].to_numpy()
    np.testing.assert_allclose(
        load_model(path).predict(rows), linear.predict_linear(fit, x), rtol=1e-9
    )


def test_rows_outside_the_training_ranges_are_named(stored):
    rows = linear_law(60, 0.2)
    rows.loc[0, "plate_angle"] = 85.0
    with pytest.warns(UserWarning, match="plate_angle: 1 of 60 values lie outside"):
        load_model(stored[1]).predict(rows)


def test_what_is_no_number_is_not_predicted_in_silence(stored):
    rows = linear_law(60, 0.2)
    rows.loc[3, "plate_angle"] = np.nan
    with pytest.warns(UserWarning, match="plate_angle: 1 of 60 values lie outside"):
        assert np.isnan(load_model(stored[1]).predict(rows)[3])


def test_missing_features_are_named(stored):
    with pytest.raises(TableError, match="lack column plate_angle"):
        load_model(stored[1]).predict(linear_law(5).drop(columns="plate_angle"))


def test_the_description_says_what_the_model_needs(stored):
    model = json.loads(stored[1].read_text())
    assert {"features", "target", "dataset_hash", "scores", "protocol", "kind"} <= model.keys()
    feature = model["features"][0]
    assert {"symbol", "name", "unit", "mean", "scale", "training_range"} <= feature.keys()


def test_damaged_or_missing_arrays_are_one_line(stored, tmp_path):
    arrays = tmp_path / "linear.safetensors"
    arrays.write_bytes(arrays.read_bytes()[:20])
    with pytest.raises(TableError, match="truncated, corrupt or not safetensors"):
        read_arrays(arrays)
    arrays.unlink()
    with pytest.raises(TableError, match="no such file"):
        load_model(stored[1])


def test_an_unknown_kind_is_refused(tmp_path):
    write_model({"kind": "spell"}, {"a": np.zeros(2)}, tmp_path / "m.json")
    with pytest.raises(TableError, match="'spell' is unknown"):
        load_model(tmp_path / "m.json")


def test_a_stage_writes_all_its_outputs_or_says_so(tmp_path):
    with pytest.raises(ValueError, match="nothing to write to"):
        write_stage({"one": tmp_path / "a.json", "two": tmp_path / "b.json"}, one={"x": 1})
