"""Invalid cases are refused with the name of the quantity; unusual valid cases are correct."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from abradem.dem import Case, Setup, simulate, simulation
from abradem.dem.contact import effective_moduli
from abradem.dem.impact import step_bias
from abradem.elastic import hertz_duration, hertz_stiffness, sphere_mass
from abradem.quantities import SAMPLED
from abradem.verification.scenes import Scene

CASE = Case(6e9, 0.25, 2500, 77e9, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 45.0, 0.0, 0.02, -5.0, seed=1)
SETUP = Setup(window=0.4, max_time=0.6, facet_size=0.05, duration=0.4)


def case(**values):
    return dataclasses.replace(CASE, **values)


def setup(**values):
    return dataclasses.replace(SETUP, **values)


@pytest.mark.parametrize(
    ("odd_case", "odd_setup", "words"),
    [
        ({}, {"time_step_fraction": 5.0}, "steps per contact at 5.47 m/s; at least 5"),
        ({}, {"time_step": 1e-13}, "steps per contact at 5.47 m/s; at most 100000"),
        ({}, {"time_step_fraction": 1e-300}, "time_step_fraction = 1e-300"),
        ({"particle_velocity_y": -1e4}, {}, "steps per contact at 1e+04 m/s"),
        ({"particle_velocity_y": -1e200}, {}, "particle_velocity_y = -1e"),
        ({"particle_velocity_y": math.nan}, {}, "particle_velocity_y = nan"),
        ({"restitution": 0.001}, {}, "restitution = 0.001 is outside"),
        ({"particle_radius": 1e-4}, {}, "of them in the air; at most 524288"),
        ({}, {"sample_interval": 1e-9, "duration": 50.0}, "samples in 50 s; at most 100000"),
        ({"plate_angle": 91.0}, {}, "plate_angle = 91.0"),
        ({"static_friction": -0.1}, {}, "static_friction = -0.1"),
        ({"static_friction": 5e-324}, {}, "static_friction = 5e-324 must be 0 or at least 1e-9"),
    ],
)  # fmt: skip
def test_what_cannot_be_simulated_is_refused_by_name(odd_case, odd_setup, words):
    with pytest.raises(ValueError) as refused:
        simulate(case(**odd_case), setup(**odd_setup))
    assert words in str(refused.value) and "\n" not in str(refused.value)


def step_of(odd_case, steps, speed):
    """Time step that divides the head-on elastic impact on the plate, s."""
    star = effective_moduli(odd_case.particle, odd_case.plate)[0]
    radius = odd_case.particle_radius
    mass = sphere_mass(radius, odd_case.particle_density)
    return hertz_duration(hertz_stiffness(star, radius), mass, speed) / steps


FALL = math.sqrt(25.0 + 2.0 * 9.81 * 0.25)


@pytest.mark.parametrize(
    ("e", "steps", "angle", "measure"),
    [
        (0.05, 6.0, 45.0, "total"), (0.05, 10.0, 0.0, "total"), (0.2, 8.0, 20.0, "total"),
        (0.5, 11.0, 10.0, "total"), (0.5, 6.0, 30.0, "total"), (0.95, 8.0, 25.0, "friction"),
    ],
)  # fmt: skip
def test_a_step_that_biases_the_first_impact_by_more_than_5_percent_is_refused(
    e, steps, angle, measure
):
    odd = case(restitution=e, plate_angle=angle, rolling_friction=0.0)
    with pytest.raises(ValueError) as refused:
        simulate(odd, setup(time_step=step_of(odd, steps, FALL)))
    assert f"biases {measure} of an impact at {max(angle, 10.0):g} deg" in str(refused.value)
    assert "at most 5 % are allowed" in str(refused.value)


@pytest.mark.parametrize(
    ("e", "steps", "angle"),
    [(0.05, 13.0, 0.0), (0.2, 10.5, 20.0), (0.5, 9.0, 50.0), (0.5, 13.0, 0.0), (0.8, 8.0, 10.0)],
)
def test_a_step_that_biases_the_first_impact_by_less_is_not_refused(e, steps, angle):
    odd = case(restitution=e, plate_angle=angle, rolling_friction=0.0)
    result = simulate(odd, setup(time_step=step_of(odd, steps, FALL), duration=0.02))
    assert result.simulated_time == pytest.approx(0.02, rel=1e-3)


def test_the_angle_and_speed_of_given_releases_are_judged():
    """Thrown along the normal of a steep plate the wear is far off, along the plate it is not."""
    odd = case(restitution=0.5, plate_angle=60.0)
    steep = setup(time_step=step_of(odd, 9.0, 5.0), gravity=0.0, duration=0.02)
    sine, cosine = math.sin(math.radians(60.0)), math.cos(math.radians(60.0))
    start = [[-0.1 * sine, 0.1 * cosine, 0.0]]
    with pytest.raises(ValueError, match="biases total of an impact at 20 deg"):
        turned = math.radians(60.0 - 20.0)
        thrown = [[5.0 * math.sin(turned), -5.0 * math.cos(turned), 0.0]]
        simulate(odd, steep, releases=([0.0], start, thrown))
    simulate(odd, steep, releases=([0.0], start, [[0.0, -5.0, 0.0]]))


@pytest.mark.parametrize(("e", "mu", "angle"), [(0.2, 0.45, 35.0), (0.5, 0.4, 10.0), (0.8, 0, 60)])
def test_the_bias_of_a_step_is_that_against_a_finer_reference(e, mu, angle):
    odd = case(restitution=e, static_friction=float(mu), rolling_friction=0.0)
    dt, contact = step_of(odd, 10.0, 4.0), SETUP.contact
    found = step_bias(odd, contact, dt, 4.0, angle)
    scene = Scene(odd.particle, odd.plate, odd.particle_radius, odd.interaction, contact)
    best = scene.impact(4.0, angle, time_step=dt / 400.0)
    coarse = [scene.impact(4.0, angle, time_step=dt, phase=phase) for phase in np.arange(64) / 64.0]
    total = np.mean([one.total for one in coarse]) / best.total - 1.0
    assert found["total"] == pytest.approx(total, abs=2e-3)
    assert set(found) == ({"total", "friction"} if mu else {"total"})
    if mu:
        work = np.mean([one.friction_work for one in coarse]) / best.friction_work - 1.0
        assert found["friction"] == pytest.approx(work, abs=2e-3)


def test_a_release_into_another_particle_or_the_plate_ends_the_case():
    still = np.zeros((2, 3))
    for places in ([[0.0, 0.3, 0.0], [0.0, 0.33, 0.0]], [[0.0, 0.3, 0.0], [0.0, 0.01, 0.0]]):
        result = simulate(CASE, SETUP, releases=([0.0, 0.01], places, still))
        assert result.status == "release into an overlap" and result.released == 1


def test_releases_faster_than_the_step_are_refused():
    velocity = [[0.0, -1e300, 0.0]]
    with pytest.raises(ValueError, match="nan steps per contact at inf m/s"):
        simulate(CASE, SETUP, releases=([0.0], [[0.0, 0.3, 0.0]], velocity))


def test_particles_too_soft_for_their_speed_end_the_case():
    soft = case(particle_shear_modulus=1e6, equipment_shear_modulus=1e6, particle_velocity_y=-30.0)
    result = simulate(soft, SETUP)
    assert result.status == "overlap above 20 % of the radius"
    assert np.isfinite(result.worn).all()


def test_more_particles_than_there_is_room_for_end_the_case(monkeypatch):
    monkeypatch.setattr(simulation, "MOST_PARTICLES", 64)
    monkeypatch.setattr(simulation, "_check_size", lambda case, problem, setup: None)
    result = simulate(case(particle_radius=0.005), SETUP)
    assert result.status == "more than 64 particles at once"


@pytest.mark.parametrize("rate", [{"mass_rate": 1e-300}, {"mass_rate": None, "number_rate": 1e-20}])
def test_a_feed_too_small_for_a_particle_releases_none(rate):
    """The step number of the first release does not fit an integer."""
    result = simulate(CASE, setup(**rate))
    assert result.status == "ok" and result.released == 0 and result.worn[-1].max() == 0.0


# Unusual but valid


def vertical_drop(**values):
    """A dilute jet without friction onto a level plate."""
    return simulate(
        case(plate_angle=0.0, static_friction=0.0, rolling_friction=0.0, **values),
        setup(mass_rate=None, number_rate=5.0, patch_length=1e-9, patch_width=1e-9),
    )


def test_without_friction_a_vertical_impact_wears_nothing():
    result = vertical_drop()
    assert result.status == "ok" and result.face_share == 1.0
    np.testing.assert_allclose(result.worn[-1], 0.0, atol=1e-12)


def test_an_elastic_case_loses_no_energy():
    """e = 1 and no friction: what came in is there or has left, to 1e-3 of the motion."""
    result = vertical_drop(restitution=1.0)
    balance = result.energy
    assert result.status == "ok"
    assert abs(balance["dissipated"]) < 1e-3 * balance["inserted"]


def test_without_friction_all_measures_are_the_distance_under_load():
    result = simulate(case(static_friction=0.0, rolling_friction=0.0), SETUP)
    total, sliding, friction = result.worn[-1]
    assert total > 0.0
    np.testing.assert_allclose([sliding, friction], total, rtol=1e-9)


def test_a_plate_on_edge_is_met_on_its_edge_alone():
    result = simulate(case(plate_angle=90.0), SETUP)
    assert result.status == "ok" and result.face_share == 0.0 and result.edge_share > 0.0
    # The same for a plate on its other edge.
    mirrored = simulate(case(plate_angle=-90.0), SETUP)
    assert mirrored.face_share == 0.0


def test_a_particle_wider_than_the_plate_bounces_as_on_a_plane():
    """Dropped on the middle of a plate smaller than itself it meets the face at one point."""
    scene = Scene()
    drop = ([0.0], [[0.0, 0.1 + 0.2, 0.0]], [[0.0, -1.0, 0.0]])
    big = dataclasses.replace(scene.case(), particle_radius=0.1, plate_angle=0.0)
    small = setup(plate_length=0.05, plate_width=0.05, facet_size=0.05)
    wide = setup(plate_length=2.0, plate_width=2.0, facet_size=1.0)
    results = [simulate(big, one, releases=drop) for one in (small, wide)]
    assert [result.status for result in results] == ["ok", "ok"]
    assert [result.face_share for result in results] == [1.0, 1.0]
    assert results[0].max_overlap == results[1].max_overlap > 0.0


LIMITS = {row.name: row.limits for row in SAMPLED}


@settings(
    max_examples=25, derandomize=True, database=None, deadline=None,
    suppress_health_check=list(HealthCheck),
)  # fmt: skip
@given(
    st.fixed_dictionaries({
        name: st.one_of(st.sampled_from(limits), st.floats(*limits))
        for name, limits in LIMITS.items() if name != "particle_radius"
    }),
    st.floats(0.005, 0.1), st.integers(0, 2**63 - 1),
    st.sampled_from(["exact_e", "nominal_clipped", "nominal_attractive"]),
)  # fmt: skip
def test_any_case_within_the_limits_ends_with_numbers_or_a_name(values, radius, seed, normal):
    contact = dataclasses.replace(SETUP.contact, normal=normal)
    try:
        odd = Case(**values, particle_radius=radius, seed=seed)
        fed = setup(contact=contact, mass_rate=None, number_rate=50.0, duration=0.3)
        result = simulate(odd, fed)
    except ValueError as refused:
        assert str(refused)
        return
    # Total and sliding only grow; friction is work less what a spring stores and gives back.
    assert np.isfinite(result.worn).all() and (np.diff(result.worn[:, :2], axis=0) >= 0.0).all()
    assert np.isfinite(result.facet_wear_all).all() and (result.facet_wear_all[:2] >= 0.0).all()
    assert result.status
    if result.status == "ok":
        assert result.max_overlap <= 0.2
        assert math.isfinite(result.energy["dissipated"])
        np.testing.assert_allclose(
            result.facet_wear_all.sum(axis=(1, 2)), result.worn[-1], rtol=1e-9, atol=1e-12
        )
