"""The simulation set-up: plate, factory and particles at one time, and the wear map."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.figures.render import Camera, DrawnPlate, Patch, picture, tilted
from abradem.figures.wear_colours import no_wear_handle, only_worn, wear_colours
from abradem.wear.depths import depth_frames
from abradem.words.labels import LABELS

HEIGHT = 3.75
"""Height of the figure, inches."""

_EYE = np.array([-0.32, 0.46, 0.83])
_DISTANCE = 5.0
"""Distance of the camera, in heights of the view: large, so that perspective effects are small."""

_MARGIN = 1.18
_PICTURE = (0.0, 0.0, 0.60, 1.0)
_MAP = (0.69, 0.28, 0.205, 0.205 * style.PAGE / HEIGHT)


def draw(
    particles: pd.DataFrame, wear: pd.DataFrame, case: Mapping, setup: Mapping, measure: str
) -> Figure:
    """Draw `setup_figure`, or that of a geometry, from the last snapshot of a case.

    Parameters
    ----------
    particles, wear : pandas.DataFrame
        Snapshots from `abradem.simulation.snapshots`.
    case, setup : mapping
        Plain values of `Case` and `Setup`.
    measure : str
        Wear measure.
    """
    values = Setup.from_dict(setup)
    if values.geometry is not None:
        from abradem.figures.setup_geometry import geometry_figure

        return geometry_figure(particles, wear, case, values, measure)
    times, depth = depth_frames(wear, case, values, measure)
    last = particles[particles["time"] == times[-1]]
    return setup_figure(last, depth[-1], times[-1], case, values, measure)


def setup_figure(
    particles: pd.DataFrame,
    depth: np.ndarray,
    time: float,
    case: Mapping[str, float],
    setup: Setup,
    measure: str,
) -> Figure:
    """Plate, factory and particles in three dimensions, with the wear map as a call-out.

    Parameters
    ----------
    particles : pandas.DataFrame
        particle, x, y, z (m) at ``time``.
    depth : ndarray, shape (nx, nz)
        Wear depth of the facets at ``time``, mm.
    time : float
        s.
    case : mapping
        Arguments of `abradem.Case`.
    setup : Setup
    measure : str
        Wear measure of the depth, named in the caption.
    """
    with style.style():
        figure = Figure(figsize=(style.PAGE, HEIGHT))
        power = style.decade(float(depth.max()))
        top = max(float(depth.max()), 1e-300)
        plate = worn_plate(depth, top, case, setup)
        patch = factory_patch(case, setup)
        scene = figure.add_axes(_PICTURE)
        camera = _camera(plate, patch, scene)
        places = particles[["x", "y", "z"]].to_numpy()
        whole = within_frame(camera, places, case["particle_radius"])
        image = picture(
            camera, plate, places[whole], case["particle_radius"], patch,
            tints=particle_tints(particles["particle"])[whole],
        )  # fmt: skip
        scene.imshow(image, interpolation="none")
        scene.set_axis_off()
        scene.set_xlim(0, camera.width)
        scene.set_ylim(camera.height, 0)
        _annotate(scene, camera, plate, patch, case, setup)
        call_out = figure.add_axes(_MAP)
        mesh = wear_map_panel(call_out, depth / 10.0**power, top / 10.0**power, setup)
        bar = figure.colorbar(mesh, cax=call_out.inset_axes((1.05, 0.0, 0.055, 1.0)))
        bar.outline.set_linewidth(0.6)
        bar.set_label(f"Wear depth ({style.scaled_unit(power, 'mm')})")
        call_out.set_title(f"{style.letter(1)} wear of the plate after {time:.3g} s", loc="left")
        scene.text(
            0.01, 0.985, f"{style.letter(0)} set-up at {time:.3g} s", transform=scene.transAxes,
            va="top", fontsize=8.0,
        )  # fmt: skip
        for text in scene.texts:
            # Particles of a crowded jet lie behind the labels.
            text.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
        if (depth <= 0.0).any():
            figure.legend(handles=[no_wear_handle()], loc="lower right")
        style.caption(figure, _words(particles, case, setup, measure))
    return figure


def worn_plate(
    depth: np.ndarray, top: float, case: Mapping[str, float], setup: Setup
) -> DrawnPlate:
    """The plate coloured by its wear depth (nx, nz), mm; the colours end at ``top``, mm."""
    colours = wear_colours()(only_worn(np.clip(depth / top, 0.0, 1.0)))[..., :3]
    return DrawnPlate(setup.plate_length, setup.plate_width, case["plate_angle"], colours)


def factory_patch(case: Mapping[str, float], setup: Setup) -> Patch:
    """The factory patch, from which the particles are released."""
    height, tilt = setup.patch_place(case["factory_angle"])
    return Patch(setup.patch_length, setup.patch_width, height, tilt)


def within_frame(camera: Camera, places: np.ndarray, radius: float) -> np.ndarray:
    """Whether particles (n, 3), m, lie within the picture as a whole, not cut by its edge."""
    if not len(places):
        return np.zeros(0, dtype=bool)
    right, _, _ = camera.axes
    middles = camera.project(places)
    reach = np.linalg.norm(camera.project(places + radius * right) - middles, axis=1)[:, None]
    size = np.array([camera.width, camera.height])
    return ((middles - reach >= 0.0) & (middles + reach <= size)).all(axis=1)


def particle_tints(identities) -> np.ndarray:
    """Brightness factors (n,) of particles, slightly different so that they can be told apart."""
    golden = 0.618034
    return 1.1 + 0.3 * (np.asarray(identities) * golden % 1.0)


def wear_map_panel(panel: Axes, depth: np.ndarray, top: float, setup: Setup):
    """Draw the wear map of the plate in its own plane; returns the coloured mesh."""
    x = 1e3 * np.linspace(-0.5, 0.5, depth.shape[0] + 1) * setup.plate_length
    z = 1e3 * np.linspace(-0.5, 0.5, depth.shape[1] + 1) * setup.plate_width
    mesh = panel.pcolormesh(
        x, z, only_worn(depth.T), cmap=wear_colours(), vmin=0.0, vmax=top,
        rasterized=True,
    )  # fmt: skip
    panel.set_aspect("equal")
    panel.spines[["top", "right"]].set_visible(True)
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    panel.set_xlabel("Up the slope (mm)")
    panel.set_ylabel("Across (mm)")
    return mesh


def _camera(plate: DrawnPlate, patch: Patch, scene: Axes) -> Camera:
    """A camera that shows the whole plate and the patch, with sufficient pixels for print."""
    ends = [plate.point(i, j) for i in (-1.0, 1.0) for j in (-1.0, 1.0)]
    return framed(np.array([*patch.corners(), *ends]), *pixels_of(scene), _MARGIN)


def pixels_of(panel: Axes) -> tuple[int, int]:
    """Width and height of a panel in pixels of print."""
    box = panel.get_window_extent()
    scale = style.DPI / panel.figure.dpi
    return round(box.width * scale), round(box.height * scale)


def framed(shown: np.ndarray, width: int, height: int, margin: float) -> Camera:
    """A camera that shows points (n, 3), m, in the middle of a picture of that many pixels.

    ``margin`` is the size of the picture in that of the points.
    """
    target = 0.5 * (shown.min(axis=0) + shown.max(axis=0))
    eye = _EYE / np.linalg.norm(_EYE)
    view = float(np.ptp(shown, axis=0).max())
    camera = Camera(target + _DISTANCE * view * eye, target, view, width, height)
    pixels = camera.project(shown)
    # Centre the scene in the picture, then adjust the field of view.
    right, up, _ = camera.axes
    centre = 0.5 * (pixels.min(axis=0) + pixels.max(axis=0)) - 0.5 * np.array([width, height])
    target = target + (centre[0] * right - centre[1] * up) * view / height
    fill = np.ptp(pixels, axis=0) / np.array([width, height])
    view *= margin * float(fill.max())
    return Camera(target + _DISTANCE * view * eye, target, view, width, height)


def _annotate(scene, camera, plate, patch, case, setup) -> None:
    corner = plate.point(-1.0, 1.0, 0.0)
    reach = 0.36 * plate.length
    arc = [
        corner + 0.8 * reach * tilted(angle) for angle in np.linspace(0.0, case["plate_angle"], 40)
    ]
    _line(scene, camera, [corner, corner + reach * tilted(0.0)], ls=":")
    _line(scene, camera, arc)
    _word(
        scene, camera, corner + 0.95 * reach * tilted(0.45 * case["plate_angle"]),
        f"{_symbol('plate_angle')} = {_number(case['plate_angle'])}°", ha="left",
    )  # fmt: skip

    corners = patch.corners()
    _word(
        scene, camera, corners[corners[:, 1].argmax()], f"factory, {_number(1e3 * patch.length)} × "
        f"{_number(1e3 * patch.width)} mm, {_symbol('factory_angle')} = "
        f"{_number(case['factory_angle'])}°",
        ha="left", va="bottom", shift=(12, -1),
    )  # fmt: skip

    # The fall height is drawn beside the jet, in the plane through the centre of the plate.
    foot = np.array([0.62 * plate.length * plate.along[0], 0.0, 0.0])
    fall_height, _ = setup.patch_place(case["factory_angle"])
    head = foot + np.array([0.0, fall_height, 0.0])
    for height, end in ((0.0, foot), (fall_height, head)):
        _line(scene, camera, [(0.0, height, 0.0), end], ls=":", color=style.GREY)
    _arrow(scene, camera, foot, head, "<->")
    _word(
        scene, camera, 0.24 * foot + 0.76 * head,
        f"$H$ = {_number(1e3 * fall_height)} mm", ha="left", shift=(4, 0),
    )  # fmt: skip

    start = np.array([-0.75 * patch.length, 0.80 * fall_height, 0.0])
    speed = case["particle_velocity_y"]
    _arrow(scene, camera, start + np.array([0.0, 0.22 * fall_height, 0.0]), start, "->",
           color=style.RED)  # fmt: skip
    _word(
        scene, camera, start + np.array([0.0, 0.08 * fall_height, 0.0]),
        f"{_symbol('particle_velocity_y')} = {_number(speed)} m/s", ha="right", shift=(-4, 0),
        color=style.RED,
    )  # fmt: skip
    figure = scene.figure
    scene.annotate(
        "", xy=(0.64, 0.84), xytext=(0.64, 0.96), xycoords="figure fraction",
        arrowprops={"arrowstyle": "->", "lw": 0.9, "shrinkA": 0, "shrinkB": 0},
        annotation_clip=False,
    )  # fmt: skip
    figure.text(0.652, 0.90, "$g$", fontsize=8.0, va="center")
    middle = plate.point(0.15, 1.0)
    _word(
        scene, camera, middle, f"plate, {_number(1e3 * plate.length)} × "
        f"{_number(1e3 * plate.width)} mm", ha="left", va="top", shift=(8, -8),
    )  # fmt: skip


def _symbol(name: str) -> str:
    return f"${LABELS[name].tex}$"


def _number(value: float) -> str:
    return style.number(value, 4)


def _line(scene, camera, points, color=style.BLACK, ls="-") -> None:
    pixels = camera.project(points)
    scene.plot(pixels[:, 0], pixels[:, 1], color=color, ls=ls, lw=0.8)


def _arrow(scene, camera, start, end, kind, color=style.BLACK) -> None:
    tail, tip = camera.project([start, end])
    scene.annotate(
        "", xy=tip, xytext=tail,
        arrowprops={"arrowstyle": kind, "lw": 0.9, "color": color, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip


def _word(scene, camera, place, words, ha, va="center", shift=(0, 0), color=style.BLACK) -> None:
    scene.annotate(
        words, xy=camera.project(place)[0], xytext=shift, textcoords="offset points", ha=ha,
        va=va, fontsize=7.0, color=color,
    )  # fmt: skip


def _words(particles: pd.DataFrame, case: Mapping[str, float], setup: Setup, measure: str) -> str:
    rate = (
        f"{setup.mass_rate:g} kg/s"
        if setup.mass_rate is not None
        else f"{setup.number_rate:g} particles per second"
    )
    if setup.unplaced == "skip":
        rate = f"at most {rate}"
    here, _ = setup.patch_place(case["factory_angle"])
    if here == setup.fall_height:
        lowered = ""
    else:
        angle = _symbol("factory_angle")
        lowered = (
            f"$H$ is that of the case: {_number(1e3 * setup.fall_height)} mm at {angle} = 0, from "
            f"where the factory moves down an arc of {_number(1e3 * setup.arc_radius)} mm radius; "
        )
    return (
        f"{len(particles)} particles of {_number(1e3 * case['particle_radius'])} mm radius, "
        f"{rate}; {lowered}all other quantities in the middle of their ranges; "
        f"{_symbol('archard_constant')} = {style.number(case['archard_constant'])} 1/Pa; "
        f"wear measure: {measure}; particles at the edge of (a) are left out"
    )
