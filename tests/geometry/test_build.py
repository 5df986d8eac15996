"""From a description to the surface and the factory of the engine, and what is refused."""

import math

import numpy as np
import pytest

from abradem.dem.model import Case, Setup
from abradem.dem.surface import Feed, standing_surface
from abradem.geometry.build import filled_in, mesh_file, prepared, shape_of, surface_of
from abradem.geometry.chute import transfer_chute
from abradem.geometry.feed import check_box, check_jet, feed_above, height_below
from abradem.geometry.kinds import Arc, MeshFile, Motion, Plates, Screw, geometry_of
from abradem.geometry.mesh_files import write_stl
from abradem.geometry.shape import GeometryError, areas
from abradem.geometry.shapes import Rectangle, arc_chute, plates
from abradem.geometry.unrolled import unrolled_part

PLATE = Plates((Rectangle(0.3, 0.2, 30.0),))
CASE = vars(Case(particle_radius=0.01))


def test_the_factory_is_above_the_plate_where_that_of_the_plate_is():
    setup = Setup(geometry=PLATE, facet_size=0.05, patch_length=0.1, patch_width=0.08)
    built = prepared(setup, CASE)
    assert built.feed.centre == pytest.approx((0.0, 0.25, 0.0), abs=1e-12)
    assert built.feed.along == (0.1, 0.0, 0.0) and built.feed.across == (0.0, 0.0, 0.08)
    assert built.removal_box is None
    total = areas(built.surface.vertices, built.surface.triangles).sum()
    assert total == pytest.approx(0.06, rel=1e-12)


def test_a_setup_without_a_geometry_and_one_that_is_prepared_stay_as_they_are():
    setup = Setup()
    assert prepared(setup, CASE) is setup
    built = prepared(Setup(geometry=PLATE), CASE)
    assert prepared(built, CASE) is built


def test_the_height_below_a_place_is_that_of_the_highest_surface():
    shape = plates([Rectangle(0.3, 0.2, 30.0), Rectangle(0.3, 0.2, 30.0, gap=-0.3, drop=0.2)], 0.04)
    slope = math.tan(math.radians(30.0))
    for x in (-0.1, 0.0, 0.05):
        assert height_below(shape, x, 0.03) == pytest.approx(x * slope, abs=1e-12)
    assert height_below(shape, 5.0, 0.0) == -math.inf


def test_a_jet_beside_the_geometry_is_told_and_one_that_is_thrown_at_it_is_not():
    """Thrown level from a distance of 1 m at 2 m/s, it falls by 9.81 / 8 m on the way."""
    wall = plates([Rectangle(0.3, 0.2, 90.0)], 1.0)
    side = dict(along=(0.01, 0.0, 0.0), across=(0.0, 0.0, 0.01), direction=(-1.0, 0.0, 0.0))
    fall = 9.81 / 8.0
    check_jet(wall, Feed(centre=(1.0, fall, 0.0), **side), 2.0, 9.81)
    for centre in ((1.0, fall + 0.2, 0.0), (1.0, fall, 0.3), (-1.0, fall, 0.0)):
        with pytest.raises(GeometryError, match="misses the geometry, which is in x, y, z"):
            check_jet(wall, Feed(centre=centre, **side), 2.0, 9.81)


def test_a_jet_without_gravity_is_straight():
    wall = plates([Rectangle(0.3, 0.2, 90.0)], 1.0)
    side = dict(along=(0.01, 0.0, 0.0), across=(0.0, 0.0, 0.01), direction=(-1.0, 0.0, 0.0))
    check_jet(wall, Feed(centre=(50.0, 0.1, 0.0), **side), 2.0, 0.0)
    with pytest.raises(GeometryError, match="misses"):
        check_jet(wall, Feed(centre=(50.0, 0.2, 0.0), **side), 2.0, 0.0)


def test_no_surface_below_the_factory_is_told():
    shape = plates([Rectangle(0.3, 0.2, 0.0)], 1.0)
    with pytest.raises(GeometryError, match="no surface below the factory at x = 2 m"):
        feed_above(shape, (2.0, 0.0), 0.1, 0.1, 0.1)


def test_a_particle_wider_than_the_geometry_is_told():
    with pytest.raises(GeometryError, match=r"of radius 0\.2 m is wider than the geometry, 0\.2 m"):
        prepared(Setup(geometry=PLATE), {**CASE, "particle_radius": 0.2})


@pytest.mark.parametrize(
    ("unit", "radius", "hint"),
    [
        ("mm", 0.02, r"chute\.stl was read with unit mm, is its unit m \(1\.17898 m\)\?$"),
        ("mm", 0.002, r"is its unit cm \(0\.0117898 m\) or m \(1\.17898 m\) or in \(0\.0299"),
        ("mm", 60.0, r"chute\.stl was read with unit mm$"),
        ("m", 0.3, r"chute\.stl was read with unit m$"),
    ],
)  # fmt: skip
def test_units_are_told_with_which_a_particle_would_fit_a_mesh(tmp_path, unit, radius, hint):
    write_stl(transfer_chute(), tmp_path / "chute.stl", unit="m")
    geometry = {"kind": "mesh", "file": str(tmp_path / "chute.stl"), "unit": unit}
    with pytest.raises(GeometryError, match=hint):
        prepared(Setup(geometry=geometry), {**CASE, "particle_radius": radius})


def test_values_of_the_case_replace_the_names_of_its_quantities():
    described = {
        "shape": {
            "kind": "plates",
            "plates": [
                {"length": 0.3, "width": 0.2, "angle": "plate_angle"},
                {"length": "plate_2_length", "width": 0.2, "angle": 150.0, "name": "lower"},
            ],
        },
        "centre": None,
        "direction": [0.0, -1.0, 0.0],
        "removal_box": [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]],
    }
    setup = Setup.from_dict({"geometry": described, "facet_size": 0.5})
    case = {**CASE, "plate_angle": 40.0, "plate_2_length": 0.25}
    built = prepared(setup, case)
    assert built.surface.part_names == ("plate_1", "lower")
    shape = shape_of(built.surface)
    lower = areas(shape.vertices, shape.triangles)[shape.part == 1].sum()
    assert lower == pytest.approx(0.05)
    upper = shape.vertices[np.unique(shape.triangles[shape.part == 0])]
    assert upper[:, 1].max() == pytest.approx(0.15 * math.sin(math.radians(40.0)))
    assert built.removal_box == ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    with pytest.raises(GeometryError, match="the case has no quantity 'plate_2_length'"):
        filled_in(described["shape"], CASE)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kind": "cone"}, r"kind = 'cone' \(allowed: plates, arc, mesh, screw\)"),
        ({"kind": "arc", "radius": 0.4}, r"arc: begin is missing, end is missing"),
        (
            {"kind": "arc", "radius": 0.4, "begin": 0, "end": 9, "width": 1, "wide": 2},
            "arc: wide is unknown",
        ),
        (
            {"kind": "arc", "radius": -1.0, "begin": 0, "end": 9, "width": 1},
            r"arc.radius = -1.0 \(allowed above 0 ... 100\)",
        ),
        ({"kind": "plates", "plates": []}, "plates: there is none"),
        (
            {"kind": "plates", "plates": [{"length": 300, "width": 1, "angle": 3}]},
            r"plates\[0\].length = 300 \(allowed above 0 ... 100\)",
        ),
        (
            {"kind": "plates", "plates": [{"length": 1, "width": 1, "angle": math.nan}]},
            r"plates\[0\].angle = nan",
        ),
    ],
)
def test_descriptions_that_are_wrong_are_told(values, message):
    with pytest.raises(GeometryError, match=message):
        geometry_of(values)


def test_belts_run_along_their_plates_and_screws_turn_about_x():
    belt = Plates((Rectangle(0.3, 0.2, 30.0, belt=2.0), Rectangle(0.3, 0.2, 0.0)))
    surface = surface_of(belt, 0.1)
    slope = math.radians(30.0)
    assert np.allclose(
        surface.velocity, [[-2.0 * math.cos(slope), -2.0 * math.sin(slope), 0.0], [0, 0, 0]]
    )
    screw = surface_of(Screw(0.4, 0.075, 0.02, 0.1, 0.005, 0.1, 30.0), 0.05)
    turning = dict(zip(screw.part_names, screw.angular_velocity, strict=True))
    assert turning == pytest.approx({"flight": math.pi, "shaft": math.pi, "trough": 0.0})
    assert np.allclose(screw.axis_direction[0], [1.0, 0.0, 0.0])


def test_parts_of_a_mesh_move_by_their_names(tmp_path):
    path = tmp_path / "two.stl"
    write_stl(plates([Rectangle(0.3, 0.2, 0.0), Rectangle(0.3, 0.2, 30.0)], 0.1), path)
    moving = (Motion("plate_2", belt=(1.0, 0.0, 0.0)),)
    surface = surface_of(MeshFile(str(path), moving=moving, offset=(0.0, 1.0, 0.0)), 0.1)
    place = surface.part_names.index("plate_2")
    assert surface.velocity[place].tolist() == [1.0, 0.0, 0.0]
    assert surface.vertices[:, 1].max() == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(GeometryError, match=r"no part 'lid' \(allowed: plate_1, plate_2\)"):
        surface_of(MeshFile(str(path), moving=(Motion("lid"),)), 0.1)


def test_the_file_of_a_mesh_is_known():
    assert mesh_file({"shape": {"kind": "mesh", "file": "a.stl"}}) == "a.stl"
    assert mesh_file({"kind": "mesh", "file": "a.stl"}) == "a.stl"
    assert mesh_file({"shape": {"kind": "arc"}}) is None
    assert mesh_file(None) is None


def test_plates_and_arcs_are_laid_out_with_their_areas():
    """s is measured from the higher end."""
    for geometry in (Arc(0.4, 80.0, 10.0, 0.3), PLATE):
        surface = surface_of(geometry, 0.02)
        flat, across = unrolled_part(surface, 0)
        assert across == "z"
        first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
        twice = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        expected = areas(surface.vertices, surface.triangles)
        assert np.allclose(0.5 * np.abs(twice), expected, rtol=1e-9)
        high = surface.vertices[surface.triangles][:, :, 1].argmax()
        assert flat[..., 0].reshape(-1)[high] == pytest.approx(0.0, abs=1e-12)
        assert flat[..., 0].min() == pytest.approx(0.0, abs=1e-12)
    arc = unrolled_part(surface_of(Arc(0.4, 80.0, 10.0, 0.3), 0.002), 0)
    length = np.ptp(arc.corners[..., 0])
    assert length == pytest.approx(0.4 * math.radians(70.0), rel=1e-5)


def test_an_arc_is_laid_out_where_triangles_are_divided_unevenly():
    """An edge that is not divided passes the middle of its neighbour's; lengths are the line's."""
    vertices = [[0, 1, 0], [0, 1, 1], [0, 0, 0], [0, 0, 1], [1, 0, 0], [1, 0, 1], [0.5, 0, 1]]
    triangles = [[0, 1, 2], [1, 3, 2], [2, 4, 6], [2, 6, 3], [4, 5, 6]]
    flat = unrolled_part(standing_surface(vertices, triangles), 0)
    assert flat.corners[2].tolist() == [[1.0, 0.0], [2.0, 0.0], [1.5, 1.0]]
    assert flat.corners[0].tolist() == [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]


def test_the_parts_of_the_chute_are_laid_out_whatever_the_size_of_the_facets(tmp_path):
    write_stl(transfer_chute(), tmp_path / "chute.stl")
    for size in (0.03, 0.04, 0.05):
        surface = surface_of(MeshFile(str(tmp_path / "chute.stl")), size)
        for part, name in enumerate(surface.part_names):
            flat = unrolled_part(surface, part)
            assert (flat is not None) == (name in ("hood", "back", "spoon")), (size, name)


def test_no_part_of_a_screw_is_laid_out():
    surface = surface_of(Screw(0.4, 0.075, 0.02, 0.1, 0.005, 0.1, 30.0), 0.05)
    assert [unrolled_part(surface, part) for part in range(3)] == [None, None, None]


@pytest.mark.parametrize(
    ("normal", "across", "down"),
    [
        ([-0.5, np.sqrt(0.75), 0.0], "z", [-np.sqrt(0.75), -0.5, 0.0]),
        ([0.0, 1.0, 0.0], "z", [-1.0, 0.0, 0.0]),
        ([0.0, 0.0, 1.0], "x", [0.0, -1.0, 0.0]),
        ([1.0, 0.0, 0.0], "z", [0.0, -1.0, 0.0]),
        ([0.48, 0.6, 0.64], "w", [0.36, -0.8, 0.48]),
    ],
)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_flat_part_of_any_direction_is_laid_out_down_its_slope(normal, across, down, side):
    """With the rounding of a 32-bit file."""
    normal, down = side * np.array(normal), np.array(down)
    level = np.cross(normal, down)
    plane = np.array([[0, 0], [2, 0], [2, 1], [0, 1]]) @ np.stack([down, level])
    vertices = np.add(plane, [0.3, 0.2, 0.1]).astype(np.float32).astype(float)
    surface = standing_surface(vertices, [[0, 1, 2], [2, 3, 0]])
    flat = unrolled_part(surface, 0)
    assert flat.across == across
    assert flat.corners[0, :, 0] == pytest.approx([0.0, 2.0, 2.0], abs=1e-6)
    assert np.ptp(flat.corners[0, :, 1]) == pytest.approx(1.0, abs=1e-6)
    if across == "w":
        assert flat.corners[..., 1].min() == 0.0
    else:
        places = vertices[surface.triangles][..., "xyz".index(across)]
        assert flat.corners[..., 1] == pytest.approx(places, abs=1e-6)


def test_an_arc_of_one_angle_is_refused():
    with pytest.raises(GeometryError, match=r"two angles that differ \(both are 20 deg\)"):
        arc_chute(0.4, 20.0, 20.0, 0.3, 0.01)


def test_a_file_name_alone_is_no_geometry():
    values = {"plate_angle": 0.0, "particle_radius": 0.01, "particle_velocity_y": -1.0}
    with pytest.raises(GeometryError, match=r"geometry = 'chute.stl' \(allowed: a mapping such as"):
        prepared(Setup(geometry="chute.stl"), values)


def test_the_factory_lies_in_the_removal_box():
    feed = Feed((0.1, 0.5, 0.0), (0.2, 0.0, 0.0), (0.0, 0.0, 0.4), (0.0, -1.0, 0.0))
    check_box(feed, ((0.0, -1.0, -0.2), (0.2, 0.5, 0.2)))
    with pytest.raises(GeometryError, match=r"corner \(0.2, 0.5, -0.2\) m .* outside the removal"):
        check_box(feed, ((0.0, -1.0, -0.2), (0.19, 0.5, 0.2)))
