"""Files: written completely or not at all, plain formats, reproducible bytes."""

import json

import numpy as np
import pytest

from abradem.store import files


def test_json_is_sorted_plain_and_the_same_every_time(tmp_path):
    value = {"b": np.float64(np.nan), "a": [np.int64(1), (2.5, np.True_)], "c": np.arange(2)}
    files.write_json(value, tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text()) == {
        "a": [1, [2.5, True]],
        "b": None,
        "c": [0, 1],
    }
    assert (tmp_path / "a.json").read_text().index('"a"') < 5
    assert files.read_json(tmp_path / "a.json")["b"] is None


@pytest.mark.parametrize("text", ["{", "", '{"a": NaN}', "[-Infinity]", "[" * 100_000, "1" * 5000])
def test_what_is_no_json_is_one_line(tmp_path, text):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(files.TableError, match="not JSON") as error:
        files.read_json(tmp_path / "a.json")
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("content", [b"", b"\xff" * 100, b"\x08\0\0\0\0\0\0\0{      }x", None])
def test_damaged_arrays_are_one_line(tmp_path, content):
    path = tmp_path / "a.safetensors"
    files.write_arrays({"a": np.arange(5.0)}, path)
    whole = path.read_bytes()
    # None: a type that numpy lacks.
    path.write_bytes(whole.replace(b'"F64"', b'"F99"') if content is None else content)
    with pytest.raises(files.TableError, match="corrupt or not safetensors") as error:
        files.read_arrays(path)
    assert len(str(error.value).splitlines()) == 1
    with pytest.raises(files.TableError, match="no such file"):
        files.read_arrays(tmp_path / "none.safetensors")


def test_a_folder_that_can_be_written_is_no_problem_and_keeps_no_trace(tmp_path):
    assert files.why_not_written(tmp_path / "new" / "deeper") == ""
    assert files.why_not_written(tmp_path) == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("below", "reason"),
    [
        ("file", "file: is a file, where a folder must be"),
        ("file/deeper", "file: is a file, where a folder must be"),
        ("dangling/deeper", "dangling: is a link to nowhere, which does not exist"),
        ("loop", "loop: is a link to loop, which does not exist"),
        ("system/deeper", "system: cannot be written: "),
    ],
)
def test_why_a_folder_cannot_be_written_is_one_line(tmp_path, below, reason):
    (tmp_path / "file").write_text("")
    for name, target in {"dangling": "nowhere", "loop": "loop", "system": "/proc"}.items():
        (tmp_path / name).symlink_to(target)
    found = files.why_not_written(tmp_path / below)
    assert found.startswith(f"{tmp_path}/{reason}") and len(found.splitlines()) == 1
