"""A jet on a plate: feed, removal, balances, limits, and reproducibility."""

import math
from dataclasses import replace

import numpy as np
import pytest

from abradem.dem import samples, simulate, synchronous
from abradem.dem.counter_random import uniform
from abradem.dem.energy import energy_balance, energy_present
from abradem.dem.model import Interaction
from abradem.dem.samples import make_record
from abradem.dem.simulation import FIRST_CAPACITY
from abradem.dem.state import (
    DONE,
    GONE,
    STOP_ENERGY_GAIN,
    STOP_NOT_FINITE,
    grown,
    make_problem,
    make_state,
)
from abradem.verification.scenes import Scene, solid

JET = Scene(
    particle=solid(5e9, 0.25, 2500.0),
    radius=0.02,
    interaction=Interaction(0.5, 0.45, 0.05),
)
CASE = JET.case(plate_angle=30.0, particle_velocity_y=-3.0, seed=11)
SHORT = JET.setup(duration=1.0, sample_interval=0.1, mass_rate=4.0)


class Witness:
    """Recorder that reads the state without storing it."""

    def __init__(self, look, interval):
        self.look, self.interval = look, interval

    def record(self, time, problem, state):
        self.look(time, problem, state)


@pytest.fixture(scope="module")
def jet():
    return simulate(CASE, SHORT)


# Feed


def test_a_mass_rate_is_delivered_to_within_one_particle(jet):
    poured = 4.0 * jet.simulated_time
    assert jet.delivered_mass[-1] == pytest.approx(poured, abs=1.01 * JET.mass)
    assert jet.delivered_rate == pytest.approx(jet.requested_rate, rel=0.03)


@pytest.mark.parametrize(
    ("acts", "radius", "height", "width"),
    [("tilt", 0.0, 0.25, 0.5), ("level", 0.0, 0.25, 1.0), ("arc", 0.2, 0.15, 1.0)],
)
def test_the_factory_angle_acts_as_chosen(acts, radius, height, width):
    """At 60 degrees: half as wide, nothing, or lower by half of the radius of the arc."""
    setup = replace(SHORT, angle_acts=acts, arc_radius=radius, fall_height=0.25)
    case = replace(CASE, factory_angle=-60.0, particle_radius=0.005)
    problem, schedule = make_problem(case, replace(setup, duration=0.2))
    state = make_state(problem, 4096)
    assert synchronous.advance(problem, schedule, state, round(0.03 / problem.dt)) == DONE
    live = state.particles[: state.tally["live"][0]]
    assert len(live) > 20
    x, y = live["anchor_x"], live["anchor_y"]
    assert np.abs(x).max() <= 0.5 * setup.patch_length * width
    assert np.abs(x).max() > 0.4 * setup.patch_length * width
    if acts == "tilt":
        np.testing.assert_allclose(y - height, x * math.tan(math.radians(-60.0)), atol=1e-12)
    else:
        np.testing.assert_allclose(y, height, atol=1e-12)


def test_a_level_factory_is_one_at_an_angle_of_zero():
    level = replace(SHORT, angle_acts="level", duration=0.3)
    turned = simulate(replace(CASE, factory_angle=-50.0), level)
    straight = simulate(replace(CASE, factory_angle=0.0), replace(SHORT, duration=0.3))
    np.testing.assert_array_equal(turned.worn, straight.worn)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"angle_acts": "swing"}, "angle_acts = 'swing' is unknown; allowed: tilt, level, arc"),
        ({"angle_acts": "arc", "arc_radius": 0.25}, "must be less than fall_height"),
        ({"angle_acts": "arc", "arc_radius": -0.1}, "arc_radius = -0.1"),
        ({"unplaced": "lose"}, "unplaced = 'lose' is unknown; allowed: wait, skip"),
        ({"attempts": 0}, "attempts = 0 must be a whole number from 1 to 10000"),
        ({"attempts": 2.5}, "attempts = 2.5 must be a whole number from 1 to 10000"),
    ],
)
def test_a_factory_that_cannot_be_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        replace(SHORT, **change)


def releases_one_by_one(problem, last):
    """Place and step of each particle released before a step, and the number left out.

    A slow, obvious twin of the factory for particles that only fall: all have the same velocity
    at the release, so they never meet.
    """
    found, left_out, draws, step = [], 0, 0, 0

    def due(number):
        return math.ceil((number + 0.5) / (problem.rate * problem.dt))

    def is_free(x, z):
        for other_x, other_z, since in found:
            time = problem.dt * (step - since)
            fallen = -problem.release_velocity[1] * time + 0.5 * problem.gravity * time**2
            if (x - other_x) ** 2 + (z - other_z) ** 2 + fallen**2 < 4.0 * problem.radius**2:
                return False
        return True

    while step < last:
        later = None
        while later is None and due(len(found) + left_out) <= step:
            number = len(found) + left_out
            for _ in range(problem.attempts):
                x = problem.patch_half_length * (2.0 * uniform(problem.seed, number, draws) - 1.0)
                z = problem.patch_half_width * (2.0 * uniform(problem.seed, number, draws + 1) - 1)
                draws += 2
                if is_free(x, z):
                    found.append((x, z, step))
                    draws = 0
                    break
            else:
                if problem.skips:
                    left_out, draws = left_out + 1, 0
                else:
                    later = step + problem.retry_steps
        step = later or due(len(found) + left_out)
    return np.array(found), left_out


CROWDED = replace(SHORT, mass_rate=None, number_rate=600.0, fall_height=1.0)


@pytest.mark.parametrize("attempts", [1, 3, 100])
@pytest.mark.parametrize("unplaced", ["wait", "skip"])
def test_a_crowded_factory_places_what_one_by_one_finds_room(unplaced, attempts):
    setup = replace(CROWDED, attempts=attempts, unplaced=unplaced)
    problem, schedule = make_problem(replace(CASE, particle_velocity_y=-0.5), setup)
    state = make_state(problem, 256)
    last = round(0.25 / problem.dt)
    assert synchronous.advance(problem, schedule, state, last) == DONE
    live = state.particles[: state.tally["live"][0]]
    found, left_out = releases_one_by_one(problem, last)
    assert state.tally["skipped"][0] == left_out
    assert (left_out > 0) == (unplaced == "skip")
    assert 10 < len(found) < 0.25 * CROWDED.number_rate
    np.testing.assert_array_equal(live["anchor_step"], found[:, 2])
    np.testing.assert_allclose(live["anchor_x"], found[:, 0], atol=1e-15)
    np.testing.assert_allclose(live["anchor_z"], found[:, 1], atol=1e-15)


def test_a_feed_that_is_not_made_up_for_is_lost_more_by_slow_particles():
    """With a single attempt the chance of room is the share of the patch that is free."""
    setup = replace(CROWDED, attempts=1, unplaced="skip", fall_height=0.3, duration=0.5)
    shares = []
    for speed in (0.5, 2.0, 8.0):
        result = simulate(replace(CASE, particle_velocity_y=-speed), setup)
        shares.append(result.delivered_rate / result.requested_rate)
        assert result.status == "ok"
    assert shares[0] < 0.7 * shares[1] < 0.7 * 0.9 * shares[2]
    waited = simulate(
        replace(CASE, particle_velocity_y=-8.0), replace(setup, unplaced="wait", attempts=100)
    )
    assert waited.delivered_rate > 1.02 * shares[2] * waited.requested_rate


def test_both_steppings_leave_out_the_same_particles():
    setup = replace(CROWDED, attempts=2, unplaced="skip", fall_height=0.25, duration=0.3)
    case = replace(CASE, particle_velocity_y=-1.0)
    islands, synchronous_ = (
        simulate(case, replace(setup, stepping=name)) for name in ("islands", "synchronous")
    )
    np.testing.assert_array_equal(islands.worn, synchronous_.worn)
    np.testing.assert_array_equal(islands.facet_wear_all, synchronous_.facet_wear_all)
    assert islands.released == synchronous_.released < 0.9 * 0.3 * CROWDED.number_rate


def test_a_number_rate_is_delivered_to_within_one_particle():
    for radius in (0.01, 0.03):
        case = replace(CASE, particle_radius=radius)
        setup = replace(SHORT, mass_rate=None, number_rate=40.0, duration=0.5)
        result = simulate(case, setup)
        assert result.released == pytest.approx(40.0 * result.simulated_time, abs=1.01)


def test_particles_at_rest_on_a_vertical_patch_find_room_for_less_than_half():
    heavy = Scene(particle=solid(15e9, 0.25, 4000.0), radius=0.005)
    case = heavy.case(factory_angle=-90.0, plate_angle=60.0, seed=1)
    result = simulate(case, JET.setup(duration=0.3, sample_interval=0.1, time_step_fraction=0.4))
    assert result.status == "ok"
    assert 0.25 < result.delivered_rate / result.requested_rate < 0.5


def test_released_particles_start_on_the_patch_without_overlap():
    case = replace(CASE, factory_angle=-40.0)
    starts = {}

    def look(_, problem, state):
        particles = state.particles[: int(state.tally["live"][0])]
        for p in particles[particles["motion"] != GONE]:
            starts.setdefault(int(p["identity"]), (p["anchor_x"], p["anchor_y"], p["anchor_z"]))

    simulate(case, replace(SHORT, duration=0.5), recorder=Witness(look, 5e-3))
    x, y, z = np.array(list(starts.values())).T
    angle = math.radians(-40.0)
    along = x * math.cos(angle) + (y - 0.25) * math.sin(angle)
    across = -x * math.sin(angle) + (y - 0.25) * math.cos(angle)
    np.testing.assert_allclose(across, 0.0, atol=1e-15)
    assert np.abs(along).max() <= 0.05 and np.abs(z).max() <= 0.05
    assert np.abs(along).max() > 0.04 and np.abs(z).max() > 0.04


def test_given_releases_replay_the_factory_bit_for_bit():
    case = replace(CASE, plate_angle=50.0)
    setup = replace(SHORT, duration=0.3, time_step_fraction=0.4)
    dt = make_problem(case, setup)[0].dt
    times, places = {}, {}

    def look(_, problem, state):
        for p in state.particles[: int(state.tally["live"][0])]:
            key = int(p["identity"])
            if key not in times:
                times[key] = float(p["anchor_step"]) * problem.dt
                places[key] = [float(p[f"anchor_{k}"]) for k in "xyz"]

    poured = simulate(case, setup, recorder=Witness(look, dt))
    order = sorted(times)
    given = simulate(
        case,
        setup,
        releases=(
            [times[k] for k in order],
            [places[k] for k in order],
            [(0.0, case.particle_velocity_y, 0.0)] * len(order),
        ),
    )
    assert given.released == poured.released > 10
    assert np.array_equal(given.worn, poured.worn)


@pytest.mark.parametrize(
    ("releases", "words"),
    [
        (([0.0], [(0, 1)], [(0, 0, 0)]), "releases must be"),
        (([0.1, 0.0], [(0, 1, 0)] * 2, [(0, 0, 0)] * 2), "ascend"),
        (([0.0], [(0, math.nan, 0)], [(0, 0, 0)]), "finite"),
    ],
)
def test_malformed_releases_are_refused(releases, words):
    with pytest.raises(ValueError, match=words):
        simulate(CASE, SHORT, releases=releases)


def test_a_release_into_an_overlap_ends_the_case_with_its_reason():
    releases = ([0.0, 0.0], [(0, 0.2, 0), (0.01, 0.2, 0)], [(0, 0, 0)] * 2)
    assert simulate(CASE, SHORT, releases=releases).status == "release into an overlap"


# Balances


def test_what_was_released_is_removed_or_there(jet):
    there = []

    def look(_, problem, state):
        live = state.particles[: int(state.tally["live"][0])]
        there.append(
            (int(state.tally["placed"][0]), int(state.tally["removed"][0]),
             int((live["motion"] != GONE).sum()))
        )  # fmt: skip

    result = simulate(CASE, SHORT, recorder=Witness(look, 0.1))
    assert all(placed == removed + resident for placed, removed, resident in there)
    assert result.released == there[-1][0] and result.removed == there[-1][1] > 0
    shares = result.face_share, result.edge_share, result.missed_share
    assert sum(shares) == pytest.approx(1.0)
    assert np.array_equal(result.worn, jet.worn)


@pytest.mark.parametrize("phi", [0.0, 30.0])
def test_mechanical_energy_is_never_gained(phi):
    lost = []

    def look(_, problem, state):
        lost.append(energy_balance(problem, state)["dissipated"])

    simulate(replace(CASE, plate_angle=phi), SHORT, recorder=Witness(look, 1e-3))
    steps = np.diff(lost)
    assert lost[-1] > 0.0
    assert steps.min() > -1e-4 * lost[-1]


def test_without_friction_and_damping_nothing_is_lost():
    scene = Scene(JET.particle, radius=0.02, interaction=Interaction(1.0, 0.0, 0.0))
    case = scene.case(plate_angle=30.0, particle_velocity_y=-3.0)
    result = simulate(case, scene.setup(duration=0.5, sample_interval=0.1, time_step_fraction=0.02))
    assert result.status == "ok"
    assert abs(result.energy["dissipated"]) < 5e-3 * result.energy["inserted"]
    # Everything slides and friction does no work: all wear measures are the same distance.
    assert result.worn[-1, 0] > 0.0
    assert result.worn[-1, 1] == result.worn[-1, 2] == result.worn[-1, 0]


# Facets


def test_a_coarse_facet_is_the_sum_of_its_fine_ones(jet):
    coarse = simulate(CASE, replace(SHORT, facet_size=0.05))
    fine = jet.facet_wear_all.reshape(3, 6, 5, 6, 5).sum(axis=(2, 4))
    np.testing.assert_allclose(fine, coarse.facet_wear_all, rtol=1e-12, atol=1e-15)
    assert np.array_equal(coarse.worn, jet.worn)


def test_the_facets_add_up_to_the_plate(jet):
    np.testing.assert_allclose(jet.facet_wear_all.sum(axis=(1, 2)), jet.worn[-1], rtol=1e-12)
    assert jet.facet_wear_all[0].min() >= 0.0


def test_measures_are_ordered(jet):
    total, sliding, friction = jet.worn[-1]
    assert total > friction > 0.0
    assert total > sliding > 0.0


# Results depend only on the case


def test_the_same_case_gives_the_same_bits(jet):
    again = simulate(CASE, SHORT)
    assert np.array_equal(again.worn, jet.worn)
    assert np.array_equal(again.facet_wear_all, jet.facet_wear_all)


def test_another_seed_gives_another_jet(jet):
    assert simulate(replace(CASE, seed=12), SHORT).worn[-1, 0] != jet.worn[-1, 0]


def test_wear_does_not_depend_on_the_sample_interval(jet):
    dt = jet.time_step
    setup = replace(SHORT, time_step=dt)
    long, short = (
        simulate(CASE, replace(setup, sample_interval=steps * dt, duration=30000 * dt))
        for steps in (3000, 500)
    )
    assert np.array_equal(long.worn, short.worn[::6])


def test_advancing_in_pieces_gives_the_same_bits_as_at_once():
    problem, schedule = make_problem(CASE, SHORT)
    once, pieces = (make_state(problem, 256) for _ in range(2))
    assert synchronous.advance(problem, schedule, once, 9000) == DONE
    rng = np.random.default_rng(3)
    step = 0
    while step < 9000:
        step = min(step + int(rng.integers(1, 700)), 9000)
        assert synchronous.advance(problem, schedule, pieces, step) == DONE
        if rng.random() < 0.2:
            pieces = grown(pieces, pieces.particles.size + 3)
    live = int(once.tally["live"][0])
    assert np.array_equal(once.tally, pieces.tally)
    assert np.array_equal(once.particles[:live], pieces.particles[:live])
    assert np.array_equal(once.facet_wear, pieces.facet_wear)


def test_random_places_are_a_function_of_their_keys():
    draws = np.array([[uniform(s, p, 0) for p in range(400)] for s in (1, 2**62)])
    again = np.array([[uniform(s, p, 0) for p in reversed(range(400))] for s in (1, 2**62)])
    assert np.array_equal(draws, again[:, ::-1])
    assert draws.min() >= 0.0 and draws.max() < 1.0
    assert draws.mean() == pytest.approx(0.5, abs=0.04)
    assert draws.var() == pytest.approx(1 / 12, rel=0.1)
    assert abs(np.corrcoef(draws)[0, 1]) < 0.15
    assert abs(np.corrcoef(draws[0, 1:], draws[0, :-1])[0, 1]) < 0.15


# Guards


def test_a_step_that_jumps_through_contacts_is_refused():
    dt = 3.0 * JET.particle.rayleigh_time(JET.radius)
    with pytest.raises(ValueError, match="steps per contact"):
        simulate(CASE, replace(SHORT, time_step=dt))


def test_too_soft_particles_end_the_case_with_its_reason():
    jelly = Scene(particle=solid(2e5, 0.25, 2500.0), radius=0.02)
    case = jelly.case(particle_velocity_y=-5.0, plate_angle=10.0)
    result = simulate(case, replace(SHORT, time_step_fraction=0.02))
    assert result.status == "overlap above 20 % of the radius"
    assert result.max_overlap > 0.2


def test_a_gain_of_energy_ends_the_case_with_its_reason():
    def push(time, problem, state):
        if time > 0.3:
            state.particles["wz"][:] += 200.0

    result = simulate(CASE, SHORT, recorder=Witness(push, 0.25))
    assert result.status.startswith("energy gain of")


def moving_energy(problem, state):
    return energy_present(problem, state)[1]


def status_after_a_gain(case, setup, at, gain, releases=None):
    """Status of a simulation in which the particles get ``gain`` (J) of spin at one time.

    ``gain`` may be a function of the energy that moves at that time.
    """
    done = []

    def push(time, problem, state):
        live = int(state.tally["live"][0])
        if time >= at and not done and live:
            done.append(time)
            energy = gain(moving_energy(problem, state)) if callable(gain) else gain
            particles = state.particles[:live]
            present = particles["motion"] != GONE
            spin2 = particles["wz"] ** 2 + 2.0 * energy / (problem.inertia * present.sum())
            particles["wz"][present] = np.sqrt(spin2[present])

    result = simulate(case, setup, releases=releases, recorder=Witness(push, 0.1))
    assert done
    return result.status


QUICKLY = 1e-4
"""Between two samples, s, the jet loses less than what the tests add."""


@pytest.mark.parametrize("at", [0.4, 2.9])
@pytest.mark.parametrize(("share", "ends"), [(0.01, False), (0.05, True), (0.5, True)])
def test_a_gain_is_compared_with_what_moves_at_any_time(at, share, ends):
    """What was put in until then, here up to ten times what moves, makes the guard no weaker."""
    setup = replace(SHORT, duration=3.1, sample_interval=QUICKLY)
    status = status_after_a_gain(CASE, setup, at, lambda moving: share * moving)
    assert status.startswith("energy gain of") is ends
    assert status == "ok" or "of the energy that moved" in status


@pytest.mark.parametrize("depth", [0.05, 5.0])
def test_the_guard_does_not_depend_on_the_level_of_heights(depth):
    setup = replace(SHORT, duration=0.8, removal_depth=depth, sample_interval=QUICKLY)
    for share, ends in ((0.01, False), (0.06, True)):
        status = status_after_a_gain(CASE, setup, 0.5, lambda moving, s=share: s * moving)
        assert status.startswith("energy gain of") is ends


AT_REST = ([0.0, 0.0], [[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]], np.zeros((2, 3)))


@pytest.mark.parametrize(("gain", "ends"), [(1e-18, False), (1e-15, False), (1e-9, True)])
def test_where_nothing_was_put_in_rounding_is_no_gain_and_the_rest_is(gain, ends):
    setup = JET.empty_space(duration=0.6, sample_interval=0.1)
    status = status_after_a_gain(JET.case(), setup, 0.2, gain, AT_REST)
    assert status.startswith("energy gain of") is ends


@pytest.mark.parametrize(("gain", "ends"), [(1e-18, False), (0.0, False), (1e-6, True)])
def test_particles_at_rest_on_the_plate_gain_nothing_by_rounding(gain, ends):
    """Released on the plate: nothing moves but the contact that settles."""
    plane = JET.plane(duration=0.8, sample_interval=0.1)
    places = [[0.0, JET.radius, 0.0], [1.0, JET.radius, 0.0]]
    status = status_after_a_gain(JET.case(), plane, 0.6, gain, ([0, 0], places, np.zeros((2, 3))))
    assert status.startswith("energy gain of") is ends


def test_particles_without_energy_by_the_level_of_heights_fall_undisturbed():
    """At the removal level and at rest they count as no energy; they fall and are removed."""
    setup = JET.setup(duration=0.6, sample_interval=0.01, plate_length=0.1, removal_depth=0.1)
    problem, _ = make_problem(JET.case(), setup)
    places = [[x, problem.removal_height + lift, 0.0]
              for x, lift in ((0.5, 0.0), (0.6, 1e-16), (0.7, 1e-9), (0.8, 0.02))]  # fmt: skip
    result = simulate(JET.case(), setup, releases=(np.zeros(4), places, np.zeros((4, 3))))
    assert result.status == "ok" and result.removed == 4


def test_no_ordinary_case_comes_near_the_guard():
    """Gains of energy are rounding: the guard has ten orders of magnitude to spare."""
    shares = []
    for angle, velocity, radius in ((0.0, -3.0, 0.02), (45.0, -8.0, 0.01), (70.0, 0.0, 0.03)):
        case = replace(CASE, plate_angle=angle, particle_velocity_y=velocity,
                       particle_radius=radius)  # fmt: skip
        seen = [0.0]

        def look(time, problem, state, seen=seen, shares=shares):
            seen.append(energy_balance(problem, state)["dissipated"])
            if moving := moving_energy(problem, state):
                shares.append((seen[-2] - seen[-1]) / moving)

        simulate(case, replace(SHORT, duration=1.5), recorder=Witness(look, 0.05))
    assert max(shares) < 1e-12


def test_a_position_that_is_no_number_ends_the_case_with_its_reason():
    def spoil(time, problem, state):
        if time > 0.3:
            state.particles["anchor_y"][:] = math.nan
            state.particles["y"][:] = math.nan

    result = simulate(CASE, SHORT, recorder=Witness(spoil, 0.25))
    assert result.status == "a position is not a finite number"


def test_the_parts_of_the_window_are_consecutive_and_equal():
    setup = JET.setup(window=2.0, max_time=20.0, target_stderr=0.5)
    result = simulate(CASE, setup)
    assert result.facet_wear_parts.shape == (10, *result.facet_wear.shape)
    np.testing.assert_allclose(
        result.facet_wear_parts.sum(axis=0), result.facet_wear, rtol=1e-12, atol=1e-15
    )
    # The series tells the wear of the plate at the ends of the parts.
    ends = np.linspace(*result.window, 11)
    for index in range(3):
        worn = np.interp(ends, result.time, result.worn[:, index])
        np.testing.assert_allclose(
            result.facet_wear_parts[:, index].sum(axis=(1, 2)), np.diff(worn), rtol=1e-9, atol=1e-12
        )
    ended = simulate(CASE, replace(setup, max_time=2.1))
    assert np.isnan(ended.facet_wear).all() and len(ended.facet_wear_parts) == 0


@pytest.mark.parametrize("stepping", ["islands", "synchronous"])
def test_many_samples_in_one_call_are_those_taken_one_by_one(stepping):
    """Also where the stop rule ends the case, where room is made, where the steps end it."""
    setup = JET.setup(window=1.0, max_time=6.0, target_stderr=0.1, sample_interval=0.07)
    jelly = Scene(particle=solid(2e5, 0.25, 2500.0), radius=0.02)
    cases = [
        (replace(CASE, plate_angle=50.0, particle_radius=0.02), setup),
        (
            replace(CASE, particle_radius=0.005),
            replace(SHORT, duration=0.2, sample_interval=0.03),
        ),
        (
            jelly.case(particle_velocity_y=-5.0, plate_angle=10.0),
            replace(SHORT, time_step_fraction=0.02, sample_interval=0.01),
        ),
    ]
    ends = []
    for case, each in cases:
        times = []
        each = replace(each, stepping=stepping)
        together = simulate(case, each)
        alone = simulate(case, each, progress=times.append)
        assert times == together.time[1:].tolist()
        assert together.facet_wear_all.sum() > 0.0
        ends.append((together.simulated_time, together.released))
        for name in (
            "time", "worn", "delivered_mass", "present", "facet_wear", "facet_wear_parts",
            "facet_wear_all",
        ):  # fmt: skip
            np.testing.assert_array_equal(getattr(together, name), getattr(alone, name))
        assert together.energy == alone.energy and together.status == alone.status
    assert ends[0][0] < 6.0 and ends[1][1] > 2 * FIRST_CAPACITY
    assert together.status == "overlap above 20 % of the radius"


def test_a_guard_ends_a_call_at_its_sample():
    """Particles that become nan between samples, within one call for many steps."""
    problem, schedule = make_problem(CASE, SHORT)
    state, record = make_state(problem, 256), make_record(50)
    take = samples.take_samples
    assert take(problem, schedule, state, None, 500, 0, 20, record) == (20, DONE)
    state.particles["anchor_y"][: state.tally["live"][0]] = math.nan
    assert take(problem, schedule, state, None, 500, 20, 50, record) == (20, STOP_NOT_FINITE)
    assert record.worn[21:].max() == record.placed[21:].max() == 0
    assert np.all(np.diff(record.placed[:21]) >= 0) and record.placed[20] > 0


def test_a_gain_of_energy_ends_a_call_at_its_sample():
    problem, schedule = make_problem(CASE, SHORT)
    state, record = make_state(problem, 256), make_record(50)
    take = samples.take_samples
    assert take(problem, schedule, state, None, 500, 0, 20, record) == (20, DONE)
    state.particles["wz"][: state.tally["live"][0]] += 1000.0
    assert take(problem, schedule, state, None, 500, 20, 50, record) == (20, STOP_ENERGY_GAIN)
    assert record.balance["gained"][0] > 0.02


# The stop rule


def test_particles_present_are_those_released_and_not_removed(jet):
    assert jet.present[0] == 0 and jet.present[-1] == jet.released - jet.removed
    assert jet.removed > 0 and jet.present.max() < jet.released
    other = simulate(CASE, replace(SHORT, stepping="synchronous"))
    np.testing.assert_array_equal(jet.present, other.present)


def test_a_case_whose_particles_still_change_goes_on():
    """Large particles on a level plate that they do not leave: their number only grows."""
    setup = JET.setup(
        window=1.0, max_time=4.0, target_stderr=0.5, plate_length=3.0, plate_width=3.0
    )
    filling = simulate(replace(CASE, plate_angle=0.0), setup)
    assert filling.present[-1] > 0.5 * filling.released
    assert not filling.settled and filling.simulated_time == pytest.approx(4.0, rel=0.01)
    # It still has a rate and a window, which the flag marks as unreliable.
    assert math.isfinite(filling.steady_from) and np.isfinite(filling.facet_wear).all()
    leaving = simulate(replace(CASE, plate_angle=60.0), setup)
    assert leaving.settled and leaving.simulated_time < 3.0


def test_a_case_runs_until_its_error_is_small_enough():
    setup = JET.setup(window=2.0, max_time=20.0, target_stderr=0.05)
    case = replace(CASE, plate_angle=60.0)
    result = simulate(case, setup)
    assert result.status == "ok" and result.settled
    assert result.stderr <= 0.05
    assert result.window[1] - result.window[0] == pytest.approx(2.0, rel=0.01)
    assert result.simulated_time < 20.0
    wanting = simulate(case, replace(setup, target_stderr=1e-6, max_time=4.0))
    assert wanting.simulated_time == pytest.approx(4.0, rel=0.01) and wanting.stderr > 1e-6
