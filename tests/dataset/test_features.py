"""Derived features compared with hand calculations."""

import math

import numpy as np
import pandas as pd
import pytest

from abradem.dataset import features
from abradem.quantities import FEATURE_NAMES, SAMPLED


@pytest.fixture
def cases():
    row = {
        "particle_shear_modulus": 4e9,
        "particle_poisson_ratio": 0.25,
        "particle_density": 3000.0,
        "equipment_shear_modulus": 80e9,
        "equipment_poisson_ratio": 0.3,
        "equipment_density": 7800.0,
        "restitution": 0.5,
        "rolling_friction": 0.05,
        "static_friction": 0.45,
        "archard_constant": 1e-9,
        "plate_angle": 30.0,
        "factory_angle": -45.0,
        "particle_radius": 0.02,
        "particle_velocity_y": -5.0,
    }
    return pd.DataFrame([row], index=[7])


def test_features_match_values_worked_out_by_hand(cases):
    row = features.derive(cases).loc[7]
    assert row["particle_youngs_modulus"] == pytest.approx(10e9, rel=1e-14)
    assert row["equipment_youngs_modulus"] == pytest.approx(208e9, rel=1e-14)
    # 1/E* = .9375/10e9 + .91/208e9 = 9.375e-11 + 4.375e-12 = 9.8125e-11
    assert row["effective_youngs_modulus"] == pytest.approx(1.0 / 9.8125e-11, rel=1e-14)
    # 1/G* = 1.75/4e9 + 1.7/80e9 = 4.375e-10 + 2.125e-11 = 4.5875e-10
    assert row["effective_shear_modulus"] == pytest.approx(1.0 / 4.5875e-10, rel=1e-14)
    # ln .5 = -.6931472, ln^2 e + pi^2 = .4804530 + 9.8696044 = 3.2171505^2
    assert row["damping_ratio"] == pytest.approx(-0.6931472 / 3.2171505, rel=1e-7)
    # m = 4/3 pi 8e-6 3000 = .1005310 kg, k = 4/3 1.0191083e10 .02 = 2.7176221e8 N/m
    assert row["damping_coefficient"] == pytest.approx(
        2 * math.sqrt(5 / 6) * -0.2154538 * math.sqrt(0.1005310 * 2.7176221e8), rel=1e-6
    )


def test_the_printed_damping_is_the_tables_times_a_constant(cases):
    table = features.derive(cases)["damping_coefficient"]
    printed = features.derive(cases, "printed")["damping_coefficient"]
    assert (table < 0).all() and (printed > 0).all()
    np.testing.assert_allclose(printed, -math.sqrt(6 / 5) * table, rtol=1e-14)


@pytest.mark.parametrize("form", features.DAMPING_COEFFICIENTS)
def test_an_elastic_contact_has_no_damping(cases, form):
    row = features.derive(cases.assign(restitution=1.0), form).loc[7]
    assert row["damping_ratio"] == 0.0
    assert row["damping_coefficient"] == 0.0


def test_features_stand_in_the_order_of_their_symbols_and_keep_the_sampled_values(cases):
    derived = features.derive(cases)
    assert tuple(derived.columns) == FEATURE_NAMES
    for row in SAMPLED:
        assert derived.loc[7, row.name] == cases.loc[7, row.name]


def test_an_unknown_form_and_a_missing_column_are_named(cases):
    with pytest.raises(ValueError, match="damping_coefficient = 'other' is unknown"):
        features.derive(cases, "other")
    with pytest.raises(ValueError, match="lacks column restitution"):
        features.derive(cases.drop(columns="restitution"))
