"""The surrogate: distillation, files without code, few imports, warnings outside its ranges."""

import json
import os
import re
import shutil
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from tables import product_law

import abradem
from abradem.cli.main import main
from abradem.config.materials import PARTICLE_MATERIALS, PLATE_MATERIALS, preset
from abradem.learning.model_files import write_model
from abradem.learning.physical.distil import Settings, distil, evaluate_surrogate, surrogate_of
from abradem.learning.physical.error_scale import fit_scale
from abradem.learning.physical.intervals import Conformal, conformal_of, hold_out_in_turn
from abradem.learning.physical.models import PROCESS, makers
from abradem.learning.physical.problem import problem
from abradem.quantities import SAMPLED, SAMPLED_NAMES, check_value
from abradem.running.outputs import record_outputs
from abradem.store.files import read_arrays, write_arrays
from abradem.surrogate.groups import Jet
from abradem.surrogate.model import PredictionError, Surrogate, conformal_quantile, highest_level
from abradem.units import parse_value

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
SETTINGS = Settings(points=3000, hidden=(32, 32), epochs=12)
CASE = {name: float(np.mean(row.paper_range)) for name, row in zip(SAMPLED_NAMES, SAMPLED,
                                                                  strict=True)}  # fmt: skip
WORDS = [f"{name}={value!r}" for name, value in CASE.items()]


@pytest.fixture(scope="module")
def given():
    table = product_law(150, 0.05)
    return problem(table.assign(wear_total_mean_stderr=0.05 * table["wear_total_mean"]), JET)


@pytest.fixture(scope="module")
def process(given):
    return makers(1)[PROCESS]().fit(given.groups, given.log_number, given.error)


@pytest.fixture(scope="module")
def stem(given, process, tmp_path_factory):
    """Path of the files of a surrogate, without suffix."""
    rows = np.arange(len(given.log_number))
    scores = conformal_of(given, rows, hold_out_in_turn(given, rows))
    results = evaluate_surrogate(given, SETTINGS._replace(epochs=3), repeats=1, seed=1)
    model = surrogate_of(given, process, scores, SETTINGS, results, seed=1)
    path = tmp_path_factory.mktemp("models") / "surrogate"
    write_model(*model, f"{path}.json")
    return path


# Predictions


def test_it_repeats_the_process_it_was_distilled_from(given, process, stem):
    surrogate = Surrogate.load(stem)
    found = surrogate.predict(dict(zip(SAMPLED_NAMES, given.inputs.T, strict=True)))
    expected = given.scale * np.exp(process.predict(given.groups))
    assert np.median(np.abs(found.rate / expected - 1.0)) < 0.03
    assert surrogate.description["distillation_error"]["rms"] < 0.05
    assert "R2" in surrogate.description["scores"]["test"]


def test_intervals_hold_what_they_promise(given, stem):
    values = dict(zip(SAMPLED_NAMES, given.inputs.T, strict=True))
    for level in (0.5, 0.8, 0.95):
        found = abradem.predict(values, stem, level)
        inside = (found.lower <= given.table.target) & (given.table.target <= found.upper)
        # Training rows: the coverage is at least the nominal level.
        assert inside.mean() >= level - 0.08
        assert (found.lower < found.rate).all() and (found.rate < found.upper).all()


def test_a_higher_level_is_a_wider_interval(stem):
    widths = [
        (found.upper - found.lower)[0]
        for found in (abradem.predict(CASE, stem, level) for level in (0.3, 0.6, 0.9))
    ]
    assert widths == sorted(widths) and widths[0] < widths[-1]


def test_wear_is_proportional_to_the_wear_constant(stem):
    twice = {**CASE, "archard_constant": 2.0 * CASE["archard_constant"]}
    one, two = (abradem.predict(values, stem) for values in (CASE, twice))
    for a, b in zip(one[:3], two[:3], strict=True):
        assert b[0] == pytest.approx(2.0 * a[0], rel=1e-6)


def test_many_cases_are_as_one_by_one_and_a_frame_does(stem):
    rng = np.random.default_rng(0)
    frame = pd.DataFrame({row.name: rng.uniform(*row.paper_range, 9000) for row in SAMPLED})
    found = abradem.predict(frame, stem)
    for row in (0, 4095, 4096, 8999):
        alone = abradem.predict(frame.iloc[row].to_dict(), stem)
        assert found.rate[row] == pytest.approx(alone.rate[0], rel=1e-5)
    swept = abradem.predict({**CASE, "plate_angle": np.array([10.0, 20.0])}, stem)
    assert len(swept.rate) == 2


def test_hours_follow_from_depth_and_rate(stem):
    found = abradem.predict(CASE, stem)
    middle, least, most = found.hours_to(5.0)
    assert middle[0] == pytest.approx(5.0 / found.rate[0] / 3600.0)
    assert least[0] < middle[0] < most[0]
    with pytest.raises(PredictionError, match="depth"):
        found.hours_to(0.0)


def test_the_quantile_holds_its_share_of_new_scores():
    rng = np.random.default_rng(0)
    shares = []
    for _ in range(300):
        scores = rng.exponential(size=60)
        quantile = conformal_quantile(np.sort(scores[:59]), 0.9)
        shares.append(scores[59] <= quantile)
    assert 0.85 < np.mean(shares) < 0.95


@pytest.mark.parametrize("count", [1, 2, 9, 12, 19, 99, 200])
def test_no_level_beyond_the_scores_is_promised(count):
    scores = np.arange(float(count))
    highest = highest_level(count)
    assert conformal_quantile(scores, highest) == count - 1
    for level in (highest + 1e-6, 0.99999, 1.0, 0.0):
        with pytest.raises(ValueError, match=f"which {count} scores can promise"):
            conformal_quantile(scores, level)


def test_the_default_level_is_one_that_the_surrogate_can_promise(stem):
    surrogate = Surrogate.load(stem)
    assert surrogate.predict(CASE).confidence == 0.95
    few = Surrogate(surrogate.description, {**read_arrays(f"{stem}.safetensors"),
                                            "conformal": np.arange(12.0)})  # fmt: skip
    assert few.predict(CASE).confidence == few.highest_confidence == 12 / 13
    with pytest.raises(PredictionError, match=r"12 held-out errors, which promise at most 0.9231"):
        few.predict(CASE, 0.95)
    with pytest.raises(PredictionError, match=r"write 0.95 for 95 %"):
        few.predict(CASE, 95)


# Errors and warnings


def test_values_outside_the_training_ranges_warn(stem):
    assert abradem.predict(CASE, stem).warnings == []
    (line,) = abradem.predict({**CASE, "plate_angle": 85.0}, stem).warnings
    assert line.startswith("plate_angle = 85 deg is outside the training range")
    # Exactly proportional, so no warning.
    assert abradem.predict({**CASE, "archard_constant": 1e-12}, stem).warnings == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"restitution": 1.5}, r"restitution = 1.5 is impossible \(allowed 0.05 ... 1\)"),
        ({"particle_radius": -1.0}, "particle_radius = -1 m is impossible"),
        ({"plate_angle": np.nan}, "plate_angle = nan deg is impossible"),
        ({"plate_angle": "steep"}, "plate_angle = 'steep' is not a number"),
        ({"plate_angle": np.array([1.0, 999.0])}, "plate_angle = 999 deg in row 2 is impossible"),
        ({"plate_angle": np.ones(2), "restitution": np.full(3, 0.5)}, "of different length"),
    ],
)  # fmt: skip
def test_impossible_values_are_one_line(stem, change, words):
    with pytest.raises(PredictionError, match=words) as caught:
        abradem.predict({**CASE, **change}, stem)
    assert len(str(caught.value).splitlines()) == 1


def test_what_is_missing_is_named(stem):
    less = {name: value for name, value in CASE.items() if name != "restitution"}
    with pytest.raises(PredictionError, match="missing: restitution"):
        abradem.predict(less, stem)
    with pytest.raises(PredictionError, match="confidence = 1"):
        abradem.predict(CASE, stem, 1.0)


def test_missing_and_damaged_files_are_one_line(stem, tmp_path):
    with pytest.raises(PredictionError, match=r"nowhere.json: there is no such file; run the"):
        Surrogate.load(tmp_path / "nowhere")
    arrays = stem.with_suffix(".safetensors").read_bytes()
    text = stem.with_suffix(".json").read_bytes()
    for content, damaged, words in (
        (text, arrays[: len(arrays) // 2], "a.safetensors: truncated, corrupt or not safetensors"),
        (text, b"", "a.safetensors: truncated, corrupt or not safetensors"),
        (text[:-20], arrays, "a.json: truncated, corrupt or not JSON"),
        (b"[" * 100_000, arrays, "a.json: truncated, corrupt or not JSON"),
        (b"\xff" + text, arrays, "a.json: truncated, corrupt or not JSON"),
        (b"{}", arrays, r"a.json: damaged, or not a surrogate \(kind = None"),
    ):
        (tmp_path / "a.json").write_bytes(content)
        (tmp_path / "a.safetensors").write_bytes(damaged)
        with pytest.raises(PredictionError, match=words) as caught:
            Surrogate.load(tmp_path / "a")
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ((), [1, 2], "the content = [1, 2] must be an object"),
        (("kind",), "network", "kind = 'network' must be 'surrogate'"),
        (("groups",), ["log_froude"], "groups = ['log_froude'] must be"),
        (("groups",), None, "groups = None must be a list"),
        (("target",), "wear", "target = 'wear' must be an object"),
        (("target", "unit"), "m/s", "target.unit = 'm/s' must be 'mm/s'"),
        (("target", "unit"), 3, "target.unit = 3 must be text"),
        (("target", "name"), ..., "target.name is missing"),
        (("target", "element_size"), 0.0, "target.element_size = 0.0 must be positive"),
        (("target", "element_size"), "30", "target.element_size = '30' must be a finite number"),
        (("jet",), [1.0], "jet = [1.0] must be an object"),
        (("jet", "gravity"), ..., "jet has ["),
        (("jet", "gravity"), "9.81", "jet.gravity = '9.81' must be a finite number"),
        (("jet", "gravity"), True, "jet.gravity = True must be a finite number"),
        (("jet", "fall_height"), {"m": 1.0}, "jet.fall_height = {'m': 1.0} must be a finite"),
        (("jet", "fall_height"), -0.25, "jet.fall_height = -0.25 must not be negative"),
        (("jet", "plate_area"), 0.0, "jet.plate_area = 0.0 must be positive"),
        (("jet", "plate_area"), 10**400, "must be a finite number"),
        (("jet", "number_rate"), 5.0, "either mass_rate or number_rate"),
        (("features",), {}, "features = {} must be a list"),
        (("features",), [], "features lack particle_shear_modulus"),
        (("features", 0), None, "features[0] = None must be an object"),
        (("features", 0, "name"), "colour", "features[0].name = 'colour' is no quantity"),
        (("features", 0, "name"), "equipment_shear_modulus", "features lack particle_shear"),
        (("features", 0, "unit"), "GPa", "unit = 'GPa' of particle_shear_modulus must be 'Pa'"),
        (("features", 3, "training_range"), ..., "features[3].training_range is missing"),
        (("features", 3, "training_range"), [1.0], "has 1 numbers, must have 2"),
        (("features", 3, "training_range"), [2.0, 1.0], "is not in order"),
        (("features", 3, "training_range"), [[1.0], 2.0], "must be a finite number"),
    ],
)  # fmt: skip
def test_a_wrong_part_of_the_description_is_one_line(stem, tmp_path, path, value, words):
    description = json.loads(stem.with_suffix(".json").read_text())
    if path:
        parent = description
        for step in path[:-1]:
            parent = parent[step]
        if value is ...:
            del parent[path[-1]]
        else:
            parent[path[-1]] = value
    else:
        description = value
    (tmp_path / "a.json").write_text(json.dumps(description))
    shutil.copy(stem.with_suffix(".safetensors"), tmp_path / "a.safetensors")
    with pytest.raises(PredictionError, match=re.escape(words)) as caught:
        Surrogate.load(tmp_path / "a")
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / 'a.json'}: ") and len(line.splitlines()) == 1


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("group_mean", None, "group_mean is missing"),
        ("group_mean", lambda a: a[:-1], "group_mean has shape (9,), must have (10)"),
        ("group_mean", lambda a: a.reshape(2, 5), "group_mean has shape (2, 5)"),
        ("group_scale", lambda a: a * 0.0, "group_scale must be positive"),
        ("group_scale", lambda a: a.astype(int), "group_scale has type int64"),
        ("conformal", lambda a: a[:0], "conformal must hold scores"),
        ("conformal", lambda a: -a - 1.0, "conformal must hold scores"),
        ("conformal", lambda a: a * np.nan, "conformal has values that are not finite"),
        ("mean_weights_0", None, "mean_weights_0 is missing"),
        ("mean_weights_1", lambda a: a[:-1], "mean_weights_1 has shape (31, 32)"),
        ("mean_weights_2", lambda a: np.repeat(a, 2, axis=1), "mean_biases_2 has shape"),
        ("mean_biases_0", None, "mean_biases_0 is missing"),
        ("spread_biases_0", lambda a: a[:, None], "spread_biases_0 has shape (32, 1)"),
        ("spread_weights_0", lambda a: a * np.inf, "spread_weights_0 has values"),
    ],
)  # fmt: skip
def test_a_wrong_array_is_one_line(stem, tmp_path, name, change, words):
    arrays = read_arrays(stem.with_suffix(".safetensors"))
    changed = arrays.pop(name)
    if change is not None:
        with np.errstate(invalid="ignore"):
            arrays[name] = change(changed)
    write_arrays(arrays, tmp_path / "a.safetensors")
    shutil.copy(stem.with_suffix(".json"), tmp_path / "a.json")
    with pytest.raises(PredictionError, match=re.escape(words)) as caught:
        Surrogate.load(tmp_path / "a")
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / 'a.safetensors'}: ") and len(line.splitlines()) == 1


def test_a_rate_that_is_no_number_is_refused(stem, tmp_path):
    """Finite weights, as a damaged exponent leaves them, of a surrogate without checksums."""
    arrays = read_arrays(stem.with_suffix(".safetensors"))
    for shift in (1e30, -1e30):
        arrays["mean_biases_2"] = np.full_like(arrays["mean_biases_2"], shift)
        write_arrays(arrays, tmp_path / "a.safetensors")
        shutil.copy(stem.with_suffix(".json"), tmp_path / "a.json")
        with pytest.raises(PredictionError, match=r"gives a wear depth rate of (inf|0) mm/s"):
            Surrogate.load(tmp_path / "a").predict(CASE)


def test_a_surrogate_of_a_study_is_compared_with_its_checksum(stem, tmp_path):
    """A flipped bit in the arrays would be read as another number."""
    models = tmp_path / "results" / "a" / "models"
    models.mkdir(parents=True)
    for suffix in (".json", ".safetensors"):
        shutil.copy(stem.with_suffix(suffix), models / f"surrogate{suffix}")
    (models.parent / "config.yaml").write_text("study: a\n")
    record_outputs(models.parent, "surrogate", models.iterdir())
    Surrogate.load(models / "surrogate")
    data = bytearray((models / "surrogate.safetensors").read_bytes())
    data[-3] ^= 1
    (models / "surrogate.safetensors").write_bytes(data)
    with pytest.raises(PredictionError, match="differs from what its job wrote; `abradem doctor"):
        Surrogate.load(models / "surrogate")


def test_the_files_hold_numbers_and_words_alone(stem):
    description = json.loads(stem.with_suffix(".json").read_text())
    assert {"features", "jet", "scores", "dataset_hash", "groups"} <= description.keys()
    assert all({"name", "unit", "training_range"} <= f.keys() for f in description["features"])
    assert b"pickle" not in stem.with_suffix(".safetensors").read_bytes()


@pytest.mark.parametrize("damage", ["cut", "zone", "index"])
def test_parquet_for_predictions_is_read_by_the_one_reader(capsys, stem, tmp_path, damage):
    """Damage and values that pandas cannot hold are one line; a column of an index is a column."""
    path, output = tmp_path / "t.parquet", tmp_path / "o.csv"
    frame = pd.DataFrame([CASE, {**CASE, "plate_angle": 20.0}])
    frame.set_index("plate_angle").to_parquet(path)
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-9])
    if damage == "zone":
        zoned = pa.array([0, 1], pa.timestamp("us", "Mars/Olympus"))
        pq.write_table(pa.Table.from_pandas(frame).append_column("day", zoned), path)
    arguments = ["--model", str(stem), "--table", str(path), "--output", str(output)]
    code = main(["predict", *arguments])
    said = capsys.readouterr()
    if damage == "index":
        assert code == 0 and pd.read_csv(output)["plate_angle"].tolist()[1] == 20.0
    else:
        assert code == 2 and len(said.err.splitlines()) == 1 and not output.exists()
        assert said.err.startswith(f"{path}: ")


# Speed


def processor_time_of_children():
    spent = os.times()
    return spent.children_user + spent.children_system


def test_the_command_is_light_and_quick(stem):
    code = (
        "import sys; from abradem.cli.main import main\n"
        f"code = main(['predict', '--model', {str(stem)!r}, *{WORDS!r}])\n"
        "heavy = {'torch', 'sklearn', 'numba', 'scipy', 'pandas'} & set(sys.modules)\n"
        "sys.exit(code or ', '.join(sorted(heavy)) or 0)"
    )
    seconds = []
    for _ in range(3):
        # Processor time: what else the machine does is not the command's.
        begin = processor_time_of_children()
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        seconds.append(processor_time_of_children() - begin)
        assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("wear depth rate ")
    assert min(seconds) < 1.0


def test_a_prediction_takes_less_than_a_millisecond(stem):
    surrogate = Surrogate.load(stem)
    surrogate.predict(CASE)
    seconds = []
    for _ in range(50):
        begin = time.process_time()
        surrogate.predict(CASE)
        seconds.append(time.process_time() - begin)
    assert np.median(seconds) < 1e-3


# Command line


def run(capsys, *arguments):
    code = main(["predict", *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def test_values_with_units_give_the_same_as_without(capsys, stem):
    others = [w for w in WORDS if not w.startswith(("particle_radius", "particle_shear"))]
    answers = {
        run(capsys, "--model", stem, *others, *words)[1]
        for words in (
            ("particle_radius=0.02", "particle_shear_modulus=6e9"),
            ("particle_radius=20mm", "particle_shear_modulus=6 GPa"),
            ("particle_radius=2 cm", "particle_shear_modulus=6000MPa"),
        )
    }
    (answer,) = answers
    assert "mm/s" in answer and "95 % interval" in answer and "wear_total_mean" in answer


def test_presets_fill_what_is_not_given(capsys, stem):
    rest = ["plate_angle=45deg", "factory_angle=0", "particle_radius=20mm",
            "particle_velocity_y=-5m/s", "archard_constant=1e-9/Pa"]  # fmt: skip
    code, out, _ = run(capsys, "--model", stem, "--material", "limestone", *rest, "--depth", "5mm")
    assert code == 0
    values = {**CASE, **preset("limestone"), "plate_angle": 45.0, "factory_angle": 0.0,
              "particle_radius": 0.02, "particle_velocity_y": -5.0,
              "archard_constant": 1e-9}  # fmt: skip
    found = abradem.predict(values, stem)
    assert out.startswith(f"wear depth rate {found.rate[0]:.4g} mm/s")
    assert out.splitlines()[1].startswith(f"5 mm after {found.hours_to(5.0)[0][0]:.4g} h")


def test_presets_are_possible_and_name_a_source():
    for particle in PARTICLE_MATERIALS:
        values = preset(particle)
        assert not [line for name, v in values.items() if (line := check_value(name, v))]
    materials = (*PARTICLE_MATERIALS.values(), *PLATE_MATERIALS.values())
    assert all(len(one.source) > 20 for one in materials)


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["particle_radius=20 lb"], "particle_radius = '20 lb': unit 'lb' has another dimension"),
        (["particle_radius=big"], "particle_radius = 'big' is not a number"),
        (["radius=20"], "radius (did you mean particle_radius?): no such quantity"),
        (["colour=20"], "colour: no such quantity; known are"),
        (
            ["plate_angel=1", "diameter=5mm", "x=1", "speed=2"],
            "plate_angel (did you mean plate_angle?), diameter (give half of it as "
            "particle_radius), x, speed (did you mean particle_velocity_y?): no such quantities; "
            "known are",
        ),
        (["particle_radius=20mm", "Particle Size=20mm"], "particle_radius is given twice"),
        (["plate_angle=", "factory_angle=-30"], "plate_angle has no value"),
        (["particle_density=26.5*100"], "particle_density = '26.5*100' is not a number"),
        (["plate_angle=45 Grad"], "plate_angle = '45 Grad': unit 'Grad' is unknown"),
        ([*WORDS[:-1], "particle_velocity_y=5 m/s"], "particle_velocity_y = 5 m/s is impossible"),
        ([*WORDS, "--confidence", "1.5"], "--confidence 1.5: must lie between 0 and 1, or between"),
        ([*WORDS, "--confidence", "95,5"], "--confidence 95,5: is not a number, with a decimal"),
        ([*WORDS, "--confidence", "0_5"], "--confidence 0_5: is not a number"),
        (["--material", "granit"], "--material granit: no such preset, did you mean granite?"),
        (["particle_radius=20,5mm"], "particle_radius = '20,5mm' has a decimal comma"),
        ([*WORDS, "--depth", "-5"], "--depth -5: must be positive"),
        ([*WORDS, "--confidence", "1"], "--confidence 1: must lie between 0 and 1"),
        ([*WORDS, "--confidence", "high"], "--confidence high: is not a number"),
        ([*WORDS, "--confidence", "0.9999"], "confidence = 0.9999: the intervals rest on 150"),
        (["20"], "'20' is not of the form NAME=VALUE"),
        (["plate_angle=1", "plate_angle=2"], "plate_angle is given twice"),
        ([*WORDS, "--depth", "5kg"], "--depth 5kg: unit 'kg' has another dimension"),
        ([*WORDS, "--output", "a.csv"], "--output needs --table FILE"),
        (["--table", "nowhere.csv"], "nowhere.csv: there is no such file"),
        (["--table", "nowhere.csv", "--output", "o.csv"], "nowhere.csv: there is no such file"),
        (["--table", "nowhere.txt", "--output", "o.csv"], "nowhere.txt: is neither .csv"),
    ],
)
def test_mistakes_on_the_command_line_are_one_line(capsys, stem, words, line):
    code, out, err = run(capsys, "--model", stem, *words)
    assert code == 2 and out == ""
    assert err.startswith(line) and len(err.splitlines()) == 1


def test_the_default_model_is_that_of_the_configuration(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = run(capsys, *WORDS)
    assert code == 2 and "there is no config.yaml here" in err
    (tmp_path / "config.yaml").write_text("study: mine\n")
    code, _, err = run(capsys, *WORDS)
    assert code == 2 and err.startswith("results/mine/models/surrogate.json: there is no such file")


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_table_comes_back_with_predictions(capsys, stem, tmp_path, suffix):
    rng = np.random.default_rng(0)
    frame = pd.DataFrame({row.name: rng.uniform(*row.paper_range, 30) for row in SAMPLED})
    less = frame.drop(columns="restitution").assign(label="x")
    path, output = tmp_path / f"t{suffix}", tmp_path / f"o{suffix}"
    less.to_csv(path, index=False) if suffix == ".csv" else less.to_parquet(path)
    code, out, _ = run(
        capsys, "--model", stem, "--table", path, "--output", output, "restitution=0.5",
        "--depth", "2mm",
    )  # fmt: skip
    assert code == 0 and out.startswith("30 cases predicted")
    found = pd.read_csv(output) if suffix == ".csv" else pd.read_parquet(output)
    if suffix == ".csv":
        assert list(found)[-2:] == ["hours_lower [h]", "hours_upper [h]"]
        found.columns = found.columns.str.replace(r" \[.*\]", "", regex=True)
    expected = abradem.predict(frame.assign(restitution=0.5), stem)
    np.testing.assert_allclose(found["wear_depth_rate"], expected.rate, rtol=1e-6)
    np.testing.assert_allclose(found["hours"], expected.hours_to(2.0)[0], rtol=1e-6)
    assert (found["label"] == "x").all()
    if suffix == ".parquet":
        import pyarrow.parquet as pq

        field = pq.read_schema(output).field("wear_depth_rate")
        assert field.metadata[b"units"] == b"mm/s"


def asked(capsys, stem, tmp_path, table, *words):
    """Answer for a table given as text."""
    path = tmp_path / "t.csv"
    path.write_text(table)
    return run(capsys, "--model", stem, "--table", path, *words)


REST = [word for word in WORDS if not word.startswith(("plate_angle", "restitution"))]


@pytest.mark.parametrize(
    "table",
    [
        "plate_angle,restitution\n45,0.5\n",
        "plate_angle, restitution\n45, 0.5\n",
        "Plate Angle;Restitution\n45;0,5\n",
        "plate_angle (rad)\tCoefficient of Restitution (Interaction)\n0.7853981633974483\t0.5\n",
        "restitution,site,PLATE_ANGLE\n0.5,north,45°\n",
    ],
)
def test_a_table_gives_the_same_however_it_is_written(capsys, stem, tmp_path, table):
    code, _, err = asked(capsys, stem, tmp_path, table, *REST, "--output", tmp_path / "o.csv")
    assert code == 0 and "command line" in err and "restitution =" not in err
    given = {**CASE, "plate_angle": 45.0, "restitution": 0.5}
    found = pd.read_csv(tmp_path / "o.csv")
    assert found["wear_depth_rate [mm/s]"][0] == pytest.approx(abradem.predict(given, stem).rate[0])


@pytest.mark.parametrize(
    ("table", "words", "line"),
    [
        ("plate_angle,restitution\n45,0.5\n", [*REST, "plate_angle=10"],
         "plate_angle is on the command line and in column 'plate_angle'; give it once"),
        ("angle,restitution\n45,0.5\n", [*REST, "plate_angle=10"],
         "column 'angle' is unknown; rename it to plate_angle if that is meant"),
        ("plate_angle,Restitution coeff\n45,0.5\n", [*REST, "restitution=.3"],
         "column 'Restitution coeff' is unknown; rename it to restitution"),
        ("plate_angle,particle_youngs_modulus\n45,1e9\n", ["--material", "granite", *REST],
         "missing: restitution"),
        ("plate_angle,Young's Modulus (Material)\n45,1e11\n", [*REST, "restitution=.3"],
         "holds particle_youngs_modulus, but particle_shear_modulus would be taken from"),
        ("plate_angle,damping_ratio\n45,-.2\n", [*REST, "restitution=.3"],
         "holds damping_ratio, but restitution would be taken from the command line"),
        ("plate_angle,d50 (mm)\n45,20\n", [*REST, "restitution=.3"],
         "is unknown; rename it to particle_radius if that is meant (particle radius, half of the"),
        ("colour,taste\nred,sweet\n", WORDS, "has no column with a known quantity"),
        ("plate_angle\n45\n", REST, "missing: restitution"),
        ("plate_angle,wear_depth_rate\n45,1\n", [*REST, "restitution=.3"],
         "already has column 'wear_depth_rate'"),
        ("plate_angle\n45 mm\n", [*REST, "restitution=.3"], "unit 'mm' has another dimension"),
    ],
)  # fmt: skip
def test_no_column_of_a_table_is_ignored_in_favour_of_another_value(
    capsys, stem, tmp_path, table, words, line
):
    words = [word for word in words if word not in ("--material", "granite")]
    code, out, err = asked(capsys, stem, tmp_path, table, *words)
    assert code == 2 and out == "" and line in err
    assert all(text.startswith(str(tmp_path)) for text in err.splitlines())


def test_a_table_without_an_output_is_printed(capsys, stem, tmp_path):
    words = [*REST, "restitution=0.5", "--depth", "5 mm"]
    code, out, err = asked(capsys, stem, tmp_path, "plate_angle\n45\n50\n", *words)
    header, *rows = out.splitlines()
    assert code == 0 and len(rows) == 2 and header.startswith("plate_angle,wear_depth_rate [mm/s],")
    assert "2 cases predicted: mean over the plate, 95 % interval" in err
    code, _, err = asked(capsys, stem, tmp_path, "plate_angle\n45\n", *words, "--output",
                         tmp_path / "t.csv")  # fmt: skip
    assert code == 2 and "is the table itself" in err


def test_what_was_read_as_what_and_what_was_not_used_is_said(capsys, stem, tmp_path):
    table = "X13,Particle Size [mm],width,site\n45,20,3,north\n"
    words = [word for word in WORDS if not word.startswith(("plate_angle", "particle_radius"))]
    code, _, err = asked(capsys, stem, tmp_path, table, *words)
    assert code == 0
    assert "read 'X13' as plate_angle, 'Particle Size [mm]' as particle_radius" in err
    assert "the size is read as the radius" in err and "not used: 'width'" in err


@pytest.mark.parametrize(
    ("output", "words"),
    [
        ("http://x.org/a.csv", "is an address"), ("a\nb.csv", "control character"),
        ("~nobody-of-this-name/a.csv", "home directory"), ("folder.csv", "is a link, a folder"),
        ("link.csv", "is a link, a folder"), ("a.txt", "is neither .csv nor .parquet"),
    ],
)  # fmt: skip
def test_an_output_that_is_no_place_for_a_file_is_refused(
    capsys, stem, tmp_path, monkeypatch, output, words
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "link.csv").symlink_to("elsewhere.csv")
    before = sorted(tmp_path.iterdir())
    code, _, err = asked(capsys, stem, tmp_path, "plate_angle\n45\n", *REST, "restitution=.5",
                         "--output", output)  # fmt: skip
    assert code == 2 and words in err and len(err.splitlines()) == 1
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "t.csv"])


@pytest.mark.parametrize("study", ["010", "no", "''", "../../etc", "2024-13-45", "[[", "3.5"])
def test_a_study_of_the_configuration_that_is_no_name_is_one_line(
    capsys, tmp_path, monkeypatch, study
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").write_text(f"study: {study}\n")
    code, _, err = run(capsys, *WORDS)
    assert code == 2 and err == "--model is not given, and config.yaml names no study\n"


def test_units_and_columns_of_a_parquet_table_are_kept(capsys, stem, tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    path, output = tmp_path / "t.parquet", tmp_path / "o.PARQUET"
    schema = pa.schema([pa.field("particle_radius", pa.float64(), metadata={"units": "mm"}),
                        pa.field("site", pa.string())])  # fmt: skip
    pq.write_table(pa.table({"particle_radius": [20.0], "site": ["north"]}, schema=schema), path)
    words = [word for word in WORDS if not word.startswith("particle_radius")]
    code, _, _ = run(capsys, "--model", stem, "--table", path, "--output", output, *words)
    assert code == 0
    written = pq.read_schema(output)
    assert written.field("particle_radius").metadata[b"units"] == b"mm"
    assert b"95 % interval" in written.field("wear_depth_rate_lower").metadata[b"long_name"]
    given = {**CASE, "particle_radius": 0.02}
    found = pq.read_table(output).to_pydict()
    assert found["site"] == ["north"] and found["particle_radius"] == [20.0]
    assert found["wear_depth_rate"] == pytest.approx(abradem.predict(given, stem).rate)


def test_the_depth_is_said_to_be_that_of_the_target(capsys, stem):
    _, out, _ = run(capsys, "--model", stem, *WORDS, "--depth", "5")
    assert "(wear_total_mean: mean over the plate)" in out
    assert "(depth mean over the plate; single places are worn deeper)" in out


@pytest.mark.parametrize(
    ("target", "rate", "depth"),
    [
        ("wear_friction_p99", "99th percentile of 30 mm elements",
         "99th percentile of 30 mm elements; single places are worn deeper"),
        ("wear_total_max", "worst 30 mm element", "worst 30 mm element"),
        ("wear_sliding_mean", "mean over the plate",
         "mean over the plate; single places are worn deeper"),
    ],
)  # fmt: skip
def test_a_surrogate_says_the_size_of_the_elements_of_its_target(
    capsys, given, process, tmp_path, target, rate, depth
):
    renamed = given._replace(table=given.table._replace(target_name=target))
    settings = SETTINGS._replace(points=200, hidden=(4,), epochs=1)
    intervals = Conformal(np.ones(99), fit_scale(np.ones(150), given.groups))
    model = surrogate_of(renamed, process, intervals, settings, None, element_size=0.03)
    write_model(*model, tmp_path / "s.json")
    code, out, _ = run(capsys, "--model", tmp_path / "s", *WORDS, "--depth", "5")
    assert code == 0
    assert f"({target}: {rate})" in out and f"(depth {depth})" in out
    assert ("element_size" in model[0]["target"]) == ("mm" in rate)


def test_the_smallest_level_has_an_interval(stem):
    found = Surrogate.load(stem).predict(CASE, 1e-12)
    assert found.lower[0] <= found.rate[0] <= found.upper[0]


@pytest.mark.parametrize("level", ["0.9", "90", "90%", "90 %"])
def test_a_level_may_be_in_percent(capsys, stem, level):
    _, out, _ = run(capsys, "--model", stem, *WORDS, "--confidence", level)
    assert "90 % interval" in out


def test_what_the_preset_gave_is_said(capsys, stem):
    words = [word for word in WORDS if not word.startswith("particle_density")]
    _, _, err = run(capsys, "--model", stem, *words, "--material", "Iron Ore")
    assert err.splitlines()[-1] == "from the preset iron_ore: particle_density = 4000 kg/m3"


def test_blanks_around_the_sign_and_the_unit_are_understood(capsys, stem):
    rest = [word for word in WORDS if not word.startswith(("particle_radius", "particle_vel"))]
    answers = {
        run(capsys, "--model", stem, *rest, *words)[1]
        for words in (
            ("particle_radius=20mm", "particle_velocity_y=-5"),
            ("particle_radius", "=", "20", "mm", "particle_velocity_y", "=", "-5", "m/s"),
            ("particle_radius=", "20mm", "particle_velocity_y=", "−18 km/h"),
            ("particle_radius", "=2cm", "particle_velocity_y", "=-5m/s"),
        )
    }
    assert len(answers) == 1 and "mm/s" in answers.pop()


def test_a_wrong_row_of_a_table_is_named(capsys, stem, tmp_path):
    frame = pd.DataFrame([CASE, CASE]).assign(restitution=[0.5, 7.0])
    frame.to_csv(tmp_path / "t.csv", index=False)
    code, _, err = run(
        capsys, "--model", stem, "--table", tmp_path / "t.csv", "--output", tmp_path / "o.csv"
    )
    assert code == 2 and "t.csv: restitution = 7 in row 2 is impossible" in err
    assert not (tmp_path / "o.csv").exists()


def test_units_are_those_of_the_quantity():
    assert parse_value("particle_radius", "20mm") == pytest.approx(0.02)
    assert parse_value("plate_angle", "-30") == -30.0
    assert parse_value("archard_constant", "1e-9 /Pa") == 1e-9
    assert parse_value("plate_angle", "1rad") == pytest.approx(57.29578)
    with pytest.raises(ValueError, match="none, it is a pure number"):
        parse_value("restitution", "50 %")


# ONNX


def test_the_onnx_graph_gives_the_same(capsys, stem, tmp_path):
    pytest.importorskip("onnx")
    runtime = pytest.importorskip("onnxruntime")
    path = tmp_path / "s.onnx"
    assert run(capsys, "--model", stem, "--onnx", path)[0] == 0
    session = runtime.InferenceSession(path)
    rng = np.random.default_rng(0)
    values = {row.name: rng.uniform(*row.paper_range, 500) for row in SAMPLED}
    wanted = {one.name for one in session.get_inputs()}
    rate, _ = session.run(None, {name: v for name, v in values.items() if name in wanted})
    np.testing.assert_allclose(rate, abradem.predict(values, stem).rate, rtol=1e-5)


def test_the_distillation_is_the_same_for_a_seed(given, process):
    small = Settings(points=200, hidden=(4,), epochs=2)
    one, two = (distil(process, given, small, seed=3)[0] for _ in range(2))
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])
