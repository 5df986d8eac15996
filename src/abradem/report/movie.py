"""Encoding of frames as a film, H.264 in MP4, with the ffmpeg of imageio-ffmpeg."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np


class MovieError(ValueError):
    """The film cannot be made; the message is one line."""


def why_no_film() -> str:
    """Return in one line why no film can be made here, or ""."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except ModuleNotFoundError:
        return "films need the package imageio-ffmpeg: pip install -e '.[movie]'"
    except (OSError, RuntimeError) as error:
        return f"films need ffmpeg: {' '.join(str(error).split())}"
    return ""


def require_encoder():
    """Import the module with the encoder; raises `MovieError` if it is not installed."""
    if reason := why_no_film():
        raise MovieError(reason)
    import imageio_ffmpeg

    return imageio_ffmpeg


def write_movie(frames: Iterable[np.ndarray], path: str | Path, per_second: int) -> np.ndarray:
    """Write frames as MP4 and return the last one; the file is complete or not written.

    Parameters
    ----------
    frames : iterable of ndarray of uint8, shape (height, width, 3)
        All of the same size, with even height and width.
    path : path-like
    per_second : int
        Frames per second.

    Raises
    ------
    MovieError
        If the encoder is not installed, or there are no frames.
    """
    encoder = require_encoder()
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.tmp.mp4")
    sink, last = None, None
    try:
        for frame in frames:
            if sink is None:
                height, width = frame.shape[:2]
                sink = encoder.write_frames(
                    str(temporary), (width, height), fps=per_second, codec="libx264", quality=None,
                    pix_fmt_out="yuv420p", macro_block_size=2,
                    # One thread and no time stamps: the same frames give the same bytes.
                    output_params=["-crf", "20", "-preset", "medium", "-threads", "1",
                                   "-fflags", "+bitexact", "-movflags", "+faststart"],
                )  # fmt: skip
                sink.send(None)
            sink.send(frame)
            last = frame
        if sink is None or last is None:
            raise MovieError(f"{path}: there are no frames")
        sink.close()
        os.replace(temporary, path)
    finally:
        if sink is not None:
            sink.close()
        temporary.unlink(missing_ok=True)
    return last
