"""The page of a scene: it holds the snapshots, and a real browser plays them without a network."""

import base64
import json
import re
from dataclasses import asdict

import numpy as np
import pandas as pd
import pytest
from browser import ROOMS, log, opened, settle, show

from abradem.dem.model import Setup
from abradem.figures.wear_colours import NO_WEAR
from abradem.geometry.build import prepared
from abradem.geometry.kinds import Plates
from abradem.geometry.shapes import Rectangle
from abradem.geometry.turning import corners_at
from abradem.report import scene
from abradem.report.scene import scene_data, scene_page

CASE = {
    "plate_angle": 30.0, "factory_angle": 0.0, "particle_radius": 0.015,
    "particle_velocity_y": -2.0, "archard_constant": 2e-9,
}  # fmt: skip
PLATE = Setup(plate_length=0.3, plate_width=0.2, facet_size=0.1)
TIMES = np.array([0.0, 0.5, 1.0, 1.5])
MEASURE = "friction"


def snapshots(nx, nz):
    """Particles and wear at `TIMES`; no particles at first, and one far outside at the end."""
    rng = np.random.default_rng(3)
    rows = [
        {"time": time, "particle": number, "x": x, "y": 0.2 + y, "z": z}
        for index, time in enumerate(TIMES)
        for number, (x, y, z) in enumerate(rng.uniform(-0.05, 0.05, (3 * index, 3)))
    ]
    rows.append({"time": TIMES[-1], "particle": 99, "x": 5.0, "y": -0.1, "z": 0.0})
    facet_x, facet_z = (index.ravel() for index in np.indices((nx, nz)))
    work = rng.exponential(1.0, nx * nz)
    work[0] = 0.0
    wear = pd.concat(
        [
            pd.DataFrame({"time": time, "facet_x": facet_x, "facet_z": facet_z,
                          f"wear_{MEASURE}": time * work})
            for time in TIMES
        ]
    )  # fmt: skip
    return pd.DataFrame(rows), wear, work


def unpacked(given):
    numbers = np.frombuffer(base64.b64decode(given["text"]), dtype=f"<{given['type']}")
    return numbers.reshape(given["shape"])


def in_page(text):
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    return json.loads(found.group(1))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    particles, wear, _ = snapshots(*PLATE.facets)
    path = tmp_path_factory.mktemp("scene") / "scene.html"
    text = scene_page(particles, wear, "a <study>", CASE, asdict(PLATE), MEASURE)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser(page):
    with opened(page) as driver:
        yield driver


def test_the_page_holds_the_snapshots(page):
    particles, _, work = snapshots(*PLATE.facets)
    data = in_page(page.read_text(encoding="utf-8"))
    np.testing.assert_array_equal(unpacked(data["times"]), TIMES)
    np.testing.assert_array_equal(unpacked(data["counts"]), [0, 3, 6, 10])
    expected = particles[["x", "y", "z"]].to_numpy(dtype=np.float32)
    np.testing.assert_array_equal(unpacked(data["places"]), expected)
    np.testing.assert_array_equal(unpacked(data["identities"]), particles["particle"])
    # W J / A, in mm.
    area = PLATE.plate_length * PLATE.plate_width / len(work)
    depth = 1e3 * CASE["archard_constant"] * np.outer(TIMES, work) / area
    np.testing.assert_allclose(unpacked(data["depth"]), depth, rtol=1e-6)
    assert data["radius"] == CASE["particle_radius"] and data["no_wear"] == NO_WEAR.lower()
    assert data["top"] == pytest.approx(np.quantile(depth[-1][1:], 0.995))


def test_two_triangles_make_up_each_facet_of_the_plate(page):
    data = in_page(page.read_text(encoding="utf-8"))
    corners = unpacked(data["vertices"]).astype(float)[unpacked(data["triangles"]).astype(int)]
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    area = PLATE.plate_length * PLATE.plate_width / len(corners)
    np.testing.assert_allclose(0.5 * np.linalg.norm(normal, axis=1), area, rtol=1e-5)
    # A plate that rises along +x, seen from above.
    up = [-np.sin(np.radians(30.0)), np.cos(np.radians(30.0)), 0.0]
    np.testing.assert_allclose(normal / (2.0 * area), np.tile(up, (len(corners), 1)), atol=1e-5)


def test_a_surface_is_drawn_with_the_depth_of_its_cells():
    upper, lower = Rectangle(0.3, 0.2, 30.0), Rectangle(0.4, 0.2, 150.0, gap=0.1, drop=0.25)
    setup = Setup(facet_size=0.1, geometry=Plates((upper, lower)))
    surface = prepared(setup, CASE).surface
    particles, wear, work = snapshots(len(surface.triangles), 1)
    data = scene_data(particles, wear, "s", CASE, setup, MEASURE)
    np.testing.assert_array_equal(unpacked(data["triangles"]), surface.triangles)
    np.testing.assert_allclose(unpacked(data["vertices"]), surface.vertices, atol=1e-6)
    sides = surface.vertices[surface.triangles]
    lengths = np.linalg.norm(sides - np.roll(sides, 1, axis=1), axis=2)
    half = lengths.sum(axis=1) / 2.0
    # Heron's formula.
    area = np.sqrt(half * (half - lengths.T).prod(axis=0))
    depth = 1e3 * CASE["archard_constant"] * TIMES[-1] * work / area
    np.testing.assert_allclose(unpacked(data["depth"])[-1], depth, rtol=1e-6)
    assert data["cell"] == "cells" and len(data["factory"]) == 4


def test_the_parts_of_a_screw_turn_in_the_page(tmp_path):
    """The vertices that the browser draws are those of the surface at the time of the frame."""
    setup = Setup(
        facet_size=0.05, patch_length=0.05, patch_width=0.05,
        geometry={"shape": {"kind": "screw", "length": 0.4, "radius": 0.075, "shaft_radius": 0.02,
                            "pitch": 0.1, "clearance": 0.005, "rim": 0.1, "revolutions": 10.0}},
    )  # fmt: skip
    surface = prepared(setup, CASE).surface
    particles, wear, work = snapshots(len(surface.triangles), 1)
    data = scene_data(particles, wear, "s", CASE, setup, MEASURE)
    placed = unpacked(data["vertices"])[unpacked(data["triangles"]).astype(int)]
    np.testing.assert_allclose(placed, surface.vertices[surface.triangles], atol=1e-6)
    (turning,) = data["turning"]
    assert turning["spin"] == pytest.approx(np.pi / 3.0) and turning["direction"] == [1, 0, 0]
    text = scene_page(particles, wear, "s", CASE, asdict(setup), MEASURE)
    path = tmp_path / "scene.html"
    path.write_text(text, encoding="utf-8")
    with opened(path) as driver:
        drawn = driver.execute_script(
            "return document.getElementById('view').data?.slice(0, 2).map((one) =>"
            " [one.opacity, ['i', 'j', 'k'].map((corner) => ['x', 'y', 'z'].map((axis) =>"
            " one[corner].map((place) => one[axis][place])))])"
        )
    if drawn is None:
        pytest.skip("this browser has no WebGL")
    expected = 1e3 * corners_at(surface, TIMES[-1])
    for (opacity, found), worn in zip(drawn, (True, False), strict=True):
        assert (opacity == 1) == worn
        np.testing.assert_allclose(
            np.array(found).transpose(2, 0, 1), expected[(work > 0.0) == worn], atol=1e-3
        )


def test_many_snapshots_are_thinned_out_evenly_and_keep_the_last(monkeypatch):
    particles, wear, _ = snapshots(*PLATE.facets)
    size = 16 * len(particles) + 4 * len(wear)
    monkeypatch.setattr(scene, "MOST_BYTES", size // 2 + 1)
    data = scene_data(particles, wear, "s", CASE, PLATE, MEASURE)
    np.testing.assert_array_equal(unpacked(data["times"]), TIMES[1::2])
    np.testing.assert_array_equal(unpacked(data["counts"]), [3, 10])
    assert data["snapshots"] == 4 and unpacked(data["depth"]).shape[0] == 2


def test_the_same_snapshots_give_the_same_bytes_and_ask_for_nothing(page):
    particles, wear, _ = snapshots(*PLATE.facets)
    text = page.read_text(encoding="utf-8")
    assert scene_page(particles, wear, "a <study>", CASE, asdict(PLATE), MEASURE) == text
    assert "default-src 'none'" in text and not re.search(
        r"<(script|img|link)[^>]* (src|href)=", text
    )
    assert "a \\u003cstudy>" in text and text.count("</script>") == 3
    assert len(text) < 10e6


def clock(driver):
    return driver.find_element("id", "clock").text


def test_the_slider_changes_the_time_by_the_keyboard(browser):
    from selenium.webdriver.common.keys import Keys

    assert clock(browser) == "1.50 s of 1.50 s"
    slider = browser.find_element("id", "time")
    slider.send_keys(Keys.ARROW_LEFT)
    settle(browser)
    assert clock(browser) == "1.00 s of 1.50 s"
    assert slider.get_attribute("aria-valuetext") == "1.00 s"
    assert "6 particles of 15 mm radius" in browser.find_element("id", "words").text
    label = browser.find_element("id", "view").get_attribute("aria-label")
    assert "At 1.00 s: 6 particles" in label
    slider.send_keys(Keys.HOME)
    settle(browser)
    assert "0 particles" in browser.find_element("id", "words").text
    slider.send_keys(Keys.END)
    settle(browser)
    assert (
        "10 particles of 15 mm radius, 1 of them outside"
        in browser.find_element("id", "words").text
    )


def test_the_scene_drawn_has_spheres_of_the_radius_and_equal_axes(browser):
    settle(browser)
    drawn = browser.execute_script(
        "const {data, layout} = document.getElementById('view');"
        "const {xaxis, yaxis, zaxis, aspectratio} = layout.scene;"
        "return [['x', 'y', 'z'].map((name) => Array.from(data[1][name])), data[0].facecolor,"
        " [xaxis, yaxis, zaxis].map((one) => one.range[1] - one.range[0]),"
        " [aspectratio.x, aspectratio.y, aspectratio.z]]"
    )
    if drawn[0] is None:
        pytest.skip("this browser has no WebGL")
    points, colours, spans, ratio = np.array(drawn[0]).T, *drawn[1:]
    particles, _, _ = snapshots(*PLATE.facets)
    last = particles[(particles["time"] == TIMES[-1]) & (particles["particle"] != 99)]
    centres = 1e3 * last[["x", "y", "z"]].to_numpy()
    balls = points.reshape(len(centres), -1, 3)
    reach = np.linalg.norm(balls - centres[:, None], axis=2)
    np.testing.assert_allclose(reach, 15.0, rtol=1e-5)
    assert colours[:2] == [NO_WEAR.lower()] * 2 and NO_WEAR.lower() not in colours[2:]
    np.testing.assert_allclose(np.array(spans) / ratio, spans[0] / ratio[0])


def test_play_runs_to_the_end_and_pause_holds_the_time(browser):
    from selenium.webdriver.common.keys import Keys

    button = browser.find_element("id", "play")
    browser.find_element("id", "speed").send_keys("real")
    browser.find_element("id", "time").send_keys(Keys.HOME)
    settle(browser)
    button.send_keys(Keys.SPACE)
    assert button.text == "Pause"
    browser.execute_async_script(
        "const done = arguments[0];"
        "const look = () => document.getElementById('play').textContent === 'Play'"
        " ? done() : setTimeout(look, 50);"
        "look();"
    )
    assert clock(browser) == "1.50 s of 1.50 s"
    browser.find_element("id", "speed").send_keys("10 times")
    button.click()
    button.click()
    settle(browser)
    assert button.text == "Play" and clock(browser) == "0.00 s of 1.50 s"


@pytest.mark.parametrize("room", ROOMS)
def test_the_page_fits_the_screen(browser, room):
    show(browser, room)
    width, _ = ROOMS[room]
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width


def test_no_error_is_logged_and_no_request_leaves_the_page(browser):
    wrong = [one["message"] for one in log(browser, "browser") if one["level"] == "SEVERE"]
    assert wrong == []
    messages = [json.loads(one["message"])["message"] for one in log(browser, "performance")]
    asked = [
        one["params"]["request"]["url"]
        for one in messages
        if one["method"] == "Network.requestWillBeSent"
    ]
    assert asked and all(url.startswith(("file:", "data:", "blob:")) for url in asked), asked
