"""Dimensionless groups and the power law compared with known laws."""

from dataclasses import fields

import numpy as np
import pytest
from tables import drawn

from abradem import Setup
from abradem.learning.physical.power_law import SHARES, PowerLaw
from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.surrogate.groups import (
    GROUP_NAMES,
    Jet,
    fall_height,
    group_columns,
    group_matrix,
    jet_of,
    jet_width,
    mass_rate,
    squared_impact_speed,
    wear_scale,
)

JET = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)


def columns(n=50, **fixed):
    table = drawn(n, **fixed)
    return {name: table[name].to_numpy() for name in SAMPLED_NAMES}


def test_groups_do_not_depend_on_the_units():
    values = columns()
    length, time, mass = 3.0, 0.5, 7.0
    units = {
        "shear_modulus": mass / length / time**2, "density": mass / length**3,
        "radius": length, "velocity_y": length / time, "constant": length * time**2 / mass,
    }  # fmt: skip
    scaled = {
        name: column * next((f for key, f in units.items() if name.endswith(key)), 1.0)
        for name, column in values.items()
    }
    jet = Jet(0.25 * length, 9.81 * length / time**2, 4.0 * mass / time, None,
              0.09 * length**2, 0.01 * length**2)  # fmt: skip
    np.testing.assert_allclose(group_matrix(scaled, jet), group_matrix(values, JET), atol=1e-12)
    np.testing.assert_allclose(
        wear_scale(scaled, jet), wear_scale(values, JET) * length / time, rtol=1e-12
    )


def test_the_scale_is_proportional_to_wear_constant_and_to_the_power_of_the_jet():
    values = columns(restitution=0.5)
    doubled = {**values, "archard_constant": 2.0 * values["archard_constant"]}
    np.testing.assert_allclose(wear_scale(doubled, JET), 2.0 * wear_scale(values, JET))
    one = {name: column[:1] for name, column in values.items()}
    # 4 kg/s at v^2 = 9 + 2 g H on 0.09 m2, in mm.
    one |= {"particle_velocity_y": np.array([-3.0]), "archard_constant": np.array([1e-9])}
    expected = 1e3 * 1e-9 * 0.5 * 4.0 * (9.0 + 2.0 * 9.81 * 0.25) / 0.09
    assert wear_scale(one, JET)[0] == pytest.approx(expected)


def test_a_feed_by_number_is_the_mass_of_so_many_particles():
    values = columns()
    jet = JET._replace(mass_rate=None, number_rate=10.0)
    mass = 4.0 / 3.0 * np.pi * values["particle_radius"] ** 3 * values["particle_density"]
    np.testing.assert_allclose(mass_rate(values, jet), 10.0 * mass)


def test_frictionless_and_weightless_cases_have_finite_groups():
    values = columns(static_friction=0.0, rolling_friction=0.0)
    assert np.isfinite(group_matrix(values, JET)).all()
    assert np.isfinite(group_matrix(values, JET._replace(gravity=0.0))).all()


def test_the_jet_comes_from_the_set_up():
    from abradem.config import Config, setup_dict

    crowded = Jet(0.475, 9.81, 43.0, None, 0.09, 0.09, "arc", 0.31)
    assert jet_of(setup_dict(Config(study="a"))) == crowded


# Power law


EXPONENTS = {"log_froude": -0.1, "log_size": 0.2, "log_cauchy": 0.05, "log_rebound": 0.9,
             "plate_angle": 2.0, "plate_angle_squared": -1.0, "jet_width": 0.3}  # fmt: skip


def planted(n=150, noise=0.0, seed=0):
    x = group_matrix(columns(n), JET)
    angle = x[:, GROUP_NAMES.index("plate_angle")]
    target = -1.0 + EXPONENTS["plate_angle_squared"] * angle**2
    for name, exponent in EXPONENTS.items():
        if name in GROUP_NAMES:
            target = target + exponent * x[:, GROUP_NAMES.index(name)]
    return x, target + noise * np.random.default_rng(seed).standard_normal(n)


def test_a_law_without_noise_is_recovered_exactly():
    x, target = planted()
    law = PowerLaw().fit(x, target, np.zeros(len(target)))
    found = law.exponents().set_index("term")["exponent"]
    for name in GROUP_NAMES:
        assert found[name] == pytest.approx(EXPONENTS.get(name, 0.0), abs=1e-6)
    # v enters the scale as v^2, Fr and Ca as v^2, L as 1/v.
    assert found["impact_speed"] == pytest.approx(2.0 + 2.0 * -0.1 + 2.0 * 0.05)
    assert found["particle_density"] == pytest.approx(0.05)
    np.testing.assert_allclose(law.predict(x), target, atol=1e-6)


def test_exponents_of_quantities_are_what_a_step_of_the_quantity_does():
    x, target = planted(noise=0.1)
    law = PowerLaw().fit(x, target, np.zeros(len(target)))
    found = law.exponents().set_index("term")["exponent"]
    values, step = columns(5), 1.1
    for name in ("particle_radius", "particle_density", "archard_constant"):
        moved = {**values, name: step * values[name]}
        wear = [
            np.log(wear_scale(v, JET)) + law.predict(group_matrix(v, JET)) for v in (values, moved)
        ]
        np.testing.assert_allclose((wear[1] - wear[0]) / np.log(step), found[name], atol=1e-9)
    assert set(SHARES) <= set(found.index)


@pytest.mark.parametrize("by_number", [False, True])
@pytest.mark.parametrize("planted", [(0.0, 0.0), (2.0, 0.5), (3.0, 1.0)])
def test_planted_exponents_of_radius_and_density_come_back_under_both_feeds(by_number, planted):
    feed = {"mass_rate": None, "number_rate": 40.0} if by_number else {}
    jet = JET._replace(**feed)
    values = columns(200)
    radius, density = planted
    law = (
        np.log(values["archard_constant"] * squared_impact_speed(values, jet))
        + radius * np.log(values["particle_radius"])
        + density * np.log(values["particle_density"])
    )
    noise = 0.05 * np.random.default_rng(1).standard_normal(200)
    number = law + noise - np.log(wear_scale(values, jet))
    fit = PowerLaw().fit(group_matrix(values, jet), number, np.full(200, 0.05))
    found = fit.exponents((), by_number).set_index("term")
    expected = {
        "particle_radius": radius, "particle_density": density, "archard_constant": 1.0,
        "impact_speed": 2.0, "effective_youngs_modulus": 0.0,
    }  # fmt: skip
    for name, exponent in expected.items():
        row = found.loc[name]
        assert abs(row["exponent"] - exponent) <= 3.0 * row["standard_error"] + 1e-9, name
        assert row["variation"] == "varied" and row["standard_error"] < 0.15
    # The law predicts what a change of a quantity does under the feed of the cases.
    larger = {**values, "particle_radius": 1.1 * values["particle_radius"]}
    wear = [
        np.log(wear_scale(one, jet)) + fit.predict(group_matrix(one, jet))
        for one in (values, larger)
    ]
    slope = (wear[1] - wear[0]) / np.log(1.1)
    np.testing.assert_allclose(slope, found.loc["particle_radius", "exponent"], atol=1e-9)


def test_standard_errors_cover_the_truth_as_often_as_they_say():
    inside = []
    for seed in range(60):
        x, target = planted(150, 0.2, seed)
        table = PowerLaw().fit(x, target, np.zeros(len(target))).exponents().set_index("term")
        row = table.loc["particle_radius"]
        inside.append(abs(row["exponent"] - 0.2) < 1.96 * row["standard_error"])
    # Binomial(60, .95): fewer than 51 with a probability below 0.1 %.
    assert 51 <= sum(inside) <= 60


def test_rows_with_large_errors_count_less():
    x, target = planted(noise=0.02)
    error = np.full(len(target), 0.02)
    target[:20] += 3.0
    error[:20] = 3.0
    law = PowerLaw().fit(x, target, error)
    assert law.exponents().set_index("term")["exponent"]["log_rebound"] == pytest.approx(
        0.9, abs=0.1
    )


def test_the_equation_holds_every_exponent_with_its_error():
    x, target = planted(noise=0.1)
    law = PowerLaw().fit(x, target, np.zeros(len(target)))
    found = law.exponents().set_index("term")
    for text, sign in ((law.equation(), "+-"), (law.equation_tex(), r"\pm")):
        assert text.count(sign) == len(law.coefficients) - 1
        assert f"{found['exponent']['log_rebound']:.3f}" in text
    assert law.equation().startswith("y = W m' v^2 / (2 A) * ")


def test_constant_groups_and_few_rows_do_not_end_the_fit():
    x, target = planted(9)
    x[:, 3] = 1.0
    law = PowerLaw().fit(x, target, np.zeros(len(target)))
    assert np.isfinite(law.predict(x)).all()
    assert np.isnan(law.exponents().query("term == 'log_size'")["standard_error"]).all()


def test_the_fall_height_of_a_factory_on_an_arc_is_that_of_the_case():
    values = {row.name: np.full(4, np.mean(row.paper_range)) for row in SAMPLED}
    values["factory_angle"] = np.array([0.0, -60.0, -90.0, 90.0])
    arc = JET._replace(fall_height=0.385, angle_acts="arc", arc_radius=0.235)
    heights = np.array([0.385, 0.15 + 0.235 * 0.5, 0.15, 0.15])
    np.testing.assert_allclose(fall_height(values, arc), heights)
    np.testing.assert_allclose(
        squared_impact_speed(values, arc),
        values["particle_velocity_y"] ** 2 + 2.0 * 9.81 * heights,
    )
    np.testing.assert_array_equal(
        dict(zip(GROUP_NAMES, group_columns(values, arc), strict=True))["jet_width"], np.ones(4)
    )
    # Released faster from lower, the particles hit as fast, and the jet is the same.
    release = np.sqrt(values["particle_velocity_y"] ** 2 + 2.0 * 9.81 * (heights - 0.15))
    lower = {**values, "factory_angle": np.full(4, -90.0), "particle_velocity_y": -release}
    for mine, other in zip(group_columns(values, arc), group_columns(lower, arc), strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-13)
    np.testing.assert_allclose(wear_scale(values, arc), wear_scale(lower, arc), rtol=1e-13)


@pytest.mark.parametrize("acts", ["tilt", "level", "arc"])
def test_the_groups_know_the_factory_as_the_engine_does(acts):
    setup = Setup(fall_height=0.3, angle_acts=acts, arc_radius=0.2 if acts == "arc" else 0.0)
    jet = jet_of({field.name: getattr(setup, field.name) for field in fields(setup)})
    for angle in (-90.0, -37.0, 0.0, 20.0):
        height, tilt = setup.patch_place(angle)
        values = {"factory_angle": np.array([angle])}
        np.testing.assert_allclose(fall_height(values, jet), height, rtol=1e-15)
        np.testing.assert_allclose(jet_width(values, jet), np.cos(np.radians(tilt)), atol=1e-15)
