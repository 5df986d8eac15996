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
