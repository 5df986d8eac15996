"""Parts that turn: closed forms of a rotation, and what stays."""

import math

import numpy as np

from abradem.geometry.build import moving
from abradem.geometry.kinds import Motion
from abradem.geometry.shape import Shape
from abradem.geometry.turning import corners_at, turned_about, turning_parts

TWO = Shape(
    np.array([[1.0, 0, 0], [2, 0, 0], [1, 1, 0], [1, 1, 1]]),
    np.array([[0, 1, 2], [0, 2, 3]]),
    np.array([0, 1]),
    ("drum", "wall"),
)


def test_a_quarter_turn_about_an_axis_beside_the_origin():
    """(2, 0, 0) about the line through (1, 0, 0) along +y, right-handed: x goes to -z."""
    points = np.array([[2.0, 0.0, 0.0], [1.0, 5.0, 0.0], [1.0, 0.0, 1.0]])
    found = turned_about(points, (1.0, 0.0, 0.0), (0.0, 3.0, 0.0), 0.5 * math.pi)
    np.testing.assert_allclose(found, [[1, 0, -1], [1, 5, 0], [2, 0, 0]], atol=1e-15)


def test_only_the_part_that_turns_moves_and_is_back_after_a_turn():
    surface = moving(TWO, [Motion("drum", revolutions=30.0, axis=(0.0, 0.0, 1.0))])
    assert turning_parts(surface) == [0]
    still = TWO.vertices[TWO.triangles]
    # 30 turns a minute are half a turn in a second.
    half = corners_at(surface, 1.0)
    np.testing.assert_allclose(half[0], still[0] * [-1.0, -1.0, 1.0], atol=1e-14)
    np.testing.assert_array_equal(half[1], still[1])
    np.testing.assert_allclose(corners_at(surface, 2.0), still, atol=1e-14)


def test_a_belt_stays_where_it_is():
    surface = moving(TWO, [Motion("wall", belt=(1.0, 0.0, 0.0))])
    np.testing.assert_array_equal(corners_at(surface, 3.0), TWO.vertices[TWO.triangles])
