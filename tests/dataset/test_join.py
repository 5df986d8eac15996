"""Tables in and out, the join, the checks."""

import json
import os

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from abradem.dataset import join as ds
from abradem.quantities import FEATURE_NAMES, SAMPLED, STATISTICS, WEAR_MEASURES


def sample_cases(n=3, rejected=()):
    middle = {row.name: 0.5 * sum(row.paper_range) for row in SAMPLED}
    cases = pd.DataFrame({"case_id": range(n), "block": 0, "seed": range(10, 10 + n)})
    cases = cases.assign(**middle)
    cases["rejected"] = ["too fast" if key in rejected else "" for key in cases["case_id"]]
    return cases


def sample_runs(n=3, **status):
    numbers = {
        "simulated_time": 6.0,
        "steady_from": 0.5,
        "delivered_rate": 4.0,
        "face_share": 0.9,
    }
    runs = pd.DataFrame({"case_id": range(n), "status": "ok"}).assign(**numbers)
    for key, word in status.items():
        runs.loc[int(key[1:]), "status"] = word
    return runs


def sample_rates(keys):
    rates = pd.DataFrame({"case_id": list(keys)})
    for name in ds.WEAR_COLUMNS:
        rates[name] = 1e-3
    return rates.assign(
        wear_total_mean_stderr=1e-5, wear_r2=0.99, worn_volume_rate=1e-9, wear_per_kg=1e-10,
        quality="ok",
    )  # fmt: skip


def test_a_table_reads_back_as_written(tmp_path):
    frame = pd.DataFrame(
        {
            "case_id": [3, 1],
            "time": [0.5, np.nan],
            "status": ["ok", "µ"],
            "identified": [True, False],
        }
    )
    ds.write_table(frame, tmp_path / "deep" / "t.parquet")
    pd.testing.assert_frame_equal(
        ds.read_table(tmp_path / "deep" / "t.parquet"), frame, check_dtype=False
    )
    assert list(ds.read_table(tmp_path / "deep" / "t.parquet", ["time", "case_id"])) == [
        "time",
        "case_id",
    ]


def test_an_empty_table_keeps_its_types(tmp_path):
    frame = pd.DataFrame({"case_id": [], "status": [], "time": []})
    ds.write_table(frame, tmp_path / "t.parquet")
    schema = pq.read_schema(tmp_path / "t.parquet")
    assert [str(field.type) for field in schema] == ["int64", "string", "double"]


def test_the_same_table_gives_the_same_bytes_whatever_its_index(tmp_path):
    frame = pd.DataFrame({"case_id": [1, 2], "wear_total_mean": [0.1, 0.2]})
    ds.write_table(frame, tmp_path / "a.parquet")
    ds.write_table(frame.set_axis([7, 9]), tmp_path / "b.parquet")
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()
    assert pq.read_schema(tmp_path / "a.parquet").metadata is None


def test_every_stored_column_says_its_unit_and_what_it_is(tmp_path):
    ds.write_table(pd.DataFrame({"wear_total_mean": [1.0], "case_id": [0]}), tmp_path / "t.parquet")
    assert ds.read_units(tmp_path / "t.parquet") == {"wear_total_mean": "mm/s", "case_id": "1"}
    for field in pq.read_schema(tmp_path / "t.parquet"):
        assert field.metadata[b"long_name"]


def test_all_columns_of_the_dataset_have_units_and_each_feature_its_own():
    assert set(ds.DATASET_COLUMNS) <= set(ds.COLUMNS)
    assert ds.DATASET_COLUMNS[3:23] == FEATURE_NAMES
    assert [n for n in ds.WEAR_COLUMNS] == [
        f"wear_{r}_{s}" for r in WEAR_MEASURES for s in STATISTICS
    ]
    for row in SAMPLED:
        assert ds.COLUMNS[row.name].unit == row.unit


def test_a_column_without_a_unit_is_refused_unless_it_is_given(tmp_path):
    frame = pd.DataFrame({"case_id": [1], "colour": [2.0]})
    with pytest.raises(ds.TableError, match="no unit is known for column colour"):
        ds.write_table(frame, tmp_path / "t.parquet")
    assert list(tmp_path.iterdir()) == []
    ds.write_table(frame, tmp_path / "t.parquet", {"colour": ds.Column("N", "colour")})
    assert ds.read_units(tmp_path / "t.parquet")["colour"] == "N"


@pytest.mark.parametrize(
    ("column", "values", "says"),
    [
        ("case_id", [0.5], "must hold int64"),
        ("block", [2**40], "does not fit int32"),
        ("status", [None], "must hold text"),
        ("time", ["x"], "must hold float64"),
    ],
)
def test_values_of_another_type_are_refused(tmp_path, column, values, says):
    with pytest.raises(ds.TableError, match=says):
        ds.write_table(pd.DataFrame({column: values}), tmp_path / "t.parquet")


def test_a_failed_write_leaves_the_old_file_and_no_remains(tmp_path, monkeypatch):
    path = tmp_path / "t.parquet"
    ds.write_table(pd.DataFrame({"case_id": [1]}), path)
    before = path.read_bytes()

    def full_disk(*_, **__):
        raise OSError("no space left on device")

    monkeypatch.setattr(ds.pq, "write_table", full_disk)
    with pytest.raises(OSError, match="no space"):
        ds.write_table(pd.DataFrame({"case_id": [2]}), path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["t.parquet"]


@pytest.mark.parametrize("damage", ["truncated", "flipped", "other", "empty"])
def test_a_damaged_file_gives_one_clear_line(tmp_path, damage):
    path = tmp_path / "t.parquet"
    ds.write_table(pd.DataFrame({"time": np.random.default_rng(0).random(1000)}), path)
    data = bytearray(path.read_bytes())
    if damage == "flipped":
        data[200] ^= 0xFF
    path.write_bytes(
        {"truncated": data[: len(data) // 2], "flipped": data, "other": b"hello", "empty": b""}[
            damage
        ]
    )
    with pytest.raises(ds.TableError) as error:
        ds.read_table(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_missing_files_and_columns_are_named(tmp_path):
    with pytest.raises(ds.TableError, match="no such file"):
        ds.read_table(tmp_path / "none.parquet")
    ds.write_table(pd.DataFrame({"case_id": [1]}), tmp_path / "t.parquet")
    with pytest.raises(ds.TableError, match="lacks column time"):
        ds.read_table(tmp_path / "t.parquet", ["case_id", "time"])


def test_json_is_sorted_plain_and_the_same_every_time(tmp_path):
    value = {"b": np.float64(np.nan), "a": [np.int64(1), (2.5, np.True_)], "c": np.arange(2)}
    ds.write_json(value, tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text()) == {
        "a": [1, [2.5, True]],
        "b": None,
        "c": [0, 1],
    }
    assert (tmp_path / "a.json").read_text().index('"a"') < 5
    assert ds.read_json(tmp_path / "a.json")["b"] is None
    (tmp_path / "a.json").write_text("{")
    with pytest.raises(ds.TableError, match="not JSON"):
        ds.read_json(tmp_path / "a.json")


def test_the_join_has_one_row_for_each_case_that_ended_well():
    cases, runs = (
        sample_cases(7, rejected=(4,)),
        sample_runs(7, c1="overlap", c4="rejected: too fast").drop(index=5),
    )
    rates = sample_rates([0, 2, 3])
    rates.loc[2, "wear_total_mean"] = np.nan
    rates.loc[len(rates)] = [6, *[0.0] * (rates.shape[1] - 2), "stderr"]
    shuffled = cases.sample(frac=1, random_state=1)
    dataset, failures = ds.join(shuffled, rates.iloc[::-1], runs.iloc[::-1])
    assert list(dataset["case_id"]) == [0, 2]
    assert tuple(dataset.columns) == ds.DATASET_COLUMNS
    assert tuple(failures.columns) == ds.FAILURE_COLUMNS
    assert dict(zip(failures["case_id"], failures["status"], strict=True)) == {
        1: "overlap",
        3: "no wear rate: no steady state reached",
        4: "rejected: too fast",
        5: "not simulated",
        6: "no wear: nothing met the plate",
    }
    ds.check(dataset)


def test_the_join_takes_the_seeds_and_features_of_the_right_case():
    cases = sample_cases(4)
    cases["particle_radius"] = [0.01, 0.02, 0.03, 0.04]
    dataset, _ = ds.join(cases.iloc[::-1], sample_rates([3, 1, 0]), sample_runs(4))
    assert list(dataset["particle_radius"]) == [0.01, 0.02, 0.04]
    assert list(dataset["seed"]) == [10, 11, 13]


def test_the_join_refuses_doubled_and_foreign_cases():
    with pytest.raises(ds.TableError, match="wear rates: case 1 stands twice"):
        ds.join(sample_cases(), sample_rates([0, 1, 1]), sample_runs())
    with pytest.raises(ds.TableError, match="case 3 does not belong"):
        ds.join(sample_cases(3), sample_rates([0]), sample_runs(4))


def test_a_case_with_a_number_that_is_not_finite_is_a_failure_and_stops_no_other():
    rates = sample_rates([0, 1, 2])
    rates.loc[1, "wear_per_kg"] = np.nan
    rates.loc[2, "wear_sliding_max"] = np.inf
    dataset, failures = ds.join(sample_cases(3), rates, sample_runs(3))
    assert list(dataset["case_id"]) == [0]
    assert list(failures["status"]) == ["no finite wear_per_kg", "no finite wear_sliding_max"]
    ds.check(dataset)


def test_more_failures_than_allowed_are_one_line():
    runs = sample_runs(4, c0="refused: step 1", c1="refused: step 2", c3="overlap")
    dataset, failures = ds.join(sample_cases(4), sample_rates([2]), runs)
    ds.check_failures(dataset, failures, 0.75)
    with pytest.raises(ds.TableError) as stopped:
        ds.check_failures(dataset, failures, 0.7)
    assert str(stopped.value) == (
        "dataset: 3 of 4 cases failed (2 refused, 1 overlap), more than "
        "simulation.max_failed_share = 0.7 allows; case 0: refused: step 1; "
        "failures.parquet holds all"
    )


def test_a_study_without_a_good_case_says_so():
    dataset, failures = ds.join(sample_cases(2), sample_rates([]), sample_runs(2, c0="x", c1="y"))
    assert list(failures["status"]) == ["x", "y"]
    with pytest.raises(ds.TableError, match="no case ended well"):
        ds.check(dataset)


@pytest.mark.parametrize(
    ("column", "value", "says"),
    [
        ("wear_total_mean", np.nan, "case 1: wear_total_mean = nan mm/s must be finite"),
        ("wear_total_mean", 0.0, "case 1: wear_total_mean = 0.0 mm/s must be positive"),
        ("wear_sliding_max", -1.0, "wear_sliding_max = -1.0 mm/s must not be negative"),
        ("plate_angle", 200.0, "plate_angle = 200.0 deg must lie in"),
    ],
)
def test_the_check_names_case_column_value_and_law(column, value, says):
    dataset, _ = ds.join(sample_cases(), sample_rates(range(3)), sample_runs())
    dataset.loc[1, column] = value
    with pytest.raises(ds.TableError) as error:
        ds.check(dataset)
    assert says in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_facets_that_few_large_particles_leave_unworn_are_no_error():
    dataset, _ = ds.join(sample_cases(), sample_rates(range(3)), sample_runs())
    ds.check(dataset.assign(wear_total_p99=0.0, wear_sliding_mean=0.0))


def test_the_check_finds_doubled_cases_and_missing_columns():
    dataset, _ = ds.join(sample_cases(), sample_rates(range(3)), sample_runs())
    with pytest.raises(ds.TableError, match="case 0 stands"):
        ds.check(pd.concat([dataset, dataset.iloc[:1]]))
    with pytest.raises(ds.TableError, match="lacks column restitution"):
        ds.check(dataset.drop(columns="restitution"))


def test_blocks_are_stacked_by_case_with_the_rows_of_a_case_in_order():
    late = pd.DataFrame({"case_id": [2, 2], "time": [0.0, 1.0]})
    early = pd.DataFrame({"case_id": [0, 0], "time": [0.0, 1.0]})
    assert list(ds.concatenate([late, early])["time"]) == [0.0, 1.0, 0.0, 1.0]
    assert list(ds.concatenate([late, early])["case_id"]) == [0, 0, 2, 2]


def test_the_content_hash_sees_values_and_names_only():
    frame = pd.DataFrame({"case_id": [1, 2], "status": ["a", "b"]})
    assert ds.content_hash(frame) == ds.content_hash(frame.set_axis([5, 6]))
    assert ds.content_hash(frame) != ds.content_hash(frame.assign(status=["a", "c"]))
    assert ds.content_hash(frame) != ds.content_hash(frame.rename(columns={"status": "quality"}))
