"""Fused operations compared with exact fractions, and vector functions compared with numpy."""

from fractions import Fraction

import numpy as np
import pytest
from naive import fused

from abradem.dem.cache import kernel
from abradem.dem.vectors import cross, dot, fma, plus, scaled, split


@kernel
def all_of(a, b, share):
    return dot(a, b), cross(a, b), plus(a, share, b), scaled(a, share), split(a, b)


@kernel
def fused_by_kernel(a, b, c):
    return fma(a, b, c)


def numbers(count):
    generator = np.random.default_rng(8)
    return generator.standard_normal((count, 3)) * 10.0 ** generator.integers(-9, 9, (count, 3))


def test_a_product_and_a_sum_are_rounded_once():
    for a, b, c in numbers(500):
        assert fused_by_kernel(a, b, c) == fused(a, b, c)
        # A product minus its rounded value is exactly the rounding error.
        assert fused_by_kernel(a, b, -(a * b)) == float(Fraction(a) * Fraction(b) - Fraction(a * b))


def test_whole_numbers_are_taken_as_floats():
    assert fused_by_kernel(2, 3, 4) == 10.0


def test_vectors_are_those_of_numpy():
    for a, b in zip(numbers(200), numbers(400)[200:], strict=True):
        product, perpendicular, sum_, larger, _ = all_of(tuple(a), tuple(b), 0.3)
        scale = np.linalg.norm(a) * np.linalg.norm(b)
        assert product == pytest.approx(a @ b, rel=0.0, abs=1e-15 * scale)
        np.testing.assert_allclose(perpendicular, np.cross(a, b), rtol=0.0, atol=1e-15 * scale)
        np.testing.assert_allclose(sum_, a + 0.3 * b, rtol=0.0, atol=1e-15 * np.abs([*a, *b]).max())
        np.testing.assert_array_equal(larger, 0.3 * a)


def test_a_vector_is_split_along_a_direction():
    for v, n in zip(numbers(100), numbers(300)[200:], strict=True):
        n /= np.linalg.norm(n)
        along, across = all_of(tuple(v), tuple(n), 0.0)[4]
        size = np.linalg.norm(v)
        assert abs(np.dot(across, n)) < 1e-15 * size
        np.testing.assert_allclose(along * n + across, v, rtol=0.0, atol=1e-15 * size)
