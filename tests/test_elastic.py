"""Elasticity formulas compared with independent values, each defined in one place only."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.special import beta

import abradem
from abradem import elastic

SOURCES = sorted(Path(abradem.__path__[0]).rglob("*.py"))


# Two equal spheres of 10 mm that collide at 20 m/s (Chung & Ooi 2011, test 1).
@pytest.mark.parametrize(
    ("young", "poisson", "density", "force", "overlap", "duration"),
    [(48e9, 0.20, 2800.0, 10_697.0, 274.1e-6, 40.34e-6),
     (20e9, 0.25, 2500.0, 7108.0, 368.3e-6, 54.20e-6)],
)  # fmt: skip
def test_hertz_impacts_of_two_spheres(young, poisson, density, force, overlap, duration):
    star = elastic.effective_youngs_modulus(young, poisson, young, poisson)
    mass = 0.5 * elastic.sphere_mass(0.01, density)
    stiffness = elastic.hertz_stiffness(star, 0.5 * 0.01)
    deepest = elastic.hertz_overlap(stiffness, mass, 20.0)
    assert stiffness * deepest**1.5 == pytest.approx(force, rel=1e-4)
    assert deepest == pytest.approx(overlap, rel=2e-4)
    assert elastic.hertz_duration(stiffness, mass, 20.0) == pytest.approx(duration, rel=2e-4)


# A sphere of 100 mm on a rigid plane at 0.2 m/s (Chung & Ooi 2011, test 2).
@pytest.mark.parametrize(
    ("young", "poisson", "density", "force", "overlap", "duration"),
    [(70e9, 0.30, 2699.0, 11_370.0, 49.72e-6, 731.7e-6),
     (40e9, 0.35, 1800.0, 7233.0, 52.12e-6, 767.1e-6)],
)  # fmt: skip
def test_hertz_impacts_on_a_rigid_plane(young, poisson, density, force, overlap, duration):
    star = elastic.effective_youngs_modulus(young, poisson, math.inf, 0.3)
    mass, stiffness = elastic.sphere_mass(0.1, density), elastic.hertz_stiffness(star, 0.1)
    deepest = elastic.hertz_overlap(stiffness, mass, 0.2)
    assert stiffness * deepest**1.5 == pytest.approx(force, rel=2e-3)
    assert deepest == pytest.approx(overlap, rel=2e-3)
    assert elastic.hertz_duration(stiffness, mass, 0.2) == pytest.approx(duration, rel=2e-3)


def test_the_duration_of_an_impact_is_the_beta_integral():
    assert elastic.HERTZ_DURATION == pytest.approx(0.8 * beta(0.4, 0.5), rel=1e-14)
    assert elastic.HERTZ_DURATION == pytest.approx(2.94327, abs=1e-5)


def test_the_effective_shear_modulus_of_the_comparison_with_other_codes():
    shear = [elastic.shear_modulus(15e9, 0.25), elastic.shear_modulus(200e9, 0.3)]
    assert elastic.effective_shear_modulus(shear[0], 0.25, shear[1], 0.3) == pytest.approx(
        3.1870817e9, rel=1e-7
    )
    assert elastic.effective_youngs_modulus(15e9, 0.25, 200e9, 0.3) == pytest.approx(
        14.914243e9, rel=1e-7
    )


def test_moduli_are_each_others_inverse():
    assert elastic.youngs_modulus(elastic.shear_modulus(70e9, 0.33), 0.33) == pytest.approx(70e9)


def test_a_half_and_a_perfect_rebound_have_their_damping_ratio():
    assert elastic.damping_ratio(1.0) == 0.0
    # ln .5 / sqrt(ln^2 .5 + pi^2) = -.693147 / 3.217151
    assert elastic.damping_ratio(0.5) == pytest.approx(-0.2154537, rel=1e-6)


def test_formulas_take_arrays_as_they_take_numbers():
    radius, density = np.array([0.01, 0.02]), np.array([2500.0, 3000.0])
    np.testing.assert_allclose(
        elastic.sphere_mass(radius, density),
        [elastic.sphere_mass(r, d) for r, d in zip(radius, density, strict=True)],
        rtol=4e-16,
    )
    np.testing.assert_allclose(
        elastic.rayleigh_time(radius, density, 6e9, 0.25),
        [elastic.rayleigh_time(r, d, 6e9, 0.25) for r, d in zip(radius, density, strict=True)],
        rtol=4e-16,
    )


@pytest.mark.parametrize(
    ("what", "pattern"),
    [("volume of a sphere", r"4(\.0)? ?/ ?3(\.0)? ?\* ?(math|np)\.pi"),
     ("Rayleigh time", r"0\.1631"),
     ("duration of an impact", r"2\.943|gamma\(0\.4\)"),
     ("overlap of an impact", r"\*\* 0\.4\b"),
     ("Young's modulus", r"2\.0 \* \(1\.0 \+ \w*(nu|poisson)"),
     ("effective shear modulus", r"\(2\.0 - \w*(nu|poisson)")],
)  # fmt: skip
def test_a_formula_has_one_home(what, pattern):
    homes = [
        path.name
        for path in SOURCES
        if any(
            re.search(pattern, line)
            for line in re.sub(r'""".*?"""', "", path.read_text(), flags=re.DOTALL).splitlines()
        )
    ]
    assert homes == ["elastic.py"], what
