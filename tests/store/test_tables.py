"""Tables: units, types, damaged files, reproducible bytes."""

import os

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from abradem.store import columns, files, tables


def test_a_table_reads_back_as_written(tmp_path):
    frame = pd.DataFrame(
        {
            "case_id": [3, 1],
            "time": [0.5, np.nan],
            "status": ["ok", "µ"],
            "identified": [True, False],
        }
    )
    tables.write_table(frame, tmp_path / "deep" / "t.parquet")
    pd.testing.assert_frame_equal(
        tables.read_table(tmp_path / "deep" / "t.parquet"), frame, check_dtype=False
    )
    assert list(tables.read_table(tmp_path / "deep" / "t.parquet", ["time", "case_id"])) == [
        "time",
        "case_id",
    ]


def test_an_empty_table_keeps_its_types(tmp_path):
    frame = pd.DataFrame({"case_id": [], "status": [], "time": []})
    tables.write_table(frame, tmp_path / "t.parquet")
    schema = pq.read_schema(tmp_path / "t.parquet")
    assert [str(field.type) for field in schema] == ["int64", "string", "double"]


def test_the_same_table_gives_the_same_bytes_whatever_its_index(tmp_path):
    frame = pd.DataFrame({"case_id": [1, 2], "wear_total_mean": [0.1, 0.2]})
    tables.write_table(frame, tmp_path / "a.parquet")
    tables.write_table(frame.set_axis([7, 9]), tmp_path / "b.parquet")
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()
    assert pq.read_schema(tmp_path / "a.parquet").metadata is None


def test_every_stored_column_says_its_unit_and_what_it_is(tmp_path):
    tables.write_table(
        pd.DataFrame({"wear_total_mean": [1.0], "case_id": [0]}), tmp_path / "t.parquet"
    )
    assert tables.read_units(tmp_path / "t.parquet") == {"wear_total_mean": "mm/s", "case_id": "1"}
    for field in pq.read_schema(tmp_path / "t.parquet"):
        assert field.metadata[b"long_name"]


def test_a_column_without_a_unit_is_refused_unless_it_is_given(tmp_path):
    frame = pd.DataFrame({"case_id": [1], "colour": [2.0]})
    with pytest.raises(files.TableError, match="no unit is known for column colour"):
        tables.write_table(frame, tmp_path / "t.parquet")
    assert list(tmp_path.iterdir()) == []
    tables.write_table(frame, tmp_path / "t.parquet", {"colour": columns.Column("N", "colour")})
    assert tables.read_units(tmp_path / "t.parquet")["colour"] == "N"


@pytest.mark.parametrize(
    ("column", "values", "says"),
    [
        ("case_id", [0.5], "must contain int64"),
        ("block", [2**40], "does not fit int32"),
        ("status", [None], "must contain text"),
        ("time", ["x"], "must contain float64"),
    ],
)
def test_values_of_another_type_are_refused(tmp_path, column, values, says):
    with pytest.raises(files.TableError, match=says):
        tables.write_table(pd.DataFrame({column: values}), tmp_path / "t.parquet")


def test_a_failed_write_leaves_the_old_file_and_no_remains(tmp_path, monkeypatch):
    path = tmp_path / "t.parquet"
    tables.write_table(pd.DataFrame({"case_id": [1]}), path)
    before = path.read_bytes()

    def full_disk(*_, **__):
        raise OSError("no space left on device")

    monkeypatch.setattr(tables.pq, "write_table", full_disk)
    with pytest.raises(OSError, match="no space"):
        tables.write_table(pd.DataFrame({"case_id": [2]}), path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["t.parquet"]


@pytest.mark.parametrize("damage", ["truncated", "flipped", "other", "empty"])
def test_a_damaged_file_gives_one_clear_line(tmp_path, damage):
    path = tmp_path / "t.parquet"
    tables.write_table(pd.DataFrame({"time": np.random.default_rng(0).random(1000)}), path)
    data = bytearray(path.read_bytes())
    if damage == "flipped":
        data[200] ^= 0xFF
    path.write_bytes(
        {"truncated": data[: len(data) // 2], "flipped": data, "other": b"hello", "empty": b""}[
            damage
        ]
    )
    with pytest.raises(files.TableError) as error:
        tables.read_table(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_missing_files_and_columns_are_named(tmp_path):
    with pytest.raises(files.TableError, match="no such file"):
        tables.read_table(tmp_path / "none.parquet")
    tables.write_table(pd.DataFrame({"case_id": [1]}), tmp_path / "t.parquet")
    with pytest.raises(files.TableError, match="lacks column time"):
        tables.read_table(tmp_path / "t.parquet", ["case_id", "time"])


def test_blocks_are_stacked_by_case_with_the_rows_of_a_case_in_order():
    late = pd.DataFrame({"case_id": [2, 2], "time": [0.0, 1.0]})
    early = pd.DataFrame({"case_id": [0, 0], "time": [0.0, 1.0]})
    assert list(tables.concatenate([late, early])["time"]) == [0.0, 1.0, 0.0, 1.0]
    assert list(tables.concatenate([late, early])["case_id"]) == [0, 0, 2, 2]


def test_the_content_hash_sees_values_and_names_only():
    frame = pd.DataFrame({"case_id": [1, 2], "status": ["a", "b"]})
    assert tables.content_hash(frame) == tables.content_hash(frame.set_axis([5, 6]))
    assert tables.content_hash(frame) != tables.content_hash(frame.assign(status=["a", "c"]))
    assert tables.content_hash(frame) != tables.content_hash(
        frame.rename(columns={"status": "quality"})
    )
