"""Figures of a surface: every cell is drawn with the colour of its rate."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PolyCollection

from abradem.dem.surface import cell_areas
from abradem.figures.part_rates import draw_part_rates
from abradem.figures.surface_map import BARE_FLAT, draw_surface, surface_map_figure
from abradem.geometry.build import surface_of
from abradem.geometry.kinds import MeshFile, Plates
from abradem.geometry.outline import outline
from abradem.geometry.shapes import Rectangle
from abradem.wear.part_effects import part_effects

SURFACE = surface_of(
    Plates((Rectangle(0.3, 0.2, 30.0), Rectangle(0.2, 0.2, 150.0, drop=0.2))), 0.05
)
CELLS = pd.DataFrame(
    {
        "case_id": 0,
        "depth_rate_total": np.where(SURFACE.part == 1, 2e-3, 0.0),
        "cell_area": cell_areas(SURFACE),
    }
)


def laid_out(figure):
    """The parts that are drawn flat."""
    return [
        collection
        for panel in figure.axes
        for collection in panel.collections
        if type(collection) is PolyCollection
    ]


def test_parts_are_laid_out_with_the_colours_of_their_cells():
    figure = surface_map_figure(SURFACE, CELLS, "total")
    flat = laid_out(figure)
    assert [len(one.get_paths()) for one in flat] == [
        np.count_nonzero(SURFACE.part == part) for part in (0, 1)
    ]
    bare, worn = (np.unique(one.get_facecolor(), axis=0) for one in flat)
    assert bare == pytest.approx(np.array([BARE_FLAT]))
    assert len(worn) == 1 and worn[0] != pytest.approx(BARE_FLAT)
    titles = [panel.get_title() for panel in figure.axes if panel.get_title()]
    assert titles == ["plate 1", "plate 2"]


@pytest.mark.parametrize(("angle", "azimuth"), [(35.0, -120.0), (145.0, -60.0)])
def test_a_slope_is_seen_from_the_side_that_it_faces(angle, azimuth):
    surface = surface_of(Plates((Rectangle(0.3, 0.2, angle),)), 0.1)
    cells = pd.DataFrame({"depth_rate_total": 1e-3, "cell_area": cell_areas(surface)})
    assert surface_map_figure(surface, cells, "total").axes[0].azim == azimuth


def test_a_surface_without_wear_is_drawn():
    figure = surface_map_figure(SURFACE, CELLS.assign(depth_rate_total=0.0), "total")
    figure.canvas.draw()
    flat = laid_out(figure)
    assert len(flat) == 2
    for one in flat:
        assert np.unique(one.get_facecolor(), axis=0) == pytest.approx(np.array([BARE_FLAT]))


def test_the_figure_of_a_study_shows_the_first_case_with_a_map():
    setup = {
        "geometry": {
            "kind": "plates",
            "plates": [
                {"length": 0.3, "width": 0.2, "angle": 30.0},
                {"length": 0.2, "width": 0.2, "angle": 150.0, "drop": 0.2},
            ],
        },
        "facet_size": 0.05,
        "patch_length": 0.05,
        "patch_width": 0.05,
    }
    cases = pd.DataFrame({"case_id": [0, 1], "particle_radius": 0.01, "particle_velocity_y": -1.0})
    figure = draw_surface(CELLS, cases, setup, 1, "total")
    assert len([panel for panel in figure.axes if panel.get_title()]) == 2


def test_rates_of_parts_are_drawn_against_what_varied():
    cases = pd.DataFrame(
        {"case_id": range(4), "plate_2_angle": [1.0, 2.0, 3.0, 4.0], "plate_angle": 30.0}
    )
    parts = pd.DataFrame(
        {
            "case_id": [*range(4)] * 2,
            "part_name": ["a"] * 4 + ["b"] * 4,
            "wear_total_mean": [1.0, 2.0, 3.0, 4.0, 4.0, 3.0, 2.0, 1.0],
        }
    )
    effects = part_effects(parts, cases, "wear_total_mean")
    figure = draw_part_rates(parts, effects, cases, {"name": "wear_total_mean"})
    (panel,) = figure.axes
    assert panel.get_yscale() == "linear"
    assert [line.get_ydata().tolist() for line in panel.lines] == [[1, 2, 3, 4], [4, 3, 2, 1]]
    assert panel.get_xlabel() == "angle of plate 2 (°)"


def test_a_reference_far_from_the_rates_makes_their_axis_logarithmic():
    cases = pd.DataFrame({"case_id": range(4), "plate_2_angle": [1.0, 2.0, 3.0, 4.0]})
    parts = pd.DataFrame(
        {"case_id": range(4), "part_name": "a", "wear_total_mean": [1.0, 2.0, 3.0, 4.0]}
    )
    effects = part_effects(parts, cases, "wear_total_mean")
    target = {"name": "wear_total_mean"}
    figure = draw_part_rates(parts, effects, cases, target, 20.0, "Yang et al. (2021)")
    (panel,) = figure.axes
    assert panel.get_yscale() == "log"
    assert panel.lines[-1].get_label() == "Yang et al. (2021)"
    assert {text.get_text() for text in figure.legends[0].get_texts()} == {
        "a", "Yang et al. (2021)"
    }  # fmt: skip


def test_rates_of_parts_are_side_by_side_where_nothing_varied():
    cases = pd.DataFrame({"case_id": [0, 1], "plate_angle": 30.0})
    parts = pd.DataFrame(
        {
            "case_id": [0, 0, 1, 1],
            "part_name": ["a", "b"] * 2,
            "wear_total_mean": [1.0, 2.0, 3.0, 4.0],
            "wear_total_p99": [5.0, 6.0, 7.0, 8.0],
        }
    )
    effects = part_effects(parts, cases, "wear_total_mean")
    figure = draw_part_rates(parts, effects, cases, {"name": "wear_total_mean"}, reference=0.5)
    (panel,) = figure.axes
    mean, p99, line = panel.lines
    assert mean.get_xdata().tolist() == [0, 1, 0, 1] and mean.get_ydata().tolist() == [1, 2, 3, 4]
    assert p99.get_ydata().tolist() == [5, 6, 7, 8]
    assert line.get_label() == "reference" and set(line.get_ydata()) == {0.5}
    assert panel.get_yscale() == "log"
    assert [tick.get_text() for tick in panel.get_xticklabels()] == ["a", "b"]


def test_a_closed_solid_shows_its_creases_and_a_smooth_one_nothing(tmp_path):
    """A box has no rims; a sphere neither rims nor creases, and is drawn all the same."""
    trimesh = pytest.importorskip("trimesh")
    for name, mesh, count in (
        ("box", trimesh.creation.box((100, 100, 100)), 12),
        ("ball", trimesh.creation.icosphere(subdivisions=3, radius=100), 0),
    ):
        path = tmp_path / f"{name}.stl"
        mesh.export(path)
        surface = surface_of(MeshFile(str(path)), 0.2)
        lines = outline(surface, surface.vertices[surface.triangles])
        assert len(lines) == count
        cells = pd.DataFrame({"depth_rate_total": np.zeros(len(surface.triangles))})
        cells.loc[0, "depth_rate_total"] = 1.0
        cells["cell_area"] = cell_areas(surface)
        assert surface_map_figure(surface, cells, "total").axes
