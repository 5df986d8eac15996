"""The wear at other places of the plate: planted ratios to the mean come back, with intervals."""

import json

import numpy as np
import pandas as pd
import pytest
from flat_surrogate import write_flat_surrogate
from tables import product_law

import abradem
from abradem.cli.main import main
from abradem.learning.model_files import write_model
from abradem.learning.physical import local_wear as local_wear_module
from abradem.learning.physical.distil import Settings
from abradem.learning.physical.intervals import conformal_of
from abradem.learning.physical.local_wear import (
    SCALING,
    local_targets,
    local_wear,
    with_local_wear,
    with_meaning,
)
from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.store.files import read_arrays, read_json
from abradem.surrogate.groups import Jet
from abradem.surrogate.model import PredictionError, Surrogate
from abradem.surrogate.parts import local_prefix

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
SETTINGS = Settings(points=3000, hidden=(32, 32), epochs=12)
TARGET = "wear_total_mean"
CASE = {row.name: float(np.mean(row.paper_range)) for row in SAMPLED}
WORDS = [f"{name}={value!r}" for name, value in CASE.items()]


def shape(angle):
    """Worst element over mean: the wear is the more concentrated the steeper the plate."""
    return 3.0 * (1.0 + angle / 70.0)


@pytest.fixture(scope="module")
def dataset():
    table = product_law(120, 0.03)
    rng = np.random.default_rng(5)
    scatter = np.exp(0.05 * rng.standard_normal((2, len(table))))
    return table.assign(
        wear_total_footprint=2.0 * table[TARGET],
        wear_total_p99=0.8 * shape(table["plate_angle"]) * table[TARGET] * scatter[0],
        wear_total_max=shape(table["plate_angle"]) * table[TARGET] * scatter[1],
        wear_friction_max=1.0 * table[TARGET],
        wear_total_worn=1.5 * table[TARGET],
    )


@pytest.fixture(scope="module")
def found(dataset):
    return local_wear(dataset, JET, TARGET, settings=SETTINGS, seed=1, element_size=0.03)


@pytest.fixture(scope="module")
def stem(found, tmp_path_factory):
    """A surrogate of constant wear number for the mean, with the learned models of the others."""
    path = tmp_path_factory.mktemp("models") / "surrogate"
    write_flat_surrogate(path, JET, TARGET)
    model = read_json(f"{path}.json"), read_arrays(f"{path}.safetensors")
    model[1].update({key: found.arrays[key] for key in SCALING})
    write_model(*with_local_wear(model, found), f"{path}.json")
    return path


def test_the_measure_of_the_target_at_all_places_but_its_own(dataset):
    assert local_targets(dataset, TARGET) == [
        "wear_total_footprint", "wear_total_p99", "wear_total_max",
    ]  # fmt: skip
    assert local_targets(dataset, "wear_friction_p99") == ["wear_friction_max"]
    dead = dataset.assign(wear_total_max=0.0, wear_total_p99=1.0)
    assert local_targets(dead, TARGET) == ["wear_total_footprint"]


def test_a_planted_ratio_comes_back(dataset, stem):
    values = {name: dataset[name].to_numpy() for name in SAMPLED_NAMES}
    worst, p99 = (abradem.predict(values, stem, target=f"wear_total_{s}") for s in ("max", "p99"))
    ratio = worst.rate / p99.rate / 1.25
    assert np.median(np.abs(ratio - 1.0)) < 0.04
    away = worst.rate / dataset["wear_total_max"] - 1.0
    assert np.median(np.abs(away)) < 0.08


def test_each_place_has_intervals_that_hold(dataset, stem):
    values = {name: dataset[name].to_numpy() for name in SAMPLED_NAMES}
    for name, one in Surrogate.load(stem).predict_all(values, 0.8).items():
        if name != TARGET:
            inside = (one.lower <= dataset[name]) & (dataset[name] <= one.upper)
            # Training rows: at least the nominal level, apart from the networks' own error.
            assert inside.mean() > 0.7 and one.confidence == 0.8


def test_the_error_scale_of_a_place_is_in_its_deviation(dataset, monkeypatch):
    """Three times the scale is three times the width of what the networks learn."""
    only = dataset[[name for name in dataset if name not in ("wear_total_p99", "wear_total_max")]]

    def learned():
        found = local_wear(only, JET, TARGET, settings=SETTINGS, fold_count=2, seed=1)
        prefix = local_prefix("wear_total_footprint")
        names = sorted(name for name in found.arrays if name.startswith(f"{prefix}spread_biases"))
        return found.arrays[names[-1]], found.arrays[f"{prefix}conformal"]

    plain, scores = learned()

    def wider(given, rows, held):
        found = conformal_of(given, rows, held)
        return found._replace(
            scale=found.scale._replace(constant=found.scale.constant + np.log(3.0))
        )

    monkeypatch.setattr(local_wear_module, "conformal_of", wider)
    wide, same = learned()
    # The networks learn a standardised deviation: a factor moves the last bias alone.
    np.testing.assert_allclose(wide - plain, np.log(3.0), rtol=1e-4)
    np.testing.assert_array_equal(scores, same)


def test_groups_that_are_scaled_otherwise_are_refused(found):
    arrays = {key: found.arrays[key] + 1.0 for key in SCALING}
    with pytest.raises(ValueError, match="do not scale the groups in the same way"):
        with_local_wear(({}, arrays), found)


def test_the_description_says_what_each_is_and_how_good(found):
    by_name = {one["target"]["name"]: one for one in found.descriptions}
    assert by_name["wear_total_max"]["target"]["element_size"] == 0.03
    for one in by_name.values():
        assert one["held_out"]["R2"] > 0.9 and one["distillation_error"]["rms"] < 0.1
        assert one["training_rows"] == 120


def test_the_mean_has_no_elements(dataset):
    means = dataset.rename(columns={"wear_total_max": "x"})
    tiny = Settings(points=50, hidden=(4,), epochs=1)
    few = local_wear(means.head(30), JET, "wear_total_p99", settings=tiny, element_size=0.03)
    by_name = {one["target"]["name"]: one["target"] for one in few.descriptions}
    assert "element_size" not in by_name[TARGET]
    assert by_name["wear_total_footprint"]["element_size"] == 0.03


def test_the_command_gives_all_places_and_the_hours_of_each(capsys, stem):
    assert main(["predict", "--model", str(stem), *WORDS, "--depth", "5mm"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 8
    for name, rate, hours in zip(Surrogate.load(stem).models, lines[:4], lines[4:], strict=True):
        found = abradem.predict(CASE, stem, target=name)
        assert rate.startswith(f"wear depth rate {found.rate[0]:.4g} mm/s, 95 % interval ")
        assert f"({name}: " in rate
        assert hours.startswith(f"5 mm after {found.hours_to(5.0)[0][0]:.4g} h, ")
    assert "worst 30 mm element" in lines[3]
    assert "single places" not in lines[7] and "single places are worn deeper" in lines[4]


def test_a_table_has_the_columns_of_all_places(stem, tmp_path):
    pd.DataFrame([CASE, {**CASE, "plate_angle": 20.0}]).to_csv(tmp_path / "t.csv", index=False)
    arguments = ["--table", str(tmp_path / "t.csv"), "--output", str(tmp_path / "o.csv")]
    assert main(["predict", "--model", str(stem), *arguments, "--depth", "2mm"]) == 0
    table = pd.read_csv(tmp_path / "o.csv")
    expected = abradem.predict({**CASE, "plate_angle": 20.0}, stem, target="wear_total_max")
    assert table["wear_depth_rate_max [mm/s]"][1] == pytest.approx(expected.rate[0])
    assert table["hours_max_lower [h]"][1] == pytest.approx(expected.hours_to(2.0)[1][0])
    assert "wear_depth_rate [mm/s]" in table and "hours_footprint_upper [h]" in table


def test_a_place_that_is_not_held_and_a_damaged_one_are_one_line(stem, tmp_path):
    with pytest.raises(PredictionError, match="'wear_total_worn': this surrogate predicts wear_t"):
        abradem.predict(CASE, stem, target="wear_total_worn")
    description, arrays = read_json(f"{stem}.json"), read_arrays(f"{stem}.safetensors")
    less = {key: array for key, array in arrays.items() if "max.conformal" not in key}
    write_model(description, less, tmp_path / "a.json")
    with pytest.raises(PredictionError, match=r"local\.wear_total_max\.conformal is missing"):
        Surrogate.load(tmp_path / "a")
    broken = json.loads(json.dumps(description))
    broken["local"][0]["target"]["unit"] = "m/s"
    write_model(broken, arrays, tmp_path / "b.json")
    with pytest.raises(PredictionError, match=r"local\[0\]\.target\.unit = 'm/s' must be"):
        Surrogate.load(tmp_path / "b")
    twice = json.loads(json.dumps(description))
    twice["local"][0]["target"]["name"] = TARGET
    write_model(twice, arrays, tmp_path / "c.json")
    with pytest.raises(PredictionError, match="wear_total_mean is the target twice"):
        Surrogate.load(tmp_path / "c")


def test_no_place_is_below_one_that_it_cannot_be_below(stem, tmp_path):
    """By definition the worst element is worn at least as much as the 99th percentile."""
    surrogate = Surrogate.load(stem)
    assert surrogate.models["wear_total_max"].at_least == "wear_total_p99"
    assert surrogate.models["wear_total_footprint"].at_least == TARGET
    description, arrays = read_json(f"{stem}.json"), read_arrays(f"{stem}.safetensors")
    arrays["local.wear_total_max.mean_biases_2"] -= 9.0
    write_model(description, arrays, tmp_path / "a.json")
    found = Surrogate.load(tmp_path / "a").predict_all(CASE)
    worst, p99 = found["wear_total_max"], found["wear_total_p99"]
    assert worst.rate[0] == p99.rate[0] and worst.upper[0] > worst.rate[0] > worst.lower[0]
    description["local"][0]["at_least"] = "wear_total_worn"
    write_model(description, arrays, tmp_path / "b.json")
    with pytest.raises(PredictionError, match="at_least = 'wear_total_worn' of wear_total_footpr"):
        Surrogate.load(tmp_path / "b")


@pytest.mark.parametrize(
    ("contacts", "told"),
    [
        (None, {}),
        ({"pair_interaction": None}, {"pair_interaction": None}),
        ({"pair_interaction": {"restitution": 0.5}}, {"pair_interaction": {"restitution": 0.5}}),
    ],
)
def test_a_surrogate_tells_how_particles_meet_where_it_is_known(stem, contacts, told):
    model = read_json(f"{stem}.json"), read_arrays(f"{stem}.safetensors")
    description, _ = with_meaning(model, True, True, contacts=contacts)
    assert {key: description[key] for key in ("pair_interaction",) if key in description} == told


def test_what_is_not_known_of_a_table_is_not_named(capsys, stem, tmp_path):
    model = read_json(f"{stem}.json"), read_arrays(f"{stem}.safetensors")
    write_model(*with_meaning(model, False, False), tmp_path / "a.json")
    assert main(["predict", "--model", str(tmp_path / "a"), *WORDS, "--depth", "5mm"]) == 0
    out, err = capsys.readouterr()
    assert "(wear_total_mean: as in the table that the model learned from)" in out
    assert "(wear_total_max: as in the table that the model learned from)" in out
    assert not any(words in out for words in ("over the plate", "worst", "footprint of"))
    assert "jet of the table behind the model" in err
    write_model(*with_meaning(model, True, True), tmp_path / "a.json")
    assert main(["predict", "--model", str(tmp_path / "a"), *WORDS]) == 0
    out, err = capsys.readouterr()
    assert "(wear_total_mean: mean over the plate)" in out and err == ""
