"""Figures of the set-up, the workflow, the networks and the parameter space."""

import importlib
import inspect
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from figure_checks import SETUP, assert_fit_to_print, study, texts
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from PIL import Image
from tables import product_law

from abradem.config import load_config, typical_case
from abradem.dem.model import Interaction
from abradem.figures import style
from abradem.figures.angles import angles_figure
from abradem.figures.architecture import architecture_figure
from abradem.figures.catalogue import FIGURES
from abradem.figures.distributions import distributions_figure, standardised
from abradem.figures.film import Shot, frames, shared_top
from abradem.figures.flow import generation_figure, needs_of, workflow_figure
from abradem.figures.gallery import chosen_cases, gallery_figure
from abradem.figures.gallery_page import WIDTH, page, shrink
from abradem.figures.maps import depth_rate_maps
from abradem.figures.render import Camera, DrawnPlate, Patch, picture
from abradem.figures.setup import setup_figure, within_frame
from abradem.figures.verdicts import margins, verdicts_figure
from abradem.running.rule_graph import from_dot
from abradem.verification.checks import HOLDS, Check, checks_table
from abradem.verification.results_page import PARTS

CASE = typical_case(load_config({"study": "x"}))
DOT = """digraph snakemake_dag {
	0[label = "all", color = "0.00 0.6 0.85", style="rounded"];
	1[label = "sample", color = "0.1 0.6 0.85", style="rounded"];
	2[label = "join_cases", color = "0.1 0.6 0.85", style="rounded"];
	3[label = "simulate", color = "0.1 0.6 0.85", style="rounded"];
	4[label = "wear_rates", color = "0.1 0.6 0.85", style="rounded"];
	5[label = "dataset", color = "0.1 0.6 0.85", style="rounded"];
	6[label = "linear", color = "0.1 0.6 0.85", style="rounded"];
	7[label = "figure_maps", color = "0.1 0.6 0.85", style="rounded"];
	8[label = "provenance", color = "0.1 0.6 0.85", style="rounded"];
	1 -> 2
	1 -> 3
	1 -> 4
	3 -> 4
	2 -> 5
	3 -> 5
	4 -> 5
	5 -> 6
	3 -> 7
	6 -> 0
	7 -> 0
}"""
STAGES = {
    "sample": "sampling", "join_cases": "sampling", "simulate": "simulation",
    "wear_rates": "wear", "dataset": "dataset", "linear": "baselines",
    "figure_maps": "figures", "provenance": "running",
}  # fmt: skip
STUDY = {"cases": 12, "blocks": 2, "jobs": 4, "method": "lhs", "seed": 1, "external": None}


@pytest.fixture(scope="module")
def graph():
    return from_dot(DOT, STAGES)


def drawn_values(figure):
    """All numbers of lines, collections and images of a figure."""
    for panel in figure.axes:
        for line in panel.lines:
            yield np.asarray(line.get_xydata(), dtype=float)
        for one in panel.collections:
            if one.get_array() is not None:
                yield np.ma.filled(np.ma.asarray(one.get_array(), dtype=float), np.nan)
        for image in panel.images:
            yield np.asarray(image.get_array(), dtype=float)


def assert_says_what_it_shows(figure):
    """Every number is finite, and every axis with numbers on it is labelled."""
    for values in drawn_values(figure):
        assert np.isfinite(values).all()
    for panel in figure.axes:
        if not panel.axison:
            continue
        for axis in (panel.xaxis, panel.yaxis):
            words = [tick.get_text() for tick in axis.get_ticklabels()]
            if axis.get_visible() and any(words) and all(_is_number(word) for word in words):
                assert axis.get_label_text(), f"{panel.get_title(loc='left')}: {words}"


def _is_number(word):
    plain = word.replace("\N{MINUS SIGN}", "-").strip("$")
    return plain == "" or "10^" in plain or plain.lstrip("-").replace(".", "", 1).isdigit()


# The renderer


CAMERA = Camera(np.array([0.0, 0.0, 5.0]), np.zeros(3), 1.0, 80, 80)
FAR = DrawnPlate(0.1, 0.1, 0.0, np.full((1, 1, 3), 0.5))


def inside(image):
    return (image < 0.99).any(axis=2)


def test_a_sphere_is_a_disc_of_its_radius():
    image = picture(CAMERA, FAR, np.array([[0.0, 0.0, 1.0]]), 0.2, finer=1)
    area = inside(image).sum()
    # From 4 m, the outline of a sphere has the radius of its tangent cone.
    radius = 0.2 / np.sqrt(1.0 - (0.2 / 4.0) ** 2) * 80 * 5.0 / 4.0
    assert area == pytest.approx(np.pi * radius**2, rel=0.03)


def test_the_nearer_sphere_hides_the_farther_whatever_the_order():
    near, far = [0.0, 0.1, 1.0], [0.0, 0.1, 0.0]
    tints = np.array([1.6, 0.4])
    one = picture(CAMERA, FAR, np.array([near, far]), 0.2, tints=tints)
    other = picture(CAMERA, FAR, np.array([far, near]), 0.2, tints=tints[::-1])
    np.testing.assert_array_equal(one, other)
    middle = one[CAMERA.height // 2 - 10, CAMERA.width // 2]
    alone = picture(CAMERA, FAR, np.array([near]), 0.2, tints=tints[:1])
    np.testing.assert_array_equal(middle, alone[CAMERA.height // 2 - 10, CAMERA.width // 2])


def test_points_are_drawn_where_they_are_projected():
    camera = Camera(np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.0, 0.0]), 1.0, 90, 60)
    place = np.array([0.15, 0.1, 0.05])
    rows, columns = np.nonzero(inside(picture(camera, FAR, place[None], 0.02, finer=1)))
    without = inside(picture(camera, FAR, np.empty((0, 3)), 0.02, finer=1))
    ball = ~without[rows, columns]
    x, y = camera.project(place)[0]
    assert columns[ball].mean() + 0.5 == pytest.approx(x, abs=0.7)
    assert rows[ball].mean() + 0.5 == pytest.approx(y, abs=0.7)


def test_a_facet_has_its_colour_and_lies_where_it_belongs():
    red, grey = to_rgb("red"), (0.5, 0.5, 0.5)
    colours = np.full((2, 2, 3), grey)
    colours[1, 0] = red
    plate = DrawnPlate(0.4, 0.4, 30.0, colours)
    camera = Camera(np.array([0.0, 3.0, 0.5]), np.zeros(3), 0.6, 100, 100)
    image = picture(camera, plate, np.empty((0, 3)), 0.01, finer=1)
    column, row = camera.project(plate.point(0.5, -0.5))[0].astype(int)
    np.testing.assert_allclose(image[row, column], red)
    column, row = camera.project(plate.point(0.5, 0.5))[0].astype(int)
    np.testing.assert_allclose(image[row, column], grey)


def test_a_particle_shades_the_plate_below_it_and_nothing_else():
    plate = DrawnPlate(0.4, 0.4, 0.0, np.full((1, 1, 3), 0.9))
    camera = Camera(np.array([0.0, 3.0, 0.01]), np.zeros(3), 0.6, 100, 100)
    bare = picture(camera, plate, np.empty((0, 3)), 0.02)
    shaded = picture(camera, plate, np.array([[0.0, 0.05, 0.0]]), 0.02)
    changed = np.abs(shaded - bare).max(axis=2) > 0.02
    assert 0.005 < changed.mean() < 0.1


def test_the_patch_lets_what_is_behind_it_shine_through():
    patch = Patch(0.3, 0.3, 0.0, 90.0)
    camera = Camera(np.array([5.0, 0.0, 0.0]), np.zeros(3), 1.0, 80, 80)
    behind = np.array([[-1.0, 0.0, 0.0]])
    through = picture(camera, FAR, behind, 0.1, patch)
    without = picture(camera, FAR, behind, 0.1)
    middle = (40, 40)
    assert not np.allclose(through[middle], without[middle])
    empty = picture(camera, FAR, np.empty((0, 3)), 0.1, patch)
    assert not np.allclose(through[middle], empty[middle])


# The figures


def particles(n, time=0.0):
    rng = np.random.default_rng(0)
    frame = pd.DataFrame(rng.uniform(-0.1, 0.2, (n, 3)), columns=list("xyz"))
    return frame.assign(particle=range(n), time=time)


@pytest.mark.parametrize("angles", [(35.0, -30.0), (-50.0, 60.0), (0.0, 0.0)])
def test_the_set_up_names_what_it_shows(angles, monkeypatch):
    monkeypatch.setattr(style, "DPI", 60)
    case = {**CASE, "plate_angle": angles[0], "factory_angle": angles[1]}
    depth = np.random.default_rng(0).gamma(1.0, 1e-3, SETUP.facets)
    figure = setup_figure(particles(20), depth, 1.5, case, SETUP, "friction")
    words = texts(figure)
    for part in (
        "300 × 300 mm",
        "100 × 100 mm",
        "250 mm",
        "m/s",
        "(mm)",
        "after 1.5 s",
        "4 kg/s",
        "wear measure: friction",
    ):
        assert part in words
    assert_says_what_it_shows(figure)
    assert_fit_to_print(figure)
    (mesh,) = figure.axes[1].collections
    assert np.nanmax(mesh.get_array()) == pytest.approx(mesh.get_clim()[1])


def test_the_set_up_says_that_feed_may_be_lost(monkeypatch):
    monkeypatch.setattr(style, "DPI", 60)
    losing = replace(SETUP, unplaced="skip")
    figure = setup_figure(particles(3), np.zeros(SETUP.facets), 1.0, CASE, losing, "friction")
    assert "at most 4 kg/s" in texts(figure)


@pytest.mark.parametrize(
    ("acts", "angle", "lowered"),
    [("arc", -60.0, True), ("arc", 0.0, False), ("tilt", -60.0, False), ("level", -60.0, False)],
)
def test_the_set_up_says_why_its_fall_height_is_not_that_of_the_study(
    acts, angle, lowered, monkeypatch
):
    """On an arc of 200 mm radius the factory is 100 mm lower at 60 deg."""
    monkeypatch.setattr(style, "DPI", 60)
    setup = replace(SETUP, angle_acts=acts, arc_radius=0.2, fall_height=0.25)
    case = {**CASE, "factory_angle": angle}
    figure = setup_figure(particles(3), np.zeros(setup.facets), 1.0, case, setup, "friction")
    words = texts(figure)
    assert f"$H$ = {150 if lowered else 250} mm" in words
    assert ("that of the case: 250 mm at " in words) is lowered
    assert ("down an arc of 200 mm radius" in words) is lowered


def test_particles_cut_by_the_frame_are_not_within_it():
    """At the centre of the picture, at its edge, and half a radius inside the edge."""
    half = 0.5 * CAMERA.width / CAMERA.height
    places = np.array([[0.0, 0.0, 0.0], [half, 0.0, 0.0], [half - 0.02, 0.0, 0.0]])
    assert list(within_frame(CAMERA, places, 0.04)) == [True, False, False]
    assert list(within_frame(CAMERA, places[2:], 0.01)) == [True]
    assert len(within_frame(CAMERA, places[:0], 0.04)) == 0


def test_curves_by_angle_carry_their_angles_and_share_the_axis():
    time = np.linspace(0.0, 5.0, 50)
    curves, rates = [], []
    for varied, angles in (("plate_angle", (0.0, 20.0, 45.0)), ("factory_angle", (-90.0, 0.0))):
        for angle in angles:
            slope = 1e-4 * (1.0 + abs(angle) / 45.0)
            curves.append(
                pd.DataFrame(
                    {"varied": varied, "angle": angle, "time": time, "wear_depth": slope * time}
                )
            )
            rates.append({"varied": varied, "angle": angle, "rate": slope, "rate_stderr": 1e-6})
    figure = angles_figure(pd.concat(curves), pd.DataFrame(rates), CASE, 5.0, "sliding")
    assert "Wear measure: sliding" in texts(figure)
    left, right = figure.axes[:2]
    assert len(left.lines) == 3 and len(right.lines) == 2
    assert left.get_ylim() == right.get_ylim()
    legend = [text.get_text() for text in right.get_legend().get_texts()]
    assert legend == ["\N{MINUS SIGN}90°", "0°"]
    assert "mm/s" in figure.axes[2].get_ylabel() and "(°)" in figure.axes[3].get_xlabel()
    assert_says_what_it_shows(figure)
    assert_fit_to_print(figure)


def test_rules_that_others_imply_are_left_out(graph):
    needs = needs_of(graph)
    assert needs["dataset"] == {"join_cases", "wear_rates"}
    assert needs["wear_rates"] == {"simulate"}
    assert needs["provenance"] == set()
    assert "all" not in needs


def test_the_workflow_shows_every_rule_and_no_line_below_a_box(graph):
    figure = workflow_figure(graph)
    words = texts(figure)
    for rule in STAGES:
        assert rule.removeprefix("figure_").replace("_", " ") in words
    assert f"{len(STAGES)} rules" in words
    assert_fit_to_print(figure)


@pytest.mark.parametrize("setup", [SETUP, None])
def test_the_generation_of_data_follows_the_rules(graph, setup):
    figure = generation_figure(graph, STUDY, setup)
    words = texts(figure)
    for part in ("draw parameter sets", "simulate", "wear rates", "data set", "Latin hypercube"):
        assert part in words
    assert ("steady for 2 s" in words) == (setup is not None)
    assert_fit_to_print(figure)


@pytest.mark.parametrize(
    ("pair", "told"),
    [
        (None, "pairs: as particle and plate; step"),
        (Interaction(0.35, 0.56, 0.05), "pairs: $e$ 0.35, $\\mu_s$ 0.56, $\\mu_r$ 0.05; step"),
    ],
)
def test_the_flow_chart_says_how_particles_meet(graph, pair, told):
    setup = replace(SETUP, pair_interaction=pair)
    figure = generation_figure(graph, STUDY, setup)
    assert told in texts(figure)
    assert_fit_to_print(figure)


def test_a_table_from_elsewhere_is_where_its_data_come_from():
    graph = from_dot('1[label = "dataset"];\n2[label = "linear"];\n1 -> 2\n', STAGES)
    figure = generation_figure(graph, {**STUDY, "external": "some/table.csv"}, None)
    words = texts(figure)
    assert "table.csv" in words and "ranges" not in words
    assert_fit_to_print(figure)


def test_the_gallery_shows_the_case_nearest_to_each_middle():
    cases = pd.DataFrame(
        {
            "case_id": [3, 4, 5, 6],
            "plate_angle": [0.0, 16.0, 60.0, 70.0],
            "particle_velocity_y": [-10.0, -8.0, -1.0, 0.0],
        }
    )
    runs = pd.DataFrame({"case_id": [3, 4, 5, 6], "status": "ok", "window_start": 0.5}).assign(
        window_end=[2.5, 2.5, 2.5, np.nan]
    )
    chosen = chosen_cases(cases, runs, "plate_angle", "particle_velocity_y", 2, 2)
    assert chosen.to_dict("records") == [
        {"case_id": 4, "row": 0, "column": 0},
        {"case_id": 5, "row": 1, "column": 1},
    ]
    assert chosen_cases(cases, runs.iloc[:0], "plate_angle", "plate_angle", 2, 2).empty


def test_the_gallery_labels_every_map():
    _, maps, runs, cases = study(12)
    chosen = chosen_cases(cases, runs, "plate_angle", "particle_velocity_y", 4, 3)
    facets, panels = depth_rate_maps(maps, runs, cases, SETUP, list(chosen["case_id"]), "friction")
    over = ("plate_angle", "particle_velocity_y", "friction")
    figure = gallery_figure(facets, panels, chosen, *over)
    assert "Wear measure: friction" in texts(figure)
    shown = [panel for panel in figure.axes if panel.get_xlabel().endswith("mm/s")]
    assert len(shown) == len(chosen)
    assert all("°" in panel.get_title() and "m/s" in panel.get_title() for panel in shown)
    assert_says_what_it_shows(figure)
    assert_fit_to_print(figure)
    nothing = gallery_figure(facets, panels, chosen.iloc[:0], *over)
    assert "no case" in texts(nothing)


def predictions(table, noise):
    rng = np.random.default_rng(3)
    rows = []
    for protocol in ("as_published", "leakage_free"):
        part = table.sample(8, random_state=1)
        error = noise * rng.standard_normal(len(part))
        rows.append(
            pd.DataFrame(
                {
                    "model": "ga_ann", "protocol": protocol, "case_id": part["case_id"],
                    "repeat": 0, "split": "test", "actual": part["wear_total_mean"],
                    "predicted": part["wear_total_mean"] + error,
                }
            )
        )  # fmt: skip
    return pd.concat(rows)


def test_distributions_are_standardised_by_all_rows_and_count_each_row_once():
    table = product_law(30)
    spread = table["wear_total_mean"].std(ddof=0)
    found = standardised(table, predictions(table, 0.3 * spread), "wear_total_mean", "ga_ann")
    everything = found[found["protocol"] == "all rows"]["actual_standardised"]
    assert everything.mean() == pytest.approx(0.0, abs=1e-12)
    assert everything.std(ddof=0) == pytest.approx(1.0)
    errors = found.dropna()
    np.testing.assert_allclose(
        errors["error_standardised"],
        errors["predicted_standardised"] - errors["actual_standardised"],
        atol=1e-12,
    )
    figure = distributions_figure(found, "ga_ann")
    heights = sum(bar.get_height() for bar in figure.axes[0].patches)
    assert heights == 30
    assert "8 test rows" in texts(figure)
    assert_says_what_it_shows(figure)
    assert_fit_to_print(figure)


@pytest.mark.parametrize("layers", [[10, 500], [361, 361, 158, 12, 401], [1, 2, 3, 4, 5, 6]])
def test_the_architecture_names_features_and_true_sizes(layers):
    names = ["archard_constant", "plate_angle", "particle_velocity_y"]
    summaries = {
        name: {"features": names, "architecture": layers}
        for name in ("as_published", "leakage_free")
    }
    figure = architecture_figure(summaries)
    for panel in figure.axes:
        words = [text.get_text() for text in panel.texts]
        assert [word for word in words if word.isdigit()][:-1] == [str(size) for size in layers]
        assert "$W$" in words and r"$\dot h$" in words
        counts = [
            len(one.get_offsets()) for one in panel.collections if isinstance(one, PathCollection)
        ]
        assert counts[0] == 3 and counts[-1] == 1
        assert all(drawn <= size for drawn, size in zip(counts[1:-1], layers, strict=True))
    assert_fit_to_print(figure)


def test_margins_are_shares_of_the_tolerance():
    checks = checks_table(
        1,
        [
            Check("half of an absolute", 1.5, 1.0, 1.0, kind="absolute"),
            Check("twice a relative", 1.2, 1.0, 0.1),
            Check("bound from above", 0.25, 1.0, kind="at most"),
            Check("bound from below", 2.0, 1.0, kind="at least"),
            Check("exact", 1.0, 1.0, 0.0, kind="absolute"),
        ],
    )
    found = margins(checks)
    np.testing.assert_allclose(found["used"], [0.5, 2.0, 0.25, 0.5, 0.0])
    assert ((found["used"] <= 1.0) == (found["verdict"] == HOLDS)).all()


def test_the_verdicts_show_every_check_and_what_fails():
    checks = pd.concat(
        checks_table(part, [Check("a", 1.0 + 0.04 * i, 1.0, 0.1) for i in range(4)])
        for part in (1, 4, 10)
    )
    figure = verdicts_figure(margins(checks), PARTS, HOLDS)
    (panel,) = figure.axes
    drawn = sum(len(line.get_xdata()) for line in panel.lines) - 2
    assert drawn == 12
    assert "3 of 4" in texts(figure) and "9 of 12 checks hold" in texts(figure).replace("\n", " ")
    assert_says_what_it_shows(figure)
    assert_fit_to_print(figure)


def test_frames_of_the_film_share_one_scale_and_the_wear_grows():
    times = np.array([0.0, 0.1, 0.2])
    growth = np.random.default_rng(0).gamma(1.0, 1e-3, SETUP.facets)
    shots = [
        Shot(
            {**CASE, "plate_angle": angle},
            pd.concat([particles(4, time) for time in times]),
            times,
            np.array([step * share * growth for step in range(3)]),
        )
        for angle, share in ((60.0, 1.0), (30.0, 0.2))
    ]
    assert shared_top(shots) > shots[1].depth.max()
    pictures = list(frames(shots, SETUP, 100))
    assert len(pictures) == 3
    height, width, _ = pictures[0].shape
    assert width == 200 and height % 2 == 0
    assert all(one.dtype == np.uint8 and one.shape == pictures[0].shape for one in pictures)

    def redness(picture, half):
        part = picture[:, half * 100 : (half + 1) * 100].astype(float)
        return (part[..., 0] - part[..., 2])[:120].sum()

    worn = [[redness(one, half) for one in pictures] for half in (0, 1)]
    assert worn[0][0] < worn[0][1] < worn[0][2]
    assert worn[1][2] - worn[1][0] < worn[0][2] - worn[0][0]


# The catalogue


ROOT = Path(__file__).parents[2]
RULES = "".join(
    (ROOT / "workflow" / "rules" / f"{name}.smk").read_text()
    for name in ("figures", "calibration", "geometry", "scenes")
)


def named_figures():
    """Names of the figures made by rules."""
    return re.findall(r'figure_files\("(\w+)"\)', RULES)


LIST_OF_THE_PAPER = (
    "setup", "angles", "coefficients", "predicted_linear", "penalised", "correlations", "loadings",
    "components", "tree", "tree_depth", "architecture", "predictions", "distributions",
    "generation", "rules", "ga_ann", "gallery", "comparison", "series", "quality", "maps",
    "verification", "speed",
)  # fmt: skip


MADE_ELSEWHERE = ("verification", "speed")
"""A study shows these where their results are there."""


def test_every_figure_of_the_paper_is_made_by_the_workflow():
    assert set(LIST_OF_THE_PAPER) <= set(named_figures())


def test_the_workflow_makes_all_figures_of_the_catalogue_once_and_no_other():
    assert sorted(named_figures()) == sorted(FIGURES)


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_drawn_from_the_inputs_and_options_of_its_rule(name):
    rule = RULES[RULES.index(f"rule figure_{name}:") :].split("    script:")[0]
    inputs = rule.partition("input:")[2].partition("output:")[0]
    named = set(re.findall(r"^ +(\w+)=", inputs, re.MULTILINE))
    module, function = FIGURES[name].draw.split(":")
    draw = getattr(importlib.import_module(f"abradem.figures.{module}"), function)
    assert named <= inspect.signature(draw).parameters.keys()
    assert f'**drawn_as("{name}")' in rule


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_has_a_caption_and_a_place_in_the_gallery(name):
    entry = FIGURES[name]
    assert entry.label and entry.caption.endswith(".")
    if name not in MADE_ELSEWHERE:
        assert f"](images/{name}.png)" in page(set(FIGURES))


def test_the_gallery_page_shows_no_figure_that_is_not_there():
    gallery = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    shown = [part.split(")")[0] for part in gallery.split("](images/")[1:]]
    assert shown and all((ROOT / "docs" / "images" / name).is_file() for name in shown)


def test_the_page_leaves_out_what_there_is_no_image_of(tmp_path):
    text = page({"setup", "maps"})
    assert text.count("](images/") == 2 and "## Trees" not in text and "## Film" not in text
    Image.new("RGB", (2 * WIDTH, 300), "white").save(tmp_path / "a.png")
    shrink(tmp_path / "a.png", tmp_path / "b.png")
    with Image.open(tmp_path / "b.png") as small:
        assert small.size == (WIDTH, 150)


def test_the_default_configuration_has_the_typical_case_in_the_middle():
    config = load_config({"study": "x"})
    values = typical_case(config)
    low, high = config.sampling.ranges.restitution
    assert values["restitution"] == pytest.approx(0.5 * (low + high))
    assert values["particle_radius"] == 1e-3 * config.figures.typical.particle_radius_mm
    assert json.dumps(values)
