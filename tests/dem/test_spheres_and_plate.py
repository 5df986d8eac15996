"""Spheres on a plate: motions with known results, plate edges, and a reference implementation."""

import math
from fractions import Fraction

import numpy as np
import pytest
from naive import Spheres, fused, pairs_within

from abradem.dem import simulate, synchronous
from abradem.dem.model import Interaction, Setup
from abradem.dem.neighbours import rebuild_pairs
from abradem.dem.state import DONE, FLYING, SKIN, make_problem, make_state
from abradem.verification import closed_forms as exact
from abradem.verification.experiments import incline, simulated_slide_to_roll
from abradem.verification.scenes import Scene, filmed, solid

SOFT = Scene(particle=solid(1e7, 0.25, 2500.0), interaction=Interaction(0.3, 0.3, 0.0))
GRAVITY = 9.81


# Motions along a plane


def test_a_sliding_sphere_ends_rolling():
    form = exact.slide_to_roll(SOFT.mass, 1.0, 0.3, GRAVITY)
    found = simulated_slide_to_roll(SOFT, 1.0)
    assert found.velocity == pytest.approx(form.velocity, rel=1e-6)
    assert found.time == pytest.approx(form.time, rel=5e-3)
    assert found.total == pytest.approx(form.total, rel=5e-3)


def test_a_sphere_that_slides_until_it_rolls_wears_by_sliding_alone():
    form = exact.slide_to_roll(SOFT.mass, 1.0, 0.3, GRAVITY)
    setup = SOFT.plane(time_step=2e-5, duration=0.15, sample_interval=0.15)
    release = ([0.0], [(0.0, SOFT.radius * (1 + 1e-9), 0.0)], [(1.0, 0.0, 0.0)])
    worn = simulate(SOFT.case(), setup, releases=release).worn[-1]
    np.testing.assert_allclose(worn, form.total, rtol=5e-3)


@pytest.mark.parametrize(
    ("angle", "mu_r"),
    [(20.0, 0.0), (45.0, 0.0), (47.0, 0.0), (60.0, 0.0), (20.0, 0.05), (60.0, 0.05)],
)
def test_a_sphere_on_an_incline_rolls_or_slides(angle, mu_r):
    form = exact.incline_acceleration(angle, 0.3, mu_r, GRAVITY)
    assert incline(SOFT.with_interaction(rolling_friction=mu_r), angle) == pytest.approx(
        form, rel=2e-3
    )


def test_a_sphere_on_an_incline_rests_below_its_rolling_friction():
    scene = SOFT.with_interaction(rolling_friction=0.1)
    assert abs(incline(scene, 5.0)) < 1e-6
    assert incline(scene, 6.5) > 0.05


def test_a_resting_sphere_weighs_its_weight():
    setup = SOFT.plane(time_step=2e-5, duration=0.5, sample_interval=0.5)
    release = ([0.0], [(0.0, SOFT.radius * (1 + 1e-9), 0.0)], [(0, 0, 0)])
    _, film = filmed(SOFT.case(), setup, release, every=1e-3)
    assert film.of("plate_fn")[-1] == pytest.approx(SOFT.mass * GRAVITY, rel=1e-6)


# Free flight


def test_free_flight_is_the_exact_parabola_bit_for_bit():
    scene = Scene()
    start, velocity = (0.0031, 1.23, -0.017), (0.7, 3.1, -0.9)
    setup = scene.plane(duration=0.05, sample_interval=0.05)
    result, film = filmed(scene.case(), setup, ([0.0], [start], [velocity]))
    dt = result.time_step
    steps = np.arange(1, len(film.frames) + 1)
    for axis, (x0, v0, a) in enumerate(zip(start, velocity, (0.0, -GRAVITY, 0.0), strict=True)):
        places = [fused(fused(0.5 * a, time, v0), time, x0) for time in dt * steps]
        assert np.array_equal(film.of("xyz"[axis]), places)
        last = Fraction(dt) * int(steps[-1])
        true = Fraction(x0) + Fraction(v0) * last + Fraction(a) * last * last / 2
        assert film.of("xyz"[axis])[-1] == pytest.approx(float(true), rel=4e-16, abs=1e-16)
    assert result.worn[-1, 0] == 0.0


def test_flight_between_bounces_starts_again_where_the_contact_ended():
    scene = Scene(interaction=Interaction(1.0, 0.0))
    setup = scene.plane(duration=0.6, sample_interval=0.6, time_step=2e-7)
    result, film = filmed(scene.case(), setup, ([0.0], [(0.0, 0.11, 0.0)], [(0, 0, 0)]), every=1e-4)
    # No energy is lost in 0.1 m high bounces of an elastic sphere.
    height = film.of("y") - scene.radius
    energy = 0.5 * film.of("vy") ** 2 + GRAVITY * height
    flying = height > 0
    np.testing.assert_allclose(energy[flying], GRAVITY * 0.1, rtol=1e-6)
    assert abs(result.energy["dissipated"]) < 1e-6 * result.energy["inserted"]


# Edges


def test_an_edge_pushes_along_the_line_to_its_nearest_point():
    scene = Scene(interaction=Interaction(1.0, 0.0))
    # Vertical fall past the edge x = 0.15, the centre 6 mm outside of it: n = (0.6, 0.8, 0).
    setup = scene.setup(
        gravity=0.0, time_step=1e-7, duration=2e-3, sample_interval=2e-3, removal_depth=1.0
    )
    result, film = filmed(scene.case(), setup, ([0.0], [(0.156, 0.0085, 0.0)], [(0, -2.0, 0)]))
    # The normal turns a little during the impact; its mean is that of the deepest overlap.
    n = np.array([film.of("vx")[-1], film.of("vy")[-1] + 2.0])
    n /= np.linalg.norm(n)
    assert n[0] == pytest.approx(0.6, abs=0.01)
    assert result.edge_share == 1.0
    assert np.hypot(film.of("vx")[-1], film.of("vy")[-1]) == pytest.approx(2.0, rel=1e-6)


@pytest.mark.parametrize("phi", [0.0, 30.0, 70.0])
def test_face_edge_and_miss_are_told_apart(phi):
    """A sphere that falls past the lower edge by d meets the face if d < R sin(phi)."""
    scene = Scene()
    sine, cosine = math.sin(math.radians(phi)), math.cos(math.radians(phi))

    def first_contact(past):
        start = (-0.15 * cosine - past * scene.radius, 0.1, 0.0)
        result = simulate(
            scene.case(plate_angle=phi),
            scene.setup(duration=0.4, sample_interval=0.4, time_step=2e-6),
            releases=([0.0], [start], [(0, -1.0, 0)]),
        )
        return result.face_share, result.edge_share, result.missed_share

    assert first_contact(sine - 0.05) == (1.0, 0.0, 0.0)
    assert first_contact(0.5 * (1.0 + sine)) == (0.0, 1.0, 0.0)
    assert first_contact(1.05) == (0.0, 0.0, 1.0)


def test_a_tilted_plate_is_a_tilted_world():
    """Rotating plate and velocities about z rotates the outcome (no gravity)."""
    scene = Scene()
    outcomes = []
    for phi in (0.0, 35.0):
        c, s = math.cos(math.radians(phi)), math.sin(math.radians(phi))

        def turned(x, y, c=c, s=s):
            return (c * x - s * y, s * x + c * y, 0.0)

        setup = scene.setup(gravity=0.0, time_step=2e-7, duration=4e-4, sample_interval=4e-4)
        release = ([0.0], [turned(0.0, 0.01010013)], [turned(1.0, -2.0)])
        result, film = filmed(scene.case(plate_angle=phi), setup, release)
        vx, vy = film.of("vx")[-1], film.of("vy")[-1]
        outcomes.append((c * vx + s * vy, c * vy - s * vx, film.of("wz")[-1], *result.worn[-1]))
    np.testing.assert_allclose(outcomes[1], outcomes[0], rtol=1e-8)


# Reference implementations


def test_the_pair_list_holds_the_pairs_of_all_with_all():
    rng = np.random.default_rng(5)
    scene = Scene()
    problem, _ = make_problem(scene.case(), scene.plane())
    for count, box in ((2, 0.03), (60, 0.1), (300, 0.16), (300, 2.0)):
        state = make_state(problem, count)
        positions = rng.uniform(-box, box, (count, 3))
        # As many as the list can hold: equal spheres overlap little.
        kept = []
        for position in positions:
            if all(math.dist(position, other) > 1.8 * scene.radius for other in kept):
                kept.append(position)
        particles = state.particles[: len(kept)]
        for axis, name in enumerate("xyz"):
            particles[name] = np.array(kept)[:, axis]
        particles["motion"] = FLYING
        state.tally["live"] = len(kept)
        assert rebuild_pairs(problem, state)
        listed = state.pairs[: int(state.tally["pairs"][0])]
        found = {(int(p["i"]), int(p["j"])) for p in listed}
        assert len(found) == listed.size
        assert found == pairs_within(kept, (2.0 + SKIN) * scene.radius)


@pytest.mark.parametrize("far", [1e3, 1e300, math.inf, math.nan])
def test_a_particle_far_away_or_nowhere_hides_no_pair(far):
    rng = np.random.default_rng(3)
    scene = Scene()
    problem, _ = make_problem(scene.case(), scene.plane())
    positions = rng.uniform(-0.04, 0.04, (40, 3))
    positions[7] = far, 0.0, -far
    state = make_state(problem, 40)
    for axis, name in enumerate("xyz"):
        state.particles[name] = positions[:, axis]
    state.particles["motion"] = FLYING
    state.tally["live"] = 40
    assert rebuild_pairs(problem, state)
    listed = state.pairs[: int(state.tally["pairs"][0])]
    found = {(int(p["i"]), int(p["j"])) for p in listed}
    with np.errstate(invalid="ignore", over="ignore"):
        assert found == pairs_within(positions, (2.0 + SKIN) * scene.radius)
    assert len(found) > 40


def test_an_old_pair_list_misses_no_contact():
    """Rebuilding the list in every step gives the same bits as rebuilding it after enough drift."""
    scene = Scene(interaction=Interaction(0.5, 0.45, 0.05))
    case = scene.case(plate_angle=4.0, particle_velocity_y=-5.0)
    setup = Setup(number_rate=4000.0, mass_rate=None, fall_height=0.1)
    problem, schedule = make_problem(case, setup)
    states = [make_state(problem, 1024) for _ in range(2)]
    made = 0
    for step in range(1, 10_000):
        before = float(states[0].tally["drift"][0])
        assert synchronous.advance(problem, schedule, states[0], step) == DONE
        made += float(states[0].tally["drift"][0]) < before
        states[1].tally["drift"] = math.inf
        assert synchronous.advance(problem, schedule, states[1], step) == DONE
    assert 10 < made < 1000
    for name in ("particles", "facet_wear"):
        np.testing.assert_array_equal(getattr(states[0], name), getattr(states[1], name))
    assert states[0].tally["worn_total"] > 0.0
    open_pairs = [s.pairs[: int(s.tally["pairs"][0])] for s in states]
    assert np.count_nonzero(open_pairs[0]["stiffness"]) > 0


@pytest.mark.parametrize("seed", range(6))
def test_a_crowd_moves_as_its_naive_twin(seed):
    """Twelve particles thrown together above a small tilted plate, edges included."""
    rng = np.random.default_rng(seed)
    scene = Scene(interaction=Interaction(0.5, 0.45, 0.05))
    case = scene.case(plate_angle=20.0)
    setup = scene.setup(plate_length=0.06, plate_width=0.05, gravity=9.81)
    dt = 0.2 * 2.9e-5
    positions = []
    while len(positions) < 12:
        place = rng.uniform([-0.05, 0.02, -0.04], [0.05, 0.1, 0.04])
        if all(math.dist(place, other) > 0.0201 for other in positions):
            positions.append(place)
    velocities = np.array([0.0, -2.0, 0.0]) - 30.0 * np.array(positions) * [1, 0, 1]
    spins = rng.normal(0.0, 50.0, (12, 3))
    setup = scene.setup(plate_length=0.06, plate_width=0.05, time_step=dt)
    problem, schedule = make_problem(case, setup, ([0.0] * 12, positions, velocities, spins))
    state = make_state(problem, 16)
    twin = Spheres(problem, positions, velocities, spins)
    steps = 2000
    for _ in range(steps):
        twin.step()
    assert synchronous.advance(problem, schedule, state, steps) == DONE
    particles = np.sort(state.particles[:12], order="identity")
    met = np.linalg.norm(twin.v - velocities, axis=1).max()
    assert met > 1.0
    places = np.column_stack([particles[k] for k in "xyz"])
    turns = np.column_stack([particles[f"w{k}"] for k in "xyz"])
    np.testing.assert_allclose(places, twin.x, rtol=0, atol=1e-7)
    np.testing.assert_allclose(turns, twin.w, rtol=0, atol=1e-2)
    worn = [float(state.tally[f"worn_{r}"][0]) for r in ("total", "sliding", "friction")]
    np.testing.assert_allclose(worn, twin.worn, rtol=1e-4)
