"""The set-up figure and the film of geometries: what is seen through what, names and measures."""

import re

import numpy as np
import pandas as pd
import pytest

from abradem.config import load_config, setup_dict, typical_case
from abradem.dem.model import Setup
from abradem.figures.film import frames, shot_of
from abradem.figures.render import Camera
from abradem.figures.render_surface import in_front, layers_of, picture_of_surface
from abradem.figures.setup import draw
from abradem.figures.setup_geometry import placed_case
from abradem.geometry.chute import transfer_chute
from abradem.geometry.mesh_files import write_stl
from abradem.quantities import WEAR_MEASURES

# A camera on the z axis that looks at the origin, 41 pixels for 0.41 m.
CAMERA = Camera(np.array([0.0, 0.0, 100.0]), np.zeros(3), 0.41, 41, 41)
SQUARE = np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]])
FAR_PATCH = SQUARE + np.array([0.0, 9.0, 0.0])
NO_RIMS = np.zeros((0, 2, 3))
RED = np.array([[1.0, 0.0, 0.0]])


def wall(z):
    """A square as two triangles at a height of z towards the camera."""
    return (SQUARE + np.array([0.0, 0.0, z]))[[[0, 1, 2], [0, 2, 3]]]


def middle(corners, cover, spheres=(), radius=0.05, colours=RED):
    """Colour of the pixel in the middle, seen along -z."""
    layers = layers_of(CAMERA, corners, NO_RIMS, FAR_PATCH)
    count = len(corners)
    image = picture_of_surface(
        layers, np.resize(colours, (count, 3)), np.resize(cover, count), np.zeros(count, bool),
        np.array(spheres).reshape(-1, 3), radius,
    )  # fmt: skip
    assert image.shape == (41, 41, 3)
    return image[20, 17]


def test_a_wall_takes_its_cover_of_what_is_behind_it():
    np.testing.assert_allclose(middle(wall(0.0), [1.0]), [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(middle(wall(0.0), [0.3]), [1, 0.7, 0.7], atol=1e-12)
    # Two walls: what the far one lets through, the near one takes again.
    both = np.concatenate([wall(-0.05), wall(0.05)])
    np.testing.assert_allclose(middle(both, [0.3]), [1, 0.49, 0.49], atol=1e-12)
    # The order is that of the distance, not that of the triangles.
    colours = np.array([[1.0, 0, 0], [1, 0, 0], [0, 0, 1], [0, 0, 1]])
    near_blue = middle(both, [1.0], colours=colours)
    near_red = middle(both[[2, 3, 0, 1]], [1.0], colours=colours)
    np.testing.assert_allclose([near_blue, near_red], [[0, 0, 1], [1, 0, 0]], atol=1e-12)


def test_what_is_in_front_is_the_nearest_wall_where_it_covers_the_other():
    both = np.concatenate([wall(-0.05), wall(0.05)])
    assert in_front(layers_of(CAMERA, both, NO_RIMS, FAR_PATCH), 4).tolist() == [0, 0, 1, 1]
    aside = np.concatenate([wall(-0.05), 0.1 * wall(0.05)[:1]])
    assert in_front(layers_of(CAMERA, aside, NO_RIMS, FAR_PATCH), 3).tolist() == [1, 1, 1]


def test_a_particle_hides_what_is_behind_it_and_is_seen_through_a_wall():
    alone = middle(wall(-1.0), [1.0], [(-0.03, 0.0, 0.0)])
    assert np.ptp(alone) < 0.2
    before = middle(wall(0.1), [0.3], [(-0.03, 0.0, 0.0)])
    np.testing.assert_allclose(before, 0.7 * alone + 0.3 * np.array([1.0, 0.0, 0.0]), atol=1e-12)


def test_a_particle_between_the_light_and_a_wall_casts_a_shadow():
    from abradem.figures.render import LIGHT

    place = np.array([-0.03, 0.0, 0.0])
    shaded = middle(wall(0.0), [1.0], [place - 0.5 * LIGHT], radius=0.02)
    np.testing.assert_allclose(shaded, [0.55, 0, 0], atol=1e-12)
    lit = middle(wall(0.0), [1.0], [place + 0.5 * LIGHT - [0.0, 0.0, 0.3]], radius=0.02)
    np.testing.assert_allclose(lit, [1, 0, 0], atol=1e-12)


CHAIN = {
    "kind": "plates",
    "plates": [
        {"length_mm": 300, "width_mm": 200, "angle": "plate_angle", "name": "upper_plate"},
        {"length_mm": [200, 400], "width_mm": 200, "angle": 150, "gap_mm": 300, "drop_mm": 200,
         "belt_m_s": 1.5},
    ],
}  # fmt: skip
KINDS = {
    "plates": (CHAIN, ["upper plate", "300 × 200 mm, 35°", "300 × 200 mm, 150°", "belt, 1.5 m/s",
                       "factory", "35°", "30°", "H", "3 m/s", "removed below"]),
    "arc": ({"kind": "arc"}, ["radius 400 mm", "width 300 mm", "80°", "10°"]),
    "screw": (
        {"kind": "screw", "removal_box_mm": [[-500, -300, -300], [900, 600, 300]]},
        ["flight", "pitch 100 mm", "60 rev/min", "shaft", "trough", "removed outside"],
    ),
    "mesh": (
        {"kind": "mesh", "mesh": {"file": "chute.stl"}, "factory_centre_mm": [600, 1000, 0],
         "jet_direction": [-1, 0, 0]},
        ["hood", "back", "sides", "spoon"],
    ),
}  # fmt: skip


@pytest.fixture(params=KINDS)
def of_kind(request, tmp_path, monkeypatch):
    """Case, set-up, snapshots and the words that the figure of a kind of geometry shows."""
    monkeypatch.chdir(tmp_path)
    if request.param == "mesh":
        write_stl(transfer_chute(facet=0.2), "chute.stl")
    geometry, words = KINDS[request.param]
    patch = {"patch_length_mm": 60, "patch_width_mm": 60}
    config = load_config(
        {"study": "s", "simulation": {"geometry": geometry, "factory": patch,
                                      "plate": {"facet_size_mm": 100}}}
    )  # fmt: skip
    case, setup = typical_case(config), setup_dict(config)
    placed = placed_case(case, Setup.from_dict(setup))
    cells = len(placed.surface.triangles)
    centre = np.array(placed.feed.centre)
    particles = pd.DataFrame(
        [
            {"time": time, "particle": k, "x": x, "y": y, "z": z}
            for time in (0.0, 0.1)
            for k, (x, y, z) in enumerate(centre - [[0, 0.05, 0], [0.02, 0.1, 0.01]])
        ]
    )
    work = np.where(np.arange(cells) % 3, 0.0, 1.0 + np.arange(cells))
    wear = pd.concat(
        [
            pd.DataFrame({"time": time, "facet_x": np.arange(cells), "facet_z": 0,
                          **{f"wear_{one}": 10.0 * time * work for one in WEAR_MEASURES}})
            for time in (0.0, 0.1)
        ]
    )  # fmt: skip
    return request.param, case, setup, particles, wear, words


def texts(figure):
    found = [one for axes in figure.axes for one in axes.texts] + list(figure.texts)
    return " | ".join(one.get_text() for one in found)


def test_the_set_up_of_a_geometry_names_parts_measures_and_limits(of_kind):
    kind, case, setup, particles, wear, words = of_kind
    figure = draw(particles, wear, case, setup, "friction")
    shown = texts(figure)
    for word in words:
        assert word in shown, (kind, word, shown)
    assert ("H" in re.findall(r"\$(\w)\$ = ", shown)) == (kind != "mesh")
    assert "2 particles of 15 mm radius" in figure.get_label()


def test_a_film_of_a_geometry_has_a_frame_for_each_time(of_kind):
    kind, case, setup, particles, wear, _ = of_kind
    values = Setup.from_dict(setup)
    shot = shot_of(case, particles, wear, values, "friction")
    made = list(frames([shot], values, 120))
    assert len(made) == 2 and made[0].shape == made[1].shape
    assert made[0].shape[0] % 2 == 0 and made[0].shape[1] == 120
    # Wear grows, and the flight of a screw turns.
    assert (made[0] != made[1]).any(), kind
