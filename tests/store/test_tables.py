"""Tables: units, types, damaged files, reproducible bytes."""

import os
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
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


# Tables of others


def stored(path, columns, metadata=None, **options):
    """A Parquet file with arrays of Arrow and metadata of the schema."""
    table = pa.table(columns).replace_schema_metadata(metadata)
    pq.write_table(table, path, **options)
    return path


def renamed(content, old, new):
    """The content of a file with a name in its footer replaced by one of the same length."""
    assert len(old) == len(new) and old in content
    return content.replace(old, new)


ZONED = pa.array([0, 1], pa.timestamp("us", "Mars/Olympus"))
FAR = pa.array([2**62, 1], pa.timestamp("us"))
FAR_DAY = pa.array([2**30, 1], pa.date32())
FAR_DURATION = pa.array([2**62, 1], pa.duration("s"))
NUMBERS = pa.array([1.0, 2.0])


@pytest.mark.parametrize(
    ("columns", "metadata"),
    [
        ({"a": ZONED}, None),
        ({"a": pa.array([ZONED[:1]], pa.list_(ZONED.type))}, None),
        ({"a": FAR_DAY}, None),
        ({"a": NUMBERS, "b": pa.array([[FAR_DAY[0]], []], pa.list_(pa.date32()))}, None),
        ({"a": FAR}, None),
        ({"a": FAR_DURATION}, None),
        ({"a": pa.array([{"b": 2**62}] * 2, pa.struct([("b", pa.timestamp("us"))]))}, None),
        ({"a": pa.array([[(b"\xff", 1)]] * 2, pa.map_(pa.binary(), pa.int8()))}, None),
        ({"a": NUMBERS}, {b"pandas": b"no JSON {"}),
        ({"a": NUMBERS}, {b"pandas": b"\xff\xfe"}),
        ({"a": NUMBERS}, {b"pandas": b"[1, 2]"}),
        ({"a": NUMBERS}, {b"pandas": b'{"index_columns": ["gone"], "columns": []}'}),
        ({"a": NUMBERS}, {b"pandas": b'{"index_columns": 7}'}),
        ({"a": NUMBERS}, {b"pandas": b"[" * 100_000}),
        ({"a": NUMBERS}, {b"ARROW:schema": b"no base64 \xff"}),
        ({"a": pa.ExtensionArray.from_storage(pa.uuid(), pa.array([b"0" * 16] * 2,
                                                                  pa.binary(16)))}, None),
        ({"a": pa.array(["x", "y"]).dictionary_encode()}, None),
        ({"a": pa.array([1, 2], pa.decimal128(30, 5))}, None),
    ],
)  # fmt: skip
def test_what_cannot_be_converted_is_one_line_and_what_can_has_its_rows(
    tmp_path, columns, metadata
):
    path = stored(tmp_path / "t.parquet", columns, metadata)
    try:
        found = tables.read_table(path)
    except files.TableError as error:
        line = str(error)
        assert line.startswith(f"{path}: ") and len(line.splitlines()) == 1 and len(line) < 600
    else:
        assert list(found) == list(columns) and len(found) == len(columns["a"])


@pytest.mark.parametrize(
    ("values", "of_type"),
    [
        (ZONED, r"timestamp\[us, tz=Mars/Olympus\]"),
        (pa.array([0], pa.timestamp("ns", "no zone")), r"timestamp\[ns, tz=no zone\]"),
        (FAR_DAY, "date32"),
        (pa.array([[2**30]], pa.list_(pa.date32())), "list<.*date32.*>"),
    ],
)  # fmt: skip
def test_the_column_that_cannot_be_converted_is_named(tmp_path, values, of_type):
    columns = {"fine": NUMBERS[: len(values)], "a": values}
    path = stored(tmp_path / "t.parquet", columns)
    with pytest.raises(
        files.TableError, match=f"t.parquet: column 'a' of type {of_type}.* cannot be converted"
    ):
        tables.read_table(path)
    assert len(tables.read_table(path, ["fine"])) == len(values)


def test_columns_of_an_index_are_columns(tmp_path):
    """Metadata for pandas would hide a column, rename it, or change the type of the names."""
    frame = pd.DataFrame({"plate_angle": [1.0, 2.0], "wear": [3.0, 4.0]})
    for name, written in {
        "index": frame.set_index("plate_angle"),
        "levels": frame.assign(run=[7, 8]).set_index(["plate_angle", "run"]),
        "range": frame.set_axis(pd.RangeIndex(5, 7, name="run")),
    }.items():
        written.to_parquet(tmp_path / f"{name}.parquet")
        found = tables.read_table(tmp_path / f"{name}.parquet")
        assert {"wear"} < set(found) or name == "range"
        assert found.index.tolist() == [0, 1]
        if name != "range":
            assert found["plate_angle"].tolist() == [1.0, 2.0]
    numbered = pd.DataFrame({0: [1.0], 1: [2.0]})
    numbered.columns = numbered.columns.astype(str)
    numbered.to_parquet(tmp_path / "n.parquet")
    assert list(tables.read_table(tmp_path / "n.parquet")) == ["0", "1"]


def test_a_column_that_is_there_twice_is_one_line_if_it_is_asked_for(tmp_path):
    table = pa.Table.from_arrays([NUMBERS, NUMBERS], names=["time", "time"])
    pq.write_table(table, tmp_path / "t.parquet")
    assert list(tables.read_table(tmp_path / "t.parquet")) == ["time", "time"]
    with pytest.raises(files.TableError, match=r"t\.parquet: column 'time' appears twice"):
        tables.read_table(tmp_path / "t.parquet", ["time"])


@pytest.mark.parametrize("read", [tables.read_table, tables.read_columns, tables.read_units])
def test_names_and_units_that_are_no_text_are_one_line(tmp_path, read):
    tables.write_table(pd.DataFrame({"case_id": [1]}), tmp_path / "t.parquet")
    content = (tmp_path / "t.parquet").read_bytes()
    (tmp_path / "t.parquet").write_bytes(renamed(content, b"case_id", b"case_\xff\xfe"))
    with pytest.raises(files.TableError, match=r"t\.parquet: ") as error:
        read(tmp_path / "t.parquet")
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("read", [tables.read_table, tables.read_columns, files.read_json])
def test_what_the_file_system_refuses_is_said_in_its_words(tmp_path, read):
    with pytest.raises(files.TableError, match=r"cannot be read \(Is a directory"):
        read(tmp_path)
    with pytest.raises(files.TableError, match="no such file"):
        read(tmp_path / "none")


def test_too_little_memory_is_no_fault_of_the_file(tmp_path, monkeypatch):
    tables.write_table(pd.DataFrame({"case_id": [1]}), tmp_path / "t.parquet")
    for error in (
        pa.ArrowMemoryError("malloc of size 1024 failed"),
        OSError("Unknown error: Failed to launch worker thread: Resource temporarily unavailable"),
        MemoryError(),
    ):

        def failing(*_, error=error, **__):
            raise error

        monkeypatch.setattr(tables.pq, "ParquetFile", failing)
        with pytest.raises(MemoryError, match=r"t\.parquet"):
            tables.read_table(tmp_path / "t.parquet")


def test_only_the_store_reads_parquet():
    """One reader, so that one place turns errors into lines."""
    root = Path(__file__).parents[2]
    reading = re.compile(r"pd\.read_parquet|pq\.(read_|ParquetFile|ParquetDataset)|read_feather")
    readers = {
        path.relative_to(root).as_posix()
        for folder in ("src/abradem", "workflow", "benchmarks")
        for path in (root / folder).rglob("*.py")
        if reading.search(path.read_text(encoding="utf-8").replace('cases = pd.read_parquet("', ""))
    }
    assert readers == {"src/abradem/store/tables.py"}


@pytest.mark.parametrize("text", ["a,b\n1,2\n3,4,5\n", "", "a\n\xff"])
def test_a_damaged_csv_result_is_one_line(tmp_path, text):
    path = tmp_path / "t.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(files.TableError, match=r"t\.csv: truncated, corrupt or not CSV") as error:
        tables.read_result(path)
    assert len(str(error.value).splitlines()) == 1
