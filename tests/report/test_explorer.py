"""The explorer in a real browser: its numbers are those of the surrogate, and nothing leaves it.

The browser is Debian's chromium with its driver (``apt-get install chromium-driver``).
"""

import itertools
import json

import geometry_tables
import numpy as np
import pandas as pd
import pytest
from browser import ROOMS, log, opened, settle, show, wait_for
from tables import product_law

from abradem.learning.physical.distil import Settings
from abradem.learning.physical.problem import problem
from abradem.learning.physical.wear_maps import PlateSides, wear_maps
from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.report.explorer import SECTIONS, explorer_data, explorer_page
from abradem.report.page_data import stored
from abradem.surrogate.domain import Domain
from abradem.surrogate.groups import GROUP_NAMES, Jet, group_matrix
from abradem.surrogate.maps import MapSurrogate
from abradem.surrogate.model import Surrogate

JET = Jet(0.385, 9.81, 42.0, None, 0.09, 0.09, "arc", 0.235)
PRESETS = {"granite": {"particle_density": 2650.0, "restitution": 0.5}}
TARGET = "wear_friction_p99"
LOCAL = {"wear_friction_mean": None, "wear_friction_max": TARGET}
"""Other places of the plate, and the place that each cannot be below."""


def random_surrogate(fixed=()):
    """Description and arrays of a surrogate with networks of random weights."""
    rng = np.random.default_rng(4)
    width = len(GROUP_NAMES)
    arrays = {
        "group_mean": rng.normal(0.0, 1.0, width),
        "group_scale": rng.uniform(0.5, 2.0, width),
    }
    for prefix in ("", *(f"local.{name}." for name in LOCAL)):
        arrays[f"{prefix}conformal"] = np.sort(rng.exponential(1.0, 60))
        for network, hidden in (("mean", (16, 16)), ("spread", (8,))):
            sizes = (width, *hidden, 1)
            for place, (before, after) in enumerate(itertools.pairwise(sizes)):
                weights = rng.normal(0.0, 0.6 / np.sqrt(before), (before, after))
                arrays[f"{prefix}{network}_weights_{place}"] = weights.astype(np.float32)
                biases = rng.normal(-1.0 if after == 1 else 0.0, 0.1, after)
                arrays[f"{prefix}{network}_biases_{place}"] = biases.astype(np.float32)
    drawn = {row.name: rng.uniform(*row.paper_range, 80) for row in SAMPLED}
    rows = (group_matrix(drawn, JET) - arrays["group_mean"]) / arrays["group_scale"]
    domain = Domain.of(rows, rng.uniform(0.0, 0.4, width))
    arrays |= {"domain_rows": domain.rows, "domain_slopes": domain.slopes}
    features = []
    for row in SAMPLED:
        low, high = row.paper_range
        ends = [low, low] if row.name in fixed else [low, high]
        features.append({"name": row.name, "unit": row.unit, "training_range": ends})
    description = {
        "kind": "surrogate",
        "jet": JET._asdict(),
        "groups": list(GROUP_NAMES),
        "target": {"name": TARGET, "unit": "mm/s", "element_size": 0.03},
        "features": features,
        "training_rows": 40,
        "local": [
            {"target": {"name": name, "unit": "mm/s"}, **({"at_least": bound} if bound else {})}
            for name, bound in LOCAL.items()
        ],
        "domain": {"limit": domain.limit},
    }
    return description, arrays


@pytest.fixture(scope="module")
def dataset():
    table = product_law(40)
    return table.assign(**{TARGET: 3.0 * table["wear_total_mean"]})


@pytest.fixture(scope="module")
def maps(dataset):
    given = problem(dataset, JET, TARGET)
    along = np.linspace(-0.5, 0.5, 6)[:, None]
    spot = np.exp(-((along - 0.3 * given.groups[:, 8][:, None, None]) ** 2) / 0.1)
    worn = given.table.target[:, None, None] * np.repeat(spot, 4, axis=2)
    model, _ = wear_maps(given, worn, PlateSides(0.3, 0.2), "friction", repeats=2)
    return MapSurrogate(*json_and_back(*model))


def json_and_back(description, arrays):
    """A model as it is read from its files."""
    return json.loads(json.dumps(description, default=float)), arrays


@pytest.fixture(scope="module")
def page(dataset, maps, tmp_path_factory):
    text = explorer_page(random_surrogate(), maps, dataset, "a <study>", PRESETS)
    path = tmp_path_factory.mktemp("explorer") / "explorer.html"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser(page):
    """A browser that shows the page, with its log of requests."""
    with opened(page) as driver:
        yield driver


def type_value(driver, name, text):
    from selenium.webdriver.common.keys import Keys

    field = driver.find_element("id", f"value-{name}")
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys(text, Keys.ENTER)
    return field


def numbers(driver):
    """The numbers of the first place: rate and interval, mm/s, and hours."""
    row = driver.find_element("css selector", "#rates tbody tr")
    return [
        float(row.get_attribute(f"data-{name}")) for name in ("rate", "lower", "upper", "hours")
    ]


def test_the_model_in_the_page_gives_the_numbers_of_the_surrogate(browser, maps):
    surrogate = Surrogate(*random_surrogate())
    rng = np.random.default_rng(0)
    for _ in range(25):
        values = {row.name: float(rng.uniform(*row.paper_range)) for row in SAMPLED}
        found = browser.execute_script("return Model.predict(arguments[0], 0.9)", values)
        every = surrogate.predict_all(values, 0.9).values()
        for one, expected in zip(found, every, strict=True):
            for name in ("rate", "lower", "upper"):
                assert one[name] == pytest.approx(getattr(expected, name)[0], rel=1e-6)
        drawn = browser.execute_script("return Array.from(Model.wearMap(arguments[0]))", values)
        np.testing.assert_allclose(drawn, maps.predict(values).rate.ravel(), rtol=1e-9)


def test_typed_values_and_what_is_shown_are_those_of_the_command(browser, maps):
    typed = {
        "plate_angle": "0.5 rad", "particle_radius": "2.1 cm", "particle_velocity_y": "-18 km/h",
        "particle_density": "2.65 g/cm³", "particle_shear_modulus": "4000 MPa",
        "static_friction": "0.43", "archard_constant": "1e-9",
    }  # fmt: skip
    for name, text in typed.items():
        assert type_value(browser, name, text).get_attribute("aria-invalid") != "true"
    settle(browser)
    command = browser.find_element("id", "command").text.replace("\\\n", "").split()
    given = dict(word.split("=") for word in command if "=" in word)
    assert list(given) == [name for names in SECTIONS.values() for name in names]
    values = {name: float(text) for name, text in given.items()}
    assert values["particle_radius"] == 0.021 and values["particle_velocity_y"] == -5.0
    assert values["plate_angle"] == pytest.approx(np.degrees(0.5), rel=1e-12)
    expected = Surrogate(*random_surrogate()).predict(values, 0.95)
    hours = expected.hours_to(5.0)[0][0]
    found = numbers(browser)
    assert found == pytest.approx([*(float(one[0]) for one in expected[:3]), hours], rel=1e-6)
    shown = browser.find_element("id", "headline-rate").text
    assert shown == f"{float(f'{expected.rate[0]:.4g}')!r} mm/s"
    drawn = json.loads(browser.find_element("id", "map").get_attribute("data-rates"))
    mean = Surrogate(*random_surrogate()).predict(values, target="wear_friction_mean").rate
    np.testing.assert_allclose(drawn, maps.predict(values, mean).rate.ravel(), rtol=1e-9)
    assert np.mean(drawn) == pytest.approx(mean[0], rel=1e-9)


def test_the_keyboard_moves_a_slider_and_all_numbers_follow(browser):
    from selenium.webdriver.common.keys import Keys

    before = numbers(browser)
    slider = browser.find_element("id", "slider-archard_constant")
    slider.send_keys(Keys.ARROW_RIGHT)
    settle(browser)
    after = numbers(browser)
    typed = float(browser.find_element("id", "value-archard_constant").get_attribute("value"))
    # The wear is proportional to the Archard constant, the hours to its inverse.
    assert typed > 1e-9
    ratio = typed / 1e-9
    assert after[:3] == pytest.approx([ratio * one for one in before[:3]], rel=1e-9)
    assert after[3] == pytest.approx(before[3] / ratio, rel=1e-9)


def test_a_preset_sets_its_quantities(browser):
    select = browser.find_element("id", "preset")
    browser.execute_script(
        "arguments[0].value = 'granite'; arguments[0].dispatchEvent(new Event('change'))", select
    )
    settle(browser)
    assert browser.find_element("id", "value-particle_density").get_attribute("value") == "2650"


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("particle_radius", "20 kg", "unit kg is unknown (allowed m, cm, mm, um, in)"),
        ("plate_angle", "steep", "steep is not a number"),
        ("particle_velocity_y", "5", "5 is impossible (allowed -30 ... 0 m/s)"),
        ("restitution", "1.5", "1.5 is impossible (allowed 0.05 ... 1)"),
    ],
)
def test_a_wrong_value_is_one_line_and_changes_nothing(browser, name, text, line):
    before = numbers(browser)
    field = type_value(browser, name, text)
    assert field.get_attribute("aria-invalid") == "true"
    assert browser.find_element("id", f"problem-{name}").text == line
    assert numbers(browser) == before
    browser.find_element("id", "reset").click()
    settle(browser)
    assert browser.find_element("id", f"problem-{name}").text == ""


def test_the_warnings_are_those_of_the_command(browser):
    """As many lines, on the same quantities, for cases of which some are far from all others."""
    surrogate = Surrogate(*random_surrogate())
    rng = np.random.default_rng(5)
    seen = set()
    for _ in range(60):
        values = {}
        for row in SAMPLED:
            low, high = row.paper_range
            beyond = 0.5 * (high - low) * (rng.random() < 0.2)
            drawn = rng.uniform(low - beyond, high + beyond)
            values[row.name] = float(np.clip(drawn, *row.limits))
        expected = surrogate.predict(values).warnings
        found = browser.execute_script(
            "const {quantities, far} = Model.outside(arguments[0]);"
            "return {names: quantities.map(({name}) => name), far};",
            values,
        )
        named = {line.split(" = ")[0] for line in expected if " = " in line}
        assert set(found["names"]) == named
        assert found["far"] == any("far from all training cases" in line for line in expected)
        seen.add((bool(named), found["far"]))
    assert {(True, False), (False, False)} <= seen


def test_a_value_outside_its_range_is_named_and_W_is_not(browser):
    for name, text, line in (
        ("particle_velocity_y", "-30", "particle velocity (vertical) -30 m/s is outside the "
         "training range -10 ... 0 m/s: extrapolated; the interval does not hold."),
        ("archard_constant", "1e-7", None),
    ):  # fmt: skip
        browser.find_element("id", "reset").click()
        type_value(browser, name, text)
        settle(browser)
        lines = [one.text for one in browser.find_elements("css selector", "#warnings p")]
        assert lines == ([line] if line else [])


def test_the_nearest_case_is_the_one_that_is_set(browser, dataset):
    browser.find_element("id", "reset").click()
    settle(browser)
    button = browser.find_element("css selector", "#nearest tbody button")
    case = int(button.get_attribute("title").split()[-1])
    browser.execute_script("arguments[0].click()", button)
    settle(browser)
    cells = browser.find_elements("css selector", "#nearest tbody tr:first-child td")
    assert int(cells[0].text) == case and float(cells[1].text) == 0.0
    row = dataset.set_index("case_id").loc[case]
    assert float(cells[2].text) == pytest.approx(row[TARGET], rel=1e-3)
    expected = Surrogate(*random_surrogate()).predict({name: row[name] for name in SAMPLED_NAMES})
    assert numbers(browser)[0] == pytest.approx(expected.rate[0], rel=1e-6)


def test_every_control_has_a_name_and_is_reached_by_the_keyboard(browser):
    nameless = browser.execute_script(
        "return [...document.querySelectorAll('input, select, button')].filter((one) => "
        "!(one.labels?.length || one.getAttribute('aria-label') || one.textContent.trim()) "
        "|| one.tabIndex < 0).map((one) => one.id)"
    )
    assert nameless == []


@pytest.mark.parametrize("room", ROOMS)
def test_the_page_fits_the_screen(browser, room, tmp_path):
    from matplotlib.image import imread

    show(browser, room)
    browser.execute_script("document.getElementById('reset').click(); scrollTo(0, 0)")
    settle(browser)
    width, _ = ROOMS[room]
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    # The rates and hours of all places are seen without a scroll bar.
    table, room_for_it = browser.execute_script(
        "const one = document.getElementById('rates').parentElement;"
        "return [one.scrollWidth, one.clientWidth]"
    )
    assert table <= room_for_it
    browser.save_screenshot(str(tmp_path / "page.png"))
    picture = imread(tmp_path / "page.png")
    assert picture.shape[1] == width and np.ptp(picture[:, :, 0]) > 0.5
    # The map and all curves are drawn.
    drawings = browser.find_elements("css selector", "#map .main-svg, #curves .main-svg")
    assert len(drawings) >= 2


def test_titles_of_the_small_curves_do_not_overlap_on_a_turned_telephone(browser):
    """The page was drawn for a wide screen, and its panels follow."""
    show(browser, "large")
    wait_for(browser, "return document.getElementById('curves').dataset.columns === '5'")
    for room, columns in (("phone", 2), ("wide", 5)):
        show(browser, room)
        wait_for(
            browser, f"return document.getElementById('curves').dataset.columns === '{columns}'"
        )
        settle(browser)
        boxes = browser.execute_script(
            "return [...document.querySelectorAll('#curves [class$=title] text')]"
            ".map((one) => one.getBoundingClientRect())"
        )
        assert len(boxes) == len(SAMPLED)
        for one, other in itertools.combinations(boxes, 2):
            apart = one["right"] < other["left"] or other["right"] < one["left"]
            assert apart or one["bottom"] <= other["top"] or other["bottom"] <= one["top"], room


def test_the_command_has_no_digits_of_the_processor(browser):
    """22.6 / 1000 is 0.022600000000000002."""
    type_value(browser, "particle_radius", "22.6")
    settle(browser)
    assert "particle_radius=0.0226 " in browser.find_element("id", "command").text


def test_nothing_leaves_the_page_and_nothing_goes_wrong(browser):
    """Last, as it reads the log of all that was done before."""
    wrong = [one["message"] for one in log(browser, "browser") if one["level"] != "INFO"]
    assert wrong == []
    asked = []
    for one in log(browser, "performance"):
        message = json.loads(one["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            asked.append(message["params"]["request"]["url"])
    assert asked and all(url.startswith(("file:", "data:", "blob:")) for url in asked), asked


def test_a_quantity_held_fixed_has_no_slider_range(dataset):
    data = explorer_data(*random_surrogate(["plate_density", "equipment_density"]), None, dataset,
                         "s", {})  # fmt: skip
    fixed = {one["name"] for one in data["quantities"] if one["fixed"]}
    assert fixed == {"equipment_density"} and data["maps"] is None
    decades = {one["name"] for one in data["quantities"] if one["decades"]}
    assert decades == {"archard_constant"}


def test_the_page_of_a_geometry_has_its_sliders_and_numbers(tmp_path):
    """Sliders, typed values, curves and the command of a curved chute, in the browser."""
    table = geometry_tables.planted(40)
    _, _, model = geometry_tables.trained(table, Settings(2000, (16,), 10))
    path = tmp_path / "arc.html"
    path.write_text(explorer_page(json_and_back(*model), None, table, "arc", {}),
                    encoding="utf-8")  # fmt: skip
    surrogate = Surrogate(*model)
    with opened(path) as driver:
        rng = np.random.default_rng(2)
        for _ in range(5):
            values = {**geometry_tables.FIXED} | {
                name: float(rng.uniform(*ends)) for name, ends in geometry_tables.VARIED.items()
            }
            found = driver.execute_script("return Model.predict(arguments[0], 0.9)", values)
            expected = surrogate.predict(values, 0.9)
            for name in ("rate", "lower", "upper"):
                assert found[0][name] == pytest.approx(getattr(expected, name)[0], rel=1e-6)
        assert type_value(driver, "arc_radius", "60 cm").get_attribute("aria-invalid") != "true"
        type_value(driver, "arc_end", "0.5 rad")
        settle(driver)
        command = driver.find_element("id", "command").text.replace("\\\n", "").split()
        given = {
            name: float(text) for name, text in (word.split("=") for word in command if "=" in word)
        }
        assert given["arc_radius"] == 0.6
        assert given["arc_end"] == pytest.approx(np.degrees(0.5), rel=1e-12)
        assert numbers(driver)[0] == pytest.approx(surrogate.predict(given).rate[0], rel=1e-6)
        assert driver.find_element("id", "slider-arc_radius").is_enabled()
        assert not driver.find_element("id", "slider-plate_angle").is_enabled()
        shown = driver.find_element("css selector", "#nearest thead").text
        assert "radius of the arc (mm)" in shown and "plate angle" not in shown
        place = driver.find_element("id", "headline-place").text
        assert place == "mean over the surface"
        curves = driver.find_element("id", "curves").get_attribute("aria-label")
        assert curves.endswith(f"against each of {len(geometry_tables.VARIED)} quantities")
        wrong = [one["message"] for one in log(driver, "browser") if one["level"] != "INFO"]
        assert wrong == []


def test_texts_of_the_data_do_not_end_the_page(page):
    text = page.read_text(encoding="utf-8")
    assert "a \\u003cstudy>" in text and "a &lt;study&gt;" in text
    assert text.count("</script>") == 4 and "{{" not in text.split("<script>")[0]


def test_arrays_keep_their_bits():
    import base64

    for kind in (np.float32, np.float64):
        array = np.random.default_rng(0).normal(size=(3, 2)).astype(kind)
        found = stored(array)
        back = np.frombuffer(base64.b64decode(found["text"]), dtype=f"<{found['type']}")
        np.testing.assert_array_equal(back.reshape(found["shape"]), array)


def test_only_the_first_cases_of_a_large_study_are_in_the_page(dataset, monkeypatch):
    from abradem.report import explorer

    monkeypatch.setattr(explorer, "MOST_CASES", 7)
    shuffled = pd.concat([dataset.tail(20), dataset.head(20)])
    data = explorer_data(*random_surrogate(), None, shuffled, "s", {})
    assert data["cases"]["ids"] == list(range(7)) and data["cases"]["values"]["shape"] == [7, 14]
