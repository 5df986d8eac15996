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
    (tmp_path / "a.json").write_text("{")
    with pytest.raises(files.TableError, match="not JSON"):
        files.read_json(tmp_path / "a.json")
