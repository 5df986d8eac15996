"""The film: an MP4 file of its frames, or one line that names what is missing."""

import sys

import numpy as np
import pytest

from abradem.report.movie import MovieError, write_movie


def some_frames(count, shape=(60, 80)):
    for index in range(count):
        frame = np.zeros((*shape, 3), np.uint8)
        frame[:, : 10 * (index + 1)] = 200
        yield frame


def test_without_the_encoder_the_answer_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MovieError, match=r"pip install -e '\.\[movie\]'") as error:
        write_movie(some_frames(2), tmp_path / "a.mp4", 10)
    assert "\n" not in str(error.value)


def test_a_film_holds_its_frames_and_is_the_same_each_time(tmp_path):
    encoder = pytest.importorskip("imageio_ffmpeg")
    for name in ("a.mp4", "b.mp4"):
        last = write_movie(some_frames(5), tmp_path / name, 10)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mp4", "b.mp4"]
    assert last[0, 45, 0] == 200 and last[0, 55, 0] == 0
    reader = encoder.read_frames(str(tmp_path / "a.mp4"))
    about = next(reader)
    shown = [np.frombuffer(frame, np.uint8).reshape(60, 80, 3) for frame in reader]
    assert about["size"] == (80, 60) and about["fps"] == 10.0 and len(shown) == 5
    np.testing.assert_allclose(shown[-1][30, [5, 45, 70], 0], [200, 200, 0], atol=12)


def test_no_frames_are_an_error_and_leave_nothing(tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    with pytest.raises(MovieError, match="there are no frames"):
        write_movie(iter(()), tmp_path / "a.mp4", 10)
    assert list(tmp_path.iterdir()) == []
