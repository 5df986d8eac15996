"""Generated and divided surfaces against closed forms: areas, places, seams."""

import dataclasses

import numpy as np
import pytest

from abradem.geometry.chute import transfer_chute
from abradem.geometry.screw import ScrewSize, screw
from abradem.geometry.shape import (
    GeometryError,
    Shape,
    areas,
    degenerate,
    divided,
    given_twice,
    selected,
    unit_normals,
    welded,
)
from abradem.geometry.shapes import Rectangle, arc_chute, plates

SIZES = ScrewSize(0.4, 0.075, 0.02, 0.1, 0.005, 0.1)


def area_of(shape):
    return areas(shape.vertices, shape.triangles).sum()


def edges_of(shape):
    ends = np.sort(shape.triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    return np.unique(ends, axis=0, return_counts=True)


def test_a_chain_of_one_plate_is_the_plate():
    shape = plates([Rectangle(0.3, 0.2, 35.0)], 0.01)
    assert area_of(shape) == pytest.approx(0.06, rel=1e-12)
    slope = np.radians(35.0)
    normal = unit_normals(shape.vertices, shape.triangles)
    assert np.allclose(normal, [-np.sin(slope), np.cos(slope), 0.0], atol=1e-12)
    half = 0.15 * np.array([np.cos(slope), np.sin(slope)])
    assert np.allclose(shape.vertices.max(axis=0), [*half, 0.1])
    assert np.allclose(shape.vertices.min(axis=0), [*-half, -0.1])


def test_the_next_plate_begins_where_gap_and_drop_say():
    """The first runs from (0.1, 0.1 tan) to its negative along -x; the next turns back."""
    chain = [Rectangle(0.2, 0.1, 45.0), Rectangle(0.2, 0.1, 135.0, gap=0.03, drop=0.05)]
    shape = plates(chain, 0.2)
    end = -0.1 * np.sqrt(0.5) * np.ones(2)
    begin = end + np.array([-0.03, -0.05])
    lower = shape.vertices[np.unique(shape.triangles[shape.part == 1])]
    assert np.allclose(lower[:, 1].max(), begin[1])
    assert np.allclose(lower[:, 0].min(), begin[0])
    assert np.allclose(lower[:, 0].max(), begin[0] + 0.2 * np.sqrt(0.5))
    normal = unit_normals(shape.vertices, shape.triangles)
    assert (normal[:, 1] > 0.0).all()


@pytest.mark.parametrize(("begin", "end"), [(80.0, 10.0), (10.0, 80.0)])
def test_an_arc_is_on_its_circle_and_its_area_tends_to_the_cylinder(begin, end):
    shape = arc_chute(0.4, begin, end, 0.3, 0.005)
    turn = np.radians(70.0)
    count = len(np.unique(shape.vertices[:, :2].round(12), axis=0)) - 1
    # Chords of 2 r sin(turn / 2n).
    chords = count * 2.0 * 0.4 * np.sin(turn / (2 * count)) * 0.3
    assert area_of(shape) == pytest.approx(chords, rel=1e-12)
    assert area_of(shape) == pytest.approx(0.4 * turn * 0.3, rel=1e-4)
    slope = np.radians(begin)
    axis = 0.4 * np.array([-np.sin(slope), np.cos(slope)]) * (1.0 if begin > end else -1.0)
    assert np.allclose(np.linalg.norm(shape.vertices[:, :2] - axis, axis=1), 0.4)
    assert (unit_normals(shape.vertices, shape.triangles)[:, 1] > 0.0).all()
    assert shape.vertices[:, 1].max() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("size", [0.05, 0.021, 0.008])
@pytest.mark.parametrize(
    "shape",
    [
        plates([Rectangle(0.3, 0.2, 20.0), Rectangle(0.2, 0.2, 140.0)], 1.0),
        arc_chute(0.3, 70.0, 20.0, 0.2, 1.0),
        transfer_chute(),
    ],
    ids=["plates", "arc", "chute"],
)
def test_division_keeps_areas_and_seams(shape, size):
    """No edge is too long, each part keeps its area, and no vertex is on a neighbour's edge."""
    found = divided(shape, size, 10**6)
    corners = found.vertices[found.triangles]
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() <= size * 1.000001
    for part in range(len(shape.names)):
        before = areas(shape.vertices, shape.triangles[shape.part == part]).sum()
        after = areas(found.vertices, found.triangles[found.part == part]).sum()
        assert after == pytest.approx(before, rel=1e-12)
    # Where neighbours share whole edges, the rim is as long as before the division.
    for one in (shape, found):
        edges, count = edges_of(one)
        length = np.linalg.norm(one.vertices[edges[:, 0]] - one.vertices[edges[:, 1]], axis=1)
        rim = length[count == 1].sum()
        if one is shape:
            expected = rim
    assert rim == pytest.approx(expected, rel=1e-9)


def test_division_keeps_the_order_of_the_triangles():
    shape = plates([Rectangle(0.3, 0.2, 20.0), Rectangle(0.2, 0.2, 140.0)], 1.0)
    found = divided(shape, 0.05, 10**6)
    assert (np.diff(found.part) >= 0).all()
    assert np.allclose(
        unit_normals(found.vertices, found.triangles)[found.part == 1],
        unit_normals(shape.vertices, shape.triangles)[shape.part == 1][0],
    )


def test_too_many_cells_are_refused():
    with pytest.raises(GeometryError, match=r"more than 1000 triangles \(allowed: larger facets\)"):
        divided(plates([Rectangle(1.0, 1.0, 0.0)], 1.0), 0.01, 1000)


def test_welding_joins_the_vertices_of_triangles_with_corners_of_their_own():
    shape = plates([Rectangle(0.3, 0.2, 20.0)], 0.05)
    loose = Shape(
        shape.vertices[shape.triangles].reshape(-1, 3),
        np.arange(3 * len(shape.triangles)).reshape(-1, 3),
        shape.part,
        shape.names,
    )
    found = welded(loose)
    assert len(found.vertices) == len(shape.vertices)
    assert np.array_equal(found.vertices[found.triangles], shape.vertices[shape.triangles])


def test_triangles_without_area_and_given_twice_are_found():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], dtype=float)
    triangles = np.array([[0, 1, 2], [0, 1, 3], [2, 0, 1]])
    shape = Shape(vertices, triangles, np.zeros(3, int), ("one",))
    assert degenerate(shape).tolist() == [False, True, False]
    assert given_twice(shape).tolist() == [False, False, True]
    assert selected(shape, ~degenerate(shape)).triangles.tolist() == [[0, 1, 2], [2, 0, 1]]


def test_a_triangle_without_area_is_found_though_its_corners_were_rounded():
    """Three points of a line in single precision, as in a binary STL file; a thin strip stays."""
    line = np.outer([0.0, 1.0, 3.0], [np.cos(0.6), np.sin(0.6), 0.0])
    vertices = np.vstack([line, [[0.0, 2.0, 0.0], [0.0, 2.0, 1e-5]]])
    shape = Shape(
        vertices.astype(np.float32).astype(float),
        np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
        np.zeros(3, int),
        ("one",),
    )
    assert areas(shape.vertices, shape.triangles)[0] > 0.0
    assert degenerate(shape).tolist() == [True, False, False]


def test_a_screw_has_the_area_of_a_helicoid_and_turns_within_its_trough():
    """Area of a helicoid: integral of sqrt(r^2 + c^2) dr dt with c = pitch / 2 pi."""
    shape = screw(SIZES, 0.004)
    c = SIZES.pitch / (2.0 * np.pi)
    turn = 2.0 * np.pi * SIZES.length / SIZES.pitch
    r = np.linspace(SIZES.shaft_radius, SIZES.radius, 20001)
    exact = turn * np.trapezoid(np.hypot(r, c), r)
    flight = areas(shape.vertices, shape.triangles[shape.part == 0]).sum()
    assert flight == pytest.approx(exact, rel=2e-3)
    radius = np.hypot(*shape.vertices[np.unique(shape.triangles[shape.part == 0])][:, 1:].T)
    assert radius.max() == pytest.approx(SIZES.radius)
    trough = shape.vertices[np.unique(shape.triangles[shape.part == 2])]
    below = trough[(trough[:, 1] < -1e-9) & (trough[:, 0] < SIZES.length - 1e-9)]
    assert np.allclose(np.hypot(below[:, 1], below[:, 2]), SIZES.radius + SIZES.clearance)
    # It is open at x = 0, where it conveys to.
    at_end = np.isclose(trough[:, 0], 0.0)
    assert np.hypot(*trough[at_end][:, 1:].T).min() > SIZES.radius


def test_a_positive_rotation_moves_the_flight_to_the_open_end():
    shape = screw(SIZES, 0.01)
    flight = shape.vertices[np.unique(shape.triangles[shape.part == 0])]
    turned = np.radians(5.0)
    y, z = flight[:, 1], flight[:, 2]
    moved = np.arctan2(
        z * np.cos(turned) + y * np.sin(turned), y * np.cos(turned) - z * np.sin(turned)
    )
    # The helicoid at angle theta is at x = pitch theta / 2 pi, so it is now 5 degrees behind.
    expected = (flight[:, 0] / SIZES.pitch * 2.0 * np.pi + turned) % (2.0 * np.pi)
    assert np.allclose(np.exp(1j * moved), np.exp(1j * expected))
    shift = -SIZES.pitch * turned / (2.0 * np.pi)
    assert shift < 0.0


def test_a_shaft_wider_than_the_flight_is_refused():
    with pytest.raises(GeometryError, match=r"0\.09 m, must be less than that of the flight"):
        screw(dataclasses.replace(SIZES, shaft_radius=0.09), 0.01)
