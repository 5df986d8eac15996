"""Frames of the film: particles and wear on plates at several angles, or on a geometry."""

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
from abradem.figures.setup_geometry import drawn, layers_at, placed_case, view_of
from abradem.figures.wear_colours import WEAR_MAP, scale_top
from abradem.geometry.turning import turning_parts
from abradem.units import MM_PER_M
from abradem.wear.depths import cell_depth_frames, depth_frames

_EYE = np.array([-0.25, 0.42, 0.87]) / np.linalg.norm([-0.25, 0.42, 0.87])
_DISTANCE = 5.0
_ASPECT = 1.12
"""Height of the picture of a plate divided by its width."""

_MARGIN = 1.25
"""Size of the picture of a geometry in that of geometry and factory."""

_HEAD, _FOOT = 0.085, 0.155
"""Space above the pictures for the angle and below for the scale, relative to their width."""


@dataclass(frozen=True)
class Shot:
    """Snapshots of one plate, or of a geometry.

    Parameters
    ----------
    case : mapping
        Arguments of `abradem.Case`.
    particles : pandas.DataFrame
        time, particle, x, y, z as `abradem.simulation.snapshots` writes them.
    times : ndarray, shape (n,)
        s.
    depth : ndarray, shape (n, nx, nz) or (n, t)
        mm, from `abradem.wear.depths.depth_frames` or `cell_depth_frames`.
    """

    case: Mapping[str, float]
    particles: pd.DataFrame
    times: np.ndarray
    depth: np.ndarray


def shot_of(
    case: Mapping[str, float],
    particles: pd.DataFrame,
    wear: pd.DataFrame,
    setup: Setup,
    measure: str,
) -> Shot:
    """Return the snapshots of a case with the depths of a wear measure.

    Parameters
    ----------
    case : mapping
        Quantities of the case, with those of the geometry.
    particles, wear : pandas.DataFrame
        Snapshots from `abradem.simulation.snapshots`.
    setup : Setup
    measure : str
        Wear measure.
    """
    if setup.geometry is None:
        return Shot(case, particles, *depth_frames(wear, case, setup, measure))
    surface = placed_case(case, setup).surface
    return Shot(case, particles, *cell_depth_frames(wear, case, surface, measure))


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
        self.shots = shots
        height = 2 * round(0.5 * width * (_ASPECT + _HEAD + _FOOT))
        total = 2 * round(0.5 * width * len(shots))
        dpi = 0.24 * width
        self.figure = Figure(figsize=(total / dpi, height / dpi), dpi=dpi)
        self.canvas = FigureCanvasAgg(self.figure)
        rows = round(width * _ASPECT)
        painter = _PlatePainter if setup.geometry is None else _GeometryPainter
        self.painters = [painter(shot, setup, width, rows, top) for shot in shots]
        self.images = []
        for index in range(len(shots)):
            panel = self.figure.add_axes(
                (index / len(shots), _FOOT * width / height, 1.0 / len(shots), rows / height)
            )
            panel.set_axis_off()
            self.images.append(panel.imshow(np.ones((rows, width, 3)), aspect="auto"))
            self.figure.text(
                (index + 0.5) / len(shots), 1.0 - 0.5 * _HEAD * width / height,
                self.painters[index].words, ha="center", va="center", fontsize=9.0,
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
        for painter, rows, image in zip(self.painters, particles, self.images, strict=True):
            image.set_data(painter.paint(index, rows))
        self.clock.set_text(f"{self.shots[0].times[index]:.2f} s")
        self.canvas.draw()
        drawn = np.asarray(self.canvas.buffer_rgba())[..., :3]
        return np.ascontiguousarray(drawn[: drawn.shape[0] // 2 * 2, : drawn.shape[1] // 2 * 2])


class _PlatePainter:
    """Pictures of a plate."""

    def __init__(self, shot: Shot, setup: Setup, width: int, rows: int, top: float):
        self.shot, self.setup, self.top = shot, setup, top
        target = np.array([0.0, 0.16 * setup.fall_height, 0.0])
        view = 1.56 * _ASPECT * max(setup.plate_length, setup.plate_width, setup.fall_height)
        self.camera = Camera(target + _DISTANCE * view * _EYE, target, view, width, rows)
        self.words = f"plate at {style.number(shot.case['plate_angle'])}°"

    def paint(self, index: int, rows: pd.DataFrame) -> np.ndarray:
        return picture(
            self.camera,
            worn_plate(self.shot.depth[index], self.top, self.shot.case, self.setup),
            rows[["x", "y", "z"]].to_numpy(),
            self.shot.case["particle_radius"],
            factory_patch(self.shot.case, self.setup),
            tints=particle_tints(rows["particle"]),
        )


class _GeometryPainter:
    """Pictures of a geometry, some of whose parts may turn."""

    def __init__(self, shot: Shot, setup: Setup, width: int, rows: int, top: float):
        self.shot, self.top = shot, top
        self.scene = placed_case(shot.case, setup)
        self.camera = view_of(self.scene, width, rows, _MARGIN)
        self.turns = bool(turning_parts(self.scene.surface))
        self.layers = layers_at(self.scene, self.camera, 0.0)
        case = shot.case
        self.words = (
            f"particles of {style.number(MM_PER_M * case['particle_radius'])} mm radius at "
            f"{style.number(abs(case['particle_velocity_y']))} m/s"
        )

    def paint(self, index: int, rows: pd.DataFrame) -> np.ndarray:
        if self.turns:
            self.layers = layers_at(self.scene, self.camera, float(self.shot.times[index]))
        return drawn(
            self.layers,
            self.shot.depth[index],
            self.top,
            rows[["x", "y", "z"]].to_numpy(),
            self.shot.case["particle_radius"],
            particle_tints(rows["particle"]),
        )
