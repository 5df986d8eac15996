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
