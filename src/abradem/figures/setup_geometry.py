"""The set-up of a geometry: in space with its particles, and from the side with its measures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from abradem.dem.model import Setup
from abradem.dem.surface import Feed, Surface, cell_areas
from abradem.figures import style
from abradem.figures.render import Camera, patch_corners
from abradem.figures.render_surface import Layers, in_front, layers_of, picture_of_surface
from abradem.figures.setup import framed, particle_tints, pixels_of, within_frame
from abradem.figures.wear_colours import wear_colours
from abradem.geometry.build import geometry_described, prepared
from abradem.geometry.kinds import Arc, Geometry, Plates, Screw
from abradem.geometry.outline import outline
from abradem.geometry.turning import corners_at
from abradem.units import MM_PER_M
from abradem.wear.depths import cell_depth_frames
from abradem.words.labels import LABELS

HEIGHT = 3.6
"""Height of the figure, inches."""

BARE = np.array([0.76, 0.81, 0.85])
BARE_COVER, WORN_COVER = 0.30, 0.85
"""Cover of the cells without and with wear: walls do not hide what is behind them."""

MOST_NAMED = 8
"""Largest number of parts with a name in the picture, the largest ones."""

FARTHEST = 1.5
"""How far the removal box is shown beyond the geometry and the factory, in their extent."""

_SPACE = (0.0, 0.0, 0.42, 1.0)
_NAMES = 0.425
_SIDE = (0.655, 0.13, 0.335, 0.78)
_MARGIN = 1.12


class PlacedCase(NamedTuple):
    """A case on a geometry: the set-up with its surface and factory, and its description.

    ``above``: whether the factory is at its fall height above the surface, not at a given place.
    """

    setup: Setup
    surface: Surface
    feed: Feed
    geometry: Geometry
    above: bool


def placed_case(case: Mapping[str, float], setup: Setup) -> PlacedCase:
    """Return the surface and the factory of a case on a geometry."""
    setup = prepared(setup, case)
    if setup.surface is None or setup.feed is None:
        raise ValueError("the set-up has a plate")
    given = setup.geometry
    above = not isinstance(given, Mapping) or given.get("centre") is None
    return PlacedCase(setup, setup.surface, setup.feed, geometry_described(setup, case), above)


def geometry_figure(
    particles: pd.DataFrame,
    wear: pd.DataFrame,
    case: Mapping[str, float],
    setup: Setup,
    measure: str,
) -> Figure:
    """Geometry, factory and particles in space, and from the side with the removal limits.

    Parameters
    ----------
    particles, wear : pandas.DataFrame
        Snapshots from `abradem.simulation.snapshots`; the last is drawn.
    case : mapping
        Quantities of the case, with those of the geometry.
    setup : Setup
        With a geometry.
    measure : str
        Wear measure of the colours.
    """
    scene = placed_case(case, setup)
    times, depth = cell_depth_frames(wear, case, scene.surface, measure)
    last = particles[particles["time"] == times[-1]]
    with style.style():
        figure = Figure(figsize=(style.PAGE, HEIGHT))
        space = figure.add_axes(_SPACE)
        camera = view_of(scene, *pixels_of(space), _MARGIN)
        places = last[["x", "y", "z"]].to_numpy()
        whole = within_frame(camera, places, case["particle_radius"])
        top = float(depth[-1].max())
        layers = layers_at(scene, camera, times[-1])
        image = drawn(
            layers, depth[-1], top if top > 0.0 else 1.0,
            places[whole], case["particle_radius"],
            particle_tints(last["particle"])[whole],
        )  # fmt: skip
        space.imshow(image, interpolation="none")
        space.set_axis_off()
        space.set_xlim(0, camera.width)
        space.set_ylim(camera.height, 0)
        space.text(
            0.02, 0.985, f"{style.letter(0)} set-up at {times[-1]:.3g} s",
            transform=space.transAxes, va="top", fontsize=8.0,
        )  # fmt: skip
        _name_parts(figure, space, camera, scene, times[-1], in_front(layers, len(depth[-1])))
        side = figure.add_axes(_SIDE)
        _draw_side(side, scene, case)
        side.set_title(f"{style.letter(1)} from the side, along $-z$", loc="left")
        style.caption(figure, _words(last, case, scene, measure, top))
    return figure


def view_of(scene: PlacedCase, width: int, height: int, margin: float) -> Camera:
    """A camera that shows the geometry and the factory."""
    return framed(
        np.concatenate([scene.surface.vertices, patch_corners(scene.feed)]), width, height, margin
    )


def layers_at(scene: PlacedCase, camera: Camera, time: float) -> Layers:
    """What the camera sees of surface and factory at a time (s), see `render_surface`."""
    corners = corners_at(scene.surface, time)
    return layers_of(
        camera, corners, outline(scene.surface, corners), patch_corners(scene.feed)
    )  # fmt: skip


def drawn(
    layers: Layers, depth: np.ndarray, top: float, places: np.ndarray, radius: float,
    tints: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """The picture of a surface coloured by its wear depth (t,), and of particles (n, 3)."""
    worn = depth > 0.0
    colours = np.where(
        worn[:, None], wear_colours()(np.clip(depth / top, 0.0, 1.0))[:, :3], BARE
    )  # fmt: skip
    cover = np.where(worn, WORN_COVER, BARE_COVER)
    return picture_of_surface(layers, colours, cover, ~worn, places, radius, tints)


def _name_parts(
    figure: Figure, space: Axes, camera: Camera, scene: PlacedCase, time: float, front: np.ndarray
) -> None:
    """Write the names of the parts and of the factory beside the picture, with leaders.

    A leader ends on a cell of its part with nothing before it (``front``), if there is one.
    """
    surface = scene.surface
    area = cell_areas(surface)
    middle = corners_at(surface, time).mean(axis=1)
    total = [float(area[surface.part == part].sum()) for part in range(len(surface.part_names))]
    named = sorted(range(len(total)), key=lambda part: -total[part])[:MOST_NAMED]
    anchors = []
    for part in named:
        cells = np.flatnonzero(surface.part == part)
        cells = cells[front[cells]] if front[cells].any() else cells
        pixels = camera.project(middle[cells])
        # The cell of the part that is farthest to the right of its middle, but not at its end.
        reach = np.quantile(pixels[:, 0], 0.8)
        near = np.argmin(
            np.abs(pixels[:, 0] - reach) + np.abs(pixels[:, 1] - np.median(pixels[:, 1]))
        )
        anchors.append((pixels[near], _part_words(scene, part), style.BLACK))
    patch = camera.project(patch_corners(scene.feed))
    anchors.append((patch[patch[:, 0].argmax()], _factory_words(scene.feed), style.BLUE))
    slots = _label_slots(anchors, camera)
    for (pixel, words, colour), place in zip(anchors, slots, strict=True):
        space.annotate(
            words, xy=pixel, xycoords="data", xytext=(_NAMES, place),
            textcoords="figure fraction", fontsize=6.5, va="center", color=colour,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "lw": 0.5, "color": colour, "shrinkA": 1, "shrinkB": 0,
                        "relpos": (0.0, 0.5)},
        )  # fmt: skip
    figure.text(0.385, 0.945, "$g$", fontsize=8.0, va="center")
    space.annotate(
        "", xy=(0.375, 0.89), xytext=(0.375, 0.98), xycoords="figure fraction",
        arrowprops={"arrowstyle": "->", "lw": 0.9, "shrinkA": 0, "shrinkB": 0},
        annotation_clip=False,
    )  # fmt: skip


def _label_slots(anchors: list[tuple[np.ndarray, str, str]], camera: Camera) -> list[float]:
    """Sort labels in place, and return the heights of their middles as shares of the figure.

    Labels are in a column beside the picture, each as near to its anchor as the one above it
    allows; of two whose leaders would cross, the places are exchanged.
    """
    anchors.sort(key=lambda one: one[0][1])
    places = _column(anchors, camera)
    for _ in anchors:
        crossed = False
        for one in range(len(anchors) - 1):
            (a, b), (c, d) = (
                (np.array([anchors[k][0][0], -anchors[k][0][1]]),
                 np.array([1.02 * camera.width, (places[k] - 1.0) * camera.height]))
                for k in (one, one + 1)
            )  # fmt: skip
            if _cross(a, b, c, d):
                anchors[one], anchors[one + 1] = anchors[one + 1], anchors[one]
                places = _column(anchors, camera)
                crossed = True
        if not crossed:
            break
    return places


def _column(anchors: list[tuple[np.ndarray, str, str]], camera: Camera) -> list[float]:
    heights = [0.03 * (1 + words.count("\n")) + 0.02 for _, words, _ in anchors]
    places: list[float] = []
    ceiling = 0.99
    for (pixel, _, _), height in zip(anchors, heights, strict=True):
        places.append(min(1.0 - pixel[1] / camera.height, ceiling - 0.5 * height))
        ceiling = places[-1] - 0.5 * height
    # Moved up as a whole where they end too low.
    lift = max(0.0, 0.01 - ceiling)
    return [place + lift for place in places]


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> bool:
    """Whether the segments ab and cd cross."""

    def side(p, q, r) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


def _part_words(scene: PlacedCase, part: int) -> str:
    """Name, measures and motion of a part."""
    surface, geometry = scene.surface, scene.geometry
    lines = [surface.part_names[part].replace("_", " ")]
    if isinstance(geometry, Plates):
        plate = geometry.plates[part]
        lines.append(f"{_mm(plate.length)} × {_mm(plate.width)} mm, {_number(plate.angle)}°")
    elif isinstance(geometry, Arc):
        lines += [f"radius {_mm(geometry.radius)} mm", f"width {_mm(geometry.width)} mm"]
    elif isinstance(geometry, Screw) and surface.part_names[part] == "flight":
        lines += [f"radius {_mm(geometry.radius)} mm", f"pitch {_mm(geometry.pitch)} mm"]
    turns = float(surface.angular_velocity[part]) * 60.0 / (2.0 * math.pi)
    belt = float(np.linalg.norm(surface.velocity[part]))
    if turns:
        lines.append(f"{_number(turns)} rev/min")
    if belt:
        lines.append(f"belt, {_number(belt)} m/s")
    return "\n".join(lines)


def _factory_words(feed: Feed) -> str:
    length, width = (float(np.linalg.norm(edge)) for edge in (feed.along, feed.across))
    return f"factory\n{_mm(length)} × {_mm(width)} mm"


def _draw_side(panel: Axes, scene: PlacedCase, case: Mapping[str, float]) -> None:
    """Draw the geometry, the factory, the jet and the limits of removal in the plane of x and y."""
    surface, feed = scene.surface, scene.feed
    corners = surface.vertices[surface.triangles]
    flat = MM_PER_M * corners[..., :2]
    panel.add_collection(
        PolyCollection(list(flat), facecolors=(*BARE, 0.25), edgecolors="none", rasterized=True)
    )
    lines = MM_PER_M * outline(surface, corners)[..., :2]
    panel.add_collection(LineCollection(list(lines), colors="#444950", linewidths=0.7))
    patch = MM_PER_M * patch_corners(feed)[:, :2]
    panel.plot(*patch[[0, 2]].T, color=style.BLUE, lw=2.2, solid_capstyle="butt")
    shown = np.concatenate([flat.reshape(-1, 2), patch])
    low, high = shown.min(axis=0), shown.max(axis=0)
    size = float((high - low).max())
    _draw_removal(panel, scene, low, high, size)
    _draw_jet(panel, feed, case, size)
    if scene.above:
        _draw_fall(panel, scene, size)
    for place, direction in _slopes(scene.geometry):
        _draw_angle(panel, MM_PER_M * place, direction, 0.13 * size)
    panel.set_aspect("equal")
    panel.margins(0.06)
    panel.set_xlabel("$x$ (mm)", labelpad=1.5)
    panel.set_ylabel("$y$ (mm)", labelpad=1.5)
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _draw_removal(panel: Axes, scene: PlacedCase, low, high, size: float) -> None:
    """Draw the box outside which particles are removed, or the level below which they are."""
    box = scene.setup.removal_box
    look: dict[str, Any] = {"color": style.GREY, "lw": 0.8, "ls": (0, (4, 3))}
    if box is None:
        level = MM_PER_M * (float(scene.surface.vertices[:, 1].min()) - scene.setup.removal_depth)
        panel.plot([low[0], high[0]], [level, level], **look)
        place = (0.5 * (low[0] + high[0]), level)
        words = "removed below"
    else:
        near, far = (MM_PER_M * np.array(corner[:2]) for corner in box)
        # A box far away would make the geometry small.
        near = np.maximum(near, low - FARTHEST * size)
        far = np.minimum(far, high + FARTHEST * size)
        panel.add_patch(Rectangle(tuple(near), *(far - near), fill=False, **look))
        place = (0.5 * (near[0] + far[0]), near[1])
        words = "removed outside"
    panel.annotate(
        words, xy=place, xytext=(0, 2), textcoords="offset points", ha="center", va="bottom",
        fontsize=6.5, color=style.GREY,
    )  # fmt: skip


def _draw_jet(panel: Axes, feed: Feed, case: Mapping[str, float], size: float) -> None:
    speed = abs(case["particle_velocity_y"])
    direction = np.array(feed.direction[:2]) / np.linalg.norm(feed.direction)
    begin = MM_PER_M * np.array(feed.centre[:2])
    end = begin + 0.2 * size * direction
    panel.annotate(
        "", xy=tuple(end), xytext=tuple(begin),
        arrowprops={"arrowstyle": "->", "lw": 1.0, "color": style.RED, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    across = abs(direction[0]) > abs(direction[1])
    panel.annotate(
        f"{_number(speed)} m/s", xy=0.5 * (begin + end),
        xytext=(0, 4) if across else (-4, 0), textcoords="offset points",
        ha="center" if across else "right", va="bottom" if across else "center", fontsize=6.5,
        color=style.RED,
    )  # fmt: skip


def _draw_fall(panel: Axes, scene: PlacedCase, size: float) -> None:
    """Draw the height of the factory above the geometry."""
    middle, top, _ = (MM_PER_M * number for number in scene.feed.centre)
    fall = MM_PER_M * scene.setup.fall_height
    x = middle + 0.5 * MM_PER_M * float(np.linalg.norm(scene.feed.along)) + 0.08 * size
    for y in (top, top - fall):
        panel.plot([middle, x], [y, y], color=style.GREY, lw=0.6, ls=":")
    panel.annotate(
        "", xy=(x, top), xytext=(x, top - fall),
        arrowprops={"arrowstyle": "<->", "lw": 0.7, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    panel.annotate(
        f"$H$ = {_number(fall)} mm", xy=(x, top - 0.5 * fall), xytext=(5, 0), rotation=90.0,
        textcoords="offset points", fontsize=6.5, va="center", ha="left",
    )  # fmt: skip


def _slopes(geometry: Geometry) -> list[tuple[np.ndarray, float]]:
    """Ends (x, y), m, of plates and arcs, and the direction in which these run from there, deg."""
    if isinstance(geometry, Plates):
        shape = geometry.shape(LARGE)
        found = []
        for part, plate in enumerate(geometry.plates):
            ends = shape.vertices[shape.triangles[shape.part == part]].reshape(-1, 3)
            # A plate runs from its first end along (-cos, -sin) of its angle; shown is its lower.
            down = math.sin(math.radians(plate.angle)) >= 0.0
            found.append((ends[ends[:, 1].argmin(), :2], plate.angle + (0.0 if down else 180.0)))
        return found
    if isinstance(geometry, Arc):
        line = geometry.shape(LARGE).vertices[:, :2]
        return [(line[0], 180.0 + geometry.begin), (line[-1], geometry.end)]
    return []


LARGE = 1e3
"""A facet size that divides no plate, m."""


def _draw_angle(panel: Axes, place: np.ndarray, direction: float, reach: float) -> None:
    """Draw the angle at a place (x, y) between the horizontal and a direction, deg."""
    side = 1.0 if math.cos(math.radians(direction)) >= 0.0 else -1.0
    level = 0.0 if side > 0.0 else 180.0
    # The same direction, at most 90 degrees away from the horizontal.
    direction = level + (direction - level + 180.0) % 360.0 - 180.0
    panel.plot([place[0], place[0] + side * reach], [place[1]] * 2, color=style.BLACK, lw=0.6,
               ls=":")  # fmt: skip
    turns = np.radians(np.linspace(level, direction, 30))
    arc = place + 0.8 * reach * np.column_stack([np.cos(turns), np.sin(turns)])
    panel.plot(*arc.T, color=style.BLACK, lw=0.6)
    middle = math.radians(0.5 * (level + direction))
    at = place + 0.95 * reach * np.array([math.cos(middle), math.sin(middle)])
    panel.text(
        float(at[0]), float(at[1]), f"{_number(abs(direction - level))}°", fontsize=6.5,
        va="center", ha="left" if side > 0.0 else "right",
    )  # fmt: skip


def _mm(length: float) -> str:
    return _number(MM_PER_M * length)


def _number(value: float) -> str:
    return style.number(value, 4)


def _words(
    particles: pd.DataFrame, case: Mapping[str, float], scene: PlacedCase, measure: str, top: float
) -> str:
    setup = scene.setup
    rate = (
        f"{setup.mass_rate:g} kg/s"
        if setup.mass_rate is not None
        else f"{setup.number_rate:g} particles per second"
    )
    count = len(scene.surface.part_names)
    more = f"; {count - MOST_NAMED} smaller parts are not named" if count > MOST_NAMED else ""
    deepest = f"up to {style.number(MM_PER_M * 1e-3 * top)} mm" if top > 0.0 else "none yet"
    symbol = f"${LABELS['archard_constant'].tex}$"
    return (
        f"{len(particles)} particles of {_mm(case['particle_radius'])} mm radius, {rate}; "
        f"particles at the edge of (a) are left out; wear depth ({measure}, {symbol} = "
        f"{style.number(case['archard_constant'])} 1/Pa) in colours from yellow to red, {deepest}, "
        f"cells without wear are seen through{more}"
    )
