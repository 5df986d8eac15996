"""Wear of cells and parts of a surface: statistics weighted by area, tables with known sums."""

import numpy as np
import pandas as pd
import pytest

from abradem.dem.model import Setup
from abradem.geometry.build import prepared
from abradem.quantities import SAMPLED_NAMES, WEAR_MEASURES
from abradem.simulation.cell_columns import cell_columns
from abradem.wear.part_effects import part_effects
from abradem.wear.rates import element_rates
from abradem.wear.surface_cells import cell_table, part_table
from abradem.wear.window_errors import element_stderr, subset_statistics, weighted_statistics


def test_equal_areas_give_the_statistics_of_facets():
    rng = np.random.default_rng(1)
    wear = rng.exponential(size=(6, 500)) * (rng.random((6, 500)) > 0.3)
    weighted = weighted_statistics(wear, np.full(500, 2.0))
    plain = subset_statistics(wear) / 2.0
    assert weighted[:, [0, 1, 3]] == pytest.approx(plain[:, [0, 1, 3]], rel=1e-12)
    # The percentile is between the two facets that surround 99 % of the area.
    assert weighted[:, 2] == pytest.approx(plain[:, 2], rel=0.1)


def test_statistics_do_not_depend_on_how_cells_are_divided():
    """A cell divided into pieces of the same depth leaves all statistics as they are."""
    rng = np.random.default_rng(2)
    area = rng.uniform(0.5, 2.0, 200)
    wear = rng.exponential(size=200) * area
    wear[:50] = 0.0
    share = rng.uniform(0.1, 0.9, 200)
    divided = np.concatenate([wear * share, wear * (1.0 - share)])
    areas = np.concatenate([area * share, area * (1.0 - share)])
    whole = element_rates(wear, area, 2.0)
    assert element_rates(divided, areas, 2.0) == pytest.approx(whole, rel=0.02)
    assert element_rates(divided, areas, 2.0)["worn"] == pytest.approx(whole["worn"], rel=1e-12)
    assert element_rates(divided, areas, 2.0)["max"] == pytest.approx(whole["max"], rel=1e-12)


def test_statistics_of_few_cells_by_hand():
    wear, area = np.array([0.0, 6.0, 3.0, 1.0]), np.array([1.0, 2.0, 3.0, 4.0])
    found = element_rates(wear, area, 2.0, footprint_share=0.6)
    assert found == pytest.approx({"worn": 10 / 9 / 2, "footprint": 1.5, "p99": 1.5, "max": 1.5})


def test_errors_of_equal_cells_are_those_of_facets():
    rng = np.random.default_rng(3)
    parts = rng.exponential(size=(10, 40, 1))
    plain = element_stderr(parts, 0.5, 4.0)
    weighted = element_stderr(parts, np.full((40, 1), 0.5), 4.0)
    for name in ("worn", "footprint", "max"):
        assert weighted[name] == pytest.approx(plain[name], rel=1e-9)


GEOMETRY = {
    "kind": "plates",
    "plates": [
        {"length": 0.2, "width": 0.1, "angle": "plate_angle", "name": "upper"},
        {"length": 0.1, "width": 0.1, "angle": 150.0, "drop": 0.3, "name": "lower"},
    ],
}
SETUP = Setup(geometry=GEOMETRY, facet_size=0.05, patch_length=0.05, patch_width=0.05)


@pytest.fixture
def tables():
    """Two cases in which every cell has worn by its area, the lower plate twice as much."""
    rows = {name: [0.01, 0.01] for name in SAMPLED_NAMES}
    cases = pd.DataFrame({**rows, "case_id": [3, 4], "archard_constant": [1e-9, 2e-9]})
    cases["plate_angle"], cases["particle_velocity_y"] = [20.0, 50.0], -1.0
    maps = []
    for case in cases.to_dict("records"):
        surface = prepared(SETUP, case).surface
        sums = np.tile([[2.0], [6.0], [60.0], [1.0], [0.5], [3.0]], len(surface.triangles))
        columns = cell_columns(surface, sums)
        worn = columns["cell_area"] * (1.0 + surface.part)
        maps.append(
            pd.DataFrame(
                {
                    "case_id": case["case_id"],
                    "facet_x": np.arange(len(surface.triangles)),
                    "facet_z": 0,
                    **{f"wear_{measure}": worn for measure in WEAR_MEASURES},
                    **columns,
                }
            )
        )
    runs = pd.DataFrame(
        {"case_id": [3, 4], "status": "ok", "window_start": 1.0, "window_end": [5.0, 3.0]}
    )
    return pd.concat(maps, ignore_index=True), runs, cases


def test_cells_have_the_depth_of_archards_law(tables):
    """W J / (A t): with J = A it is W / t."""
    cells = cell_table(*tables, SETUP)
    upper = cells[cells["part_name"] == "upper"]
    expected = upper["case_id"].map({3: 1e3 * 1e-9 / 4.0, 4: 1e3 * 2e-9 / 2.0})
    assert upper["depth_rate_friction"].to_numpy() == pytest.approx(expected.to_numpy())
    assert (cells["impact_speed"] == 3.0).all() and (cells["impact_angle"] == 30.0).all()
    normal = cells[["normal_x", "normal_y", "normal_z"]].to_numpy()
    slope = np.radians(upper["case_id"].map({3: 20.0, 4: 50.0}).to_numpy())
    assert normal[upper.index] == pytest.approx(
        np.column_stack([-np.sin(slope), np.cos(slope), 0.0 * slope])
    )


def test_parts_have_the_mean_of_their_cells(tables):
    parts = part_table(cell_table(*tables, SETUP)).set_index(["case_id", "part_name"])
    assert parts.loc[(3, "upper"), "area"] == pytest.approx(0.02)
    for statistic in ("mean", "worn", "footprint", "p99", "max"):
        column = f"wear_total_{statistic}"
        assert parts.loc[(3, "upper"), column] == pytest.approx(1e3 * 1e-9 / 4.0)
        assert parts.loc[(4, "lower"), column] == pytest.approx(2.0 * 1e3 * 2e-9 / 2.0)


def test_cases_without_a_window_have_no_cells(tables):
    maps, runs, cases = tables
    assert cell_table(maps, runs.assign(window_end=np.nan), cases, SETUP).empty
    assert part_table(cell_table(maps, runs.assign(window_end=np.nan), cases, SETUP)).empty


def test_effects_name_what_rises_and_what_falls():
    """The rate of part a rises with the angle and falls with the radius of the arc."""
    angle = np.array([5.0, 1.0, 4.0, 2.0, 3.0, 6.0])
    cases = pd.DataFrame(
        {"case_id": range(6), "plate_angle": angle, "arc_radius": 9.0 - angle, "restitution": 0.5}
    )
    parts = pd.DataFrame({"case_id": range(6), "part_name": "a", "wear_total_mean": angle**2})
    found = part_effects(parts, cases, "wear_total_mean").set_index("quantity")
    assert set(found.index) == {"plate_angle", "arc_radius"}
    assert found.loc["plate_angle", "rank_correlation"] == pytest.approx(1.0)
    assert found.loc["arc_radius", "rank_correlation"] == pytest.approx(-1.0)
    row = found.loc["plate_angle"]
    assert (row["low_from"], row["low_to"], row["low_rate"]) == (1.0, 2.0, 2.5)
    assert (row["high_from"], row["high_to"], row["high_rate"]) == (5.0, 6.0, 30.5)
    assert found.loc["arc_radius", "unit"] == "m" and row["unit"] == "deg"
