"""Frames of the film: particles and wear on plates at several angles, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.figures.render import Camera, picture
from abradem.figures.setup import factory_patch, particle_tints, worn_plate
from abradem.figures.wear_colours import WEAR_MAP, scale_top

_EYE = np.array([-0.25, 0.42, 0.87]) / np.linalg.norm([-0.25, 0.42, 0.87])
_DISTANCE = 5.0
_ASPECT = 1.12
"""Height of the picture of a plate divided by its width."""

_HEAD, _FOOT = 0.085, 0.155
"""Space above the pictures for the angle and below for the scale, relative to their width."""


@dataclass(frozen=True)
class Shot:
    """Snapshots of one plate.

    Parameters
    ----------
    case : mapping
        Arguments of `abradem.Case`.
    particles : pandas.DataFrame
        time, particle, x, y, z as `abradem.simulation.snapshots` writes them.
    times : ndarray, shape (n,)
        s.
    depth : ndarray, shape (n, nx, nz)
        mm, from `abradem.wear.depths.depth_frames`.
    """

    case: Mapping[str, float]
    particles: pd.DataFrame
    times: np.ndarray
    depth: np.ndarray


def frames(shots: Sequence[Shot], setup: Setup, width: int) -> Iterator[np.ndarray]:
    """Yield the frames for all times that the shots have in common, in order.

    Parameters
    ----------
    shots : sequence of Shot
        From left to right.
    setup : Setup
    width : int
        Width of the picture of each plate, pixels.

    Yields
    ------
    ndarray of uint8, shape (height, width, 3)
        Height and width are even, as required by video encoders.
    """
    top = shared_top(shots)
    with style.style():
        stage = _Stage(shots, setup, width, top)
        places = [dict(tuple(shot.particles.groupby("time"))) for shot in shots]
        for index in range(min(len(shot.times) for shot in shots)):
            now = [
                rows.get(shot.times[index], shot.particles.iloc[:0])
                for shot, rows in zip(shots, places, strict=True)
            ]
            yield stage.draw(index, now)


def shared_top(shots: Sequence[Shot]) -> float:
    """Depth at the upper end of the colour scale of all plates, mm."""
    return scale_top(np.concatenate([shot.depth[-1].ravel() for shot in shots]))


class _Stage:
    """The figure of the film, laid out once; each frame updates the pictures and the clock."""

    def __init__(self, shots, setup, width, top):
        self.shots, self.setup, self.top = shots, setup, top
        height = 2 * round(0.5 * width * (_ASPECT + _HEAD + _FOOT))
        total = 2 * round(0.5 * width * len(shots))
        dpi = 0.24 * width
        self.figure = Figure(figsize=(total / dpi, height / dpi), dpi=dpi)
        self.canvas = FigureCanvasAgg(self.figure)
        rows = round(width * _ASPECT)
        target = np.array([0.0, 0.16 * setup.fall_height, 0.0])
        view = 1.56 * _ASPECT * max(setup.plate_length, setup.plate_width, setup.fall_height)
        self.camera = Camera(target + _DISTANCE * view * _EYE, target, view, width, rows)
        self.images = []
        for index, shot in enumerate(shots):
            panel = self.figure.add_axes(
                (index / len(shots), _FOOT * width / height, 1.0 / len(shots), rows / height)
            )
            panel.set_axis_off()
            self.images.append(panel.imshow(np.ones((rows, width, 3)), aspect="auto"))
            self.figure.text(
                (index + 0.5) / len(shots), 1.0 - 0.5 * _HEAD * width / height,
                f"plate at {style.number(shot.case['plate_angle'])}°", ha="center", va="center",
                fontsize=9.0,
            )  # fmt: skip
        power = style.decade(top)
        share = min(0.5, 0.85 / len(shots))
        scale = self.figure.add_axes((0.5 * (1 - share), 0.66 * _FOOT * width / height, share,
                                      0.16 * _FOOT * width / height))  # fmt: skip
        bar = self.figure.colorbar(
            ScalarMappable(Normalize(0.0, top / 10.0**power), mpl.colormaps[WEAR_MAP]),
            cax=scale, orientation="horizontal", extend="max",
        )  # fmt: skip
        bar.outline.set_linewidth(0.6)
        bar.ax.tick_params(labelsize=7.0, pad=1.5)
        bar.set_label(f"Wear depth ({style.scaled_unit(power, 'mm')})", fontsize=7.5, labelpad=1.0)
        self.clock = self.figure.text(
            0.985, 0.5 * _FOOT * width / height, "", ha="right", va="center", fontsize=9.0
        )

    def draw(self, index: int, particles: Sequence[pd.DataFrame]) -> np.ndarray:
        for shot, rows, image in zip(self.shots, particles, self.images, strict=True):
            image.set_data(
                picture(
                    self.camera,
                    worn_plate(shot.depth[index], self.top, shot.case, self.setup),
                    rows[["x", "y", "z"]].to_numpy(),
                    shot.case["particle_radius"],
                    factory_patch(shot.case, self.setup),
                    tints=particle_tints(rows["particle"]),
                )
            )
        self.clock.set_text(f"{self.shots[0].times[index]:.2f} s")
        self.canvas.draw()
        drawn = np.asarray(self.canvas.buffer_rgba())[..., :3]
        return np.ascontiguousarray(drawn[: drawn.shape[0] // 2 * 2, : drawn.shape[1] // 2 * 2])
