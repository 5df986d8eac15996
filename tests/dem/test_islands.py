"""Stepping by islands gives bit-identical results to conventional stepping."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abradem.dem import islands, simulate, synchronous
from abradem.dem.agenda import FEW, NEVER, grown_agenda, make_agenda
from abradem.dem.bounds import (
    due_step,
    first_time_within,
    time_to_meet,
    time_to_plate,
    time_to_reach,
)
from abradem.dem.cells import (
    distance_to_leave,
    enter_cell,
    leave_cell,
    list_neighbours,
    time_to_leave,
)
from abradem.dem.model import Case, ContactModel, Interaction, Setup
from abradem.dem.state import DONE, FLYING, GONE, grown, make_problem, make_state

CASE = Case(6e9, 0.25, 3000, 8e10, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 30.0, -30.0, 0.01, -5.0, 3)
SMALL = Setup(plate_length=0.08, plate_width=0.06, removal_depth=0.05)


def particles_of(state):
    """Identity, position, velocity, spin and kind of motion of all particles, by identity."""
    live = state.particles[: int(state.tally["live"][0])]
    present = np.sort(live[live["motion"] != GONE], order="identity")
    names = ["identity", "motion", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
    return present[[*names, "plate_fn", "plate_sx", "plate_sz", "first_contact"]]


def assert_same(one, other):
    for name in one.tally.dtype.names:
        if name not in ("pairs", "drift", "gone", "live"):
            assert one.tally[name][0] == other.tally[name][0], name
    np.testing.assert_array_equal(one.facet_wear, other.facet_wear)
    np.testing.assert_array_equal(particles_of(one), particles_of(other))


def run_both(case, setup, steps, releases=None, pieces=1, capacity=1024):
    """Advance both steppings in pieces, comparing after each; return the state by islands."""
    problem, schedule = make_problem(case, setup, releases)
    slow, fast = make_state(problem, capacity), make_state(problem, capacity)
    agenda = make_agenda(problem, capacity)
    for piece in range(1, pieces + 1):
        until = steps * piece // pieces
        outcome = synchronous.advance(problem, schedule, slow, until)
        assert islands.advance(problem, schedule, fast, agenda, until) == outcome
        assert_same(slow, fast)
        if outcome != DONE:
            break
    return fast, agenda


def apart(places, radius):
    """Keep the positions that overlap no previous one."""
    kept = []
    for place in places:
        if all(math.dist(place, other) > 2.0 * radius * (1 + 1e-12) for other in kept):
            kept.append(place)
    return np.array(kept)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(2, 30),
    angle=st.sampled_from([0.0, 10.0, 45.0, 70.0, 90.0, -30.0]),
    speed=st.sampled_from([0.0, 0.5, 4.0, 12.0]),
    restitution=st.sampled_from([0.2, 0.5, 0.95, 1.0]),
    friction=st.sampled_from([0.0, 0.3, 0.55]),
)
def test_small_scenes_are_the_same_bits(seed, count, angle, speed, restitution, friction):
    """Random places, speeds and spins around a small plate with its edges and corners."""
    rng = np.random.default_rng(seed)
    spread = np.array([0.08, 0.06, 0.06])
    places = apart(rng.uniform(-1, 1, (count, 3)) * spread + [0, 0.1, 0], CASE.particle_radius)
    count = len(places)
    velocities = rng.normal(0.0, 1.0, (count, 3)) * speed - 3.0 * places * speed
    spins = rng.normal(0.0, 100.0, (count, 3))
    times = np.sort(rng.choice([0.0, 0.0, 0.003], count))
    case = dataclasses.replace(
        CASE, plate_angle=angle, restitution=restitution, static_friction=friction
    )
    run_both(case, SMALL, 6000, (times, places, velocities, spins), pieces=3, capacity=64)


@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-4])
def test_a_chain_passes_a_blow_on_to_the_particle_at_its_end(gap):
    """A fast particle hits the first of a row of resting ones; all must be awake in time."""
    radius = CASE.particle_radius
    places = [(k * (2.0 * radius + gap), 0.3, 0.0) for k in range(12)]
    places = [(-0.1, 0.3, 0.0), *places]
    velocities = [(12.0, 0.0, 0.0)] + [(0.0, 0.0, 0.0)] * 12
    # Released with small gaps, so that no particles overlap at the start.
    places = [(x * (1 + 1e-12), y, z) for x, y, z in places]
    state, _ = run_both(CASE, SMALL, 5000, ([0.0] * 13, places, velocities), pieces=5)
    last = np.sort(state.particles[:13], order="identity")[-1]
    assert last["vx"] > 1.0


def test_a_meeting_with_a_particle_that_was_deflected_gives_way_to_the_next():
    """The second particle is knocked off its way to the first, which then meets the fourth."""
    # In cells beside each other, so that all meetings are found at the release.
    places = [(0.0125, 0.35, 0.0125), (-0.0235, 0.35, 0.0125), (-0.0235, 0.35, 0.0425),
              (0.0475, 0.35, 0.0125)]  # fmt: skip
    velocities = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -2.0), (-0.4, 0.0, 0.0)]
    releases, dt = ([0.0] * 4, places, velocities), make_problem(CASE, SMALL)[0].dt
    met = []
    for time in (0.012, 0.03, 0.05):
        state, agenda = run_both(CASE, SMALL, int(time / dt), releases, capacity=FEW)
        met.append((int(agenda.plans["meet_with"][0]), float(state.particles["vx"][0])))
    # The deflection is noticed when the meeting is due, after 16 ms.
    assert met[:2] == [(1, 0.0), (-1, 0.0)]
    assert met[2][1] < -0.2


def test_a_particle_that_gains_speed_from_spin_breaks_its_pace():
    """Spin is converted to a speed that no flight could reach; the row must be made again."""
    setup = dataclasses.replace(SMALL, plate_length=0.3, removal_depth=0.02)
    places, speeds = [(0, 0.0101, 0), (0.0305, 0.011, 0)], [(0, -0.5, 0), (0, 0, 0)]
    case = dataclasses.replace(CASE, plate_angle=0.0, static_friction=2.0, restitution=0.8)
    flying = math.sqrt(0.5**2 + 2 * 9.81 * 0.05)
    releases = ([0.0, 0.0], places, speeds, [(0, 0, -3000.0), (0, 0, 0)])
    state, _ = run_both(case, setup, 4000, releases, pieces=20)
    assert np.hypot(state.particles["vx"], state.particles["vy"]).max() > flying


@pytest.mark.parametrize(
    ("angle", "radius", "speed", "duration"),
    [(45.0, 0.01, -5.0, 0.4), (0.0, 0.01, -3.0, 0.6), (60.0, 0.03, -1.0, 2.0)],
)
@pytest.mark.parametrize("model", [ContactModel(), ContactModel(tangential="displacement")])
def test_a_jet_is_the_same_bits(angle, radius, speed, duration, model):
    case = dataclasses.replace(
        CASE, plate_angle=angle, particle_radius=radius, particle_velocity_y=speed
    )
    setup = Setup(contact=model, pair_interaction=Interaction(0.35, 0.5, 0.02))
    problem, _ = make_problem(case, setup)
    state, _ = run_both(case, setup, int(duration / problem.dt), pieces=4)
    assert state.tally["worn_total"][0] > 0.0
    assert state.tally["removed"][0] > 0


@pytest.mark.parametrize(("crowd", "thin"), [(0.18, 0.10), (0.05, 0.3)])
def test_a_crowd_is_handed_over_and_back_with_the_same_bits(crowd, thin):
    """Six hundred particles fall on a small plate, pile up and slide off it.

    With the second pair of shares the stepping changes to and fro all the time.
    """
    case = dataclasses.replace(
        CASE, plate_angle=25.0, particle_radius=0.005, particle_velocity_y=-1.0
    )
    rng = np.random.default_rng(5)
    grid = [(0.0125 * i, 0.05 + 0.0125 * k, 0.0125 * j)
            for k in range(6) for i in range(-5, 5) for j in range(-5, 5)]  # fmt: skip
    places = np.array(grid) + rng.uniform(-1e-3, 1e-3, (600, 3))
    releases = (np.zeros(600), places, np.tile([0.0, -1.0, 0.0], (600, 1)))
    setup = Setup(plate_length=0.15, plate_width=0.15, removal_depth=5.0)
    problem, schedule = make_problem(case, setup, releases)
    slow, fast = make_state(problem, 1024), make_state(problem, 1024)
    agenda = make_agenda(problem, 1024)
    agenda.clock["crowd"], agenda.clock["thin"] = crowd, thin
    crowded = []
    for piece in range(1, 49):
        assert synchronous.advance(problem, schedule, slow, piece * 5000) == DONE
        assert islands.advance(problem, schedule, fast, agenda, piece * 5000) == DONE
        assert_same(slow, fast)
        crowded.append(int(agenda.clock["crowded"][0]))
    # Conventional stepping took part, and was left.
    assert fast.tally["drift"][0] > 0.0
    assert not crowded[-1]
    if thin < crowd:
        assert any(crowded)


CROWDED_JET = Setup(
    patch_length=0.3, patch_width=0.3, mass_rate=42.0, time_step_fraction=0.2, stepping="islands"
)


@pytest.mark.parametrize("angle", [10.0, 35.0])
def test_a_crowded_jet_is_the_same_bits(angle):
    """Most particles fly, hundreds touch, and the patch is so full that releases wait."""
    case = dataclasses.replace(
        CASE, particle_density=2500.0, plate_angle=angle, particle_velocity_y=-3.0
    )
    problem, _ = make_problem(case, CROWDED_JET)
    # Released on the same steps at the same places, or the particles would differ.
    state, agenda = run_both(case, CROWDED_JET, int(0.22 / problem.dt), pieces=3, capacity=2048)
    assert state.tally["pairs"][0] > 5
    assert state.tally["placed"][0] > 800
    assert agenda.clock["crowded"][0] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "angle", "setup"),
    [
        (0.01, 35.0, dataclasses.replace(CROWDED_JET, duration=1.0)),
        (0.01, 10.0, dataclasses.replace(CROWDED_JET, duration=1.0)),
        (0.005, 0.0, Setup(duration=0.6, time_step_fraction=0.2)),
    ],
)
def test_whole_crowded_simulations_are_the_same_bits(radius, angle, setup):
    """Scenarios E, F and the beginning of D of `benchmarks/speed.py`."""
    case = dataclasses.replace(
        CASE, particle_density=2500.0, particle_radius=radius, plate_angle=angle,
        factory_angle=0.0, particle_velocity_y=-3.0, seed=1,
    )  # fmt: skip
    fast = simulate(case, setup)
    slow = simulate(case, dataclasses.replace(setup, stepping="synchronous"))
    assert fast.status == slow.status == "ok"
    for name in ("worn", "facet_wear_all", "present", "delivered_mass", "max_overlap"):
        np.testing.assert_array_equal(getattr(fast, name), getattr(slow, name), name)


def test_pieces_of_any_length_give_the_same_bits():
    problem, schedule = make_problem(CASE, Setup())
    states = []
    for length in (50_000, 777, 13):
        state, agenda = make_state(problem, 256), make_agenda(problem, 256)
        for until in range(length, 50_000 + length, length):
            islands.advance(problem, schedule, state, agenda, min(until, 50_000))
        states.append(state)
    assert_same(states[0], states[1])
    assert_same(states[0], states[2])


def test_simulate_gives_the_same_result_with_both_steppings():
    setup = Setup(window=1.0, max_time=2.0)
    case = dataclasses.replace(CASE, particle_radius=0.02)
    fast = simulate(case, setup)
    slow = simulate(case, dataclasses.replace(setup, stepping="synchronous"))
    assert fast.status == slow.status == "ok"
    np.testing.assert_array_equal(fast.worn, slow.worn)
    np.testing.assert_array_equal(fast.facet_wear, slow.facet_wear)
    assert fast.stderr == slow.stderr
    assert fast.energy["dissipated"] == pytest.approx(slow.energy["dissipated"], rel=1e-12)


def test_room_can_be_made_at_any_time():
    """More than 256 particles use a grid, which must not outlive the arrays it was made for."""
    case = dataclasses.replace(
        CASE, particle_radius=0.006, particle_velocity_y=-0.05, plate_angle=34.0
    )
    problem, schedule = make_problem(case, Setup())
    slow, fast = make_state(problem, 512), make_state(problem, 512)
    agenda = make_agenda(problem, 512)
    steps = 0
    while steps < 90_000:
        # Until the crowd is there, growing changes nothing that the other tests do not see.
        steps += 40 if slow.tally["live"][0] > 256 else 5000
        assert synchronous.advance(problem, schedule, slow, steps) == DONE
        assert islands.advance(problem, schedule, fast, agenda, steps) == DONE
        capacity = fast.particles.size + 1
        fast, agenda = grown(fast, capacity), grown_agenda(agenda, problem, capacity)
        if slow.tally["live"][0] > 256 and capacity > 900:
            break
    assert slow.tally["live"][0] > 256
    assert_same(slow, fast)


# Cells


def placed_in_cells(capacity, count, seed):
    """Return problem, state and agenda with flying particles at random places, in their cells."""
    problem, _ = make_problem(CASE, SMALL)
    state, agenda = make_state(problem, capacity), make_agenda(problem, capacity)
    rng = np.random.default_rng(seed)
    for name in ("x", "y", "z"):
        place = rng.uniform(-0.1, 0.1, count)
        state.particles[name][:count] = state.particles[f"anchor_{name}"][:count] = place
    state.particles["motion"][:count] = FLYING
    state.tally["live"] = count
    assert islands.plan_all(problem, state, agenda)
    return problem, state, agenda


def listed(agenda, cell, old=-1):
    count = list_neighbours(agenda, cell, old)
    return agenda.near[:count].tolist()


@pytest.mark.parametrize("capacity", [64, 600])
def test_all_that_can_touch_are_in_the_cells_around(capacity):
    """Also if both have left their cells by the slack, and once each although cells repeat."""
    problem, state, agenda = placed_in_cells(capacity, 60, seed=3)
    slack = agenda.clock["slack"][0]
    places = np.stack([state.particles[name][:60] for name in ("x", "y", "z")], axis=1)
    near = 0
    for i in range(60):
        found = listed(agenda, agenda.plans["cell"][i])
        assert len(found) == len(set(found))
        # Along no axis do two particles of cells that are not adjacent come nearer than this.
        apart = np.abs(places - places[i]).max(axis=1)
        must = np.flatnonzero(apart < 2.0 * problem.radius + 2.0 * slack)
        assert set(must) <= set(found)
        near += must.size - 1
    assert near > 20


def test_new_neighbours_are_those_that_were_not_near_before():
    _, _, agenda = placed_in_cells(64, 60, seed=4)
    cells = np.unique(agenda.plans["cell"][:60])
    for cell in cells[:10]:
        for old in cells[:30]:
            new = set(listed(agenda, cell, old))
            assert new == set(listed(agenda, cell)) - set(listed(agenda, old))


def test_particles_without_room_in_their_cell_are_found_from_everywhere():
    """A cell holds seven; an eighth is in every search, and enters a cell when it moves on."""
    _, _, agenda = placed_in_cells(64, 0, seed=0)
    there, elsewhere = 0, 3
    for i in range(10):
        enter_cell(agenda, i, there)
    assert agenda.clock["spilled"][0] == 3
    assert sorted(listed(agenda, there)) == list(range(10))
    # Cell 3 is beyond those beside cell 0.
    assert sorted(listed(agenda, elsewhere)) == sorted(listed(agenda, there, there)) == [7, 8, 9]
    for i in (8, 0, 6):
        leave_cell(agenda, i)
    assert sorted(listed(agenda, there)) == [1, 2, 3, 4, 5, 7, 9]
    assert sorted(listed(agenda, elsewhere)) == [7, 9]
    enter_cell(agenda, 0, there)
    leave_cell(agenda, 7)
    leave_cell(agenda, 9)
    assert agenda.clock["spilled"][0] == 0 and listed(agenda, elsewhere) == []
    assert sorted(listed(agenda, there)) == [0, 1, 2, 3, 4, 5]


def test_a_heap_in_which_cells_have_no_room_gives_the_same_bits():
    """Particles a period of the grid apart share cells: four columns of them fill these."""
    case = dataclasses.replace(CASE, plate_angle=0.0, factory_angle=0.0)
    agenda = make_agenda(make_problem(case, SMALL)[0], 64)
    width = float(agenda.clock["width"][0])
    columns, layers = [0.5 * width, 8.5 * width], 0.02 + 0.021 * np.arange(4)
    x, y, z = (a.ravel() for a in np.meshgrid(columns, layers, columns))
    rng = np.random.default_rng(5)
    places = np.stack([x, y, z], axis=1) + 1e-4 * rng.uniform(-1.0, 1.0, (16, 3))
    velocities = rng.normal(0.0, 0.2, (16, 3))
    wide = dataclasses.replace(SMALL, plate_length=2.0, plate_width=2.0)
    problem, schedule = make_problem(case, wide, (np.zeros(16), places, velocities))
    most = 0
    slow, fast = make_state(problem, 64), make_state(problem, 64)
    for step in range(200, 8001, 200):
        assert synchronous.advance(problem, schedule, slow, step) == DONE
        assert islands.advance(problem, schedule, fast, agenda, step) == DONE
        most = max(most, agenda.clock["spilled"][0])
        assert_same(slow, fast)
    assert most > 3


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    speed=st.sampled_from([0.0, 0.01, 1.0, 30.0]),
    capacity=st.sampled_from([FEW, FEW + 1]),
)
def test_a_flight_leaves_its_cell_by_the_slack_at_the_time_that_is_told(seed, speed, capacity):
    problem, _ = make_problem(CASE, SMALL)
    rng = np.random.default_rng(seed)
    place, velocity = rng.uniform(-0.3, 0.3, 3), rng.normal(0.0, 1.0, 3) * speed
    clock = make_agenda(problem, capacity).clock[0]
    time = time_to_leave(clock, problem.gravity, *place, *velocity)
    size, slack = np.array([clock["width"], clock["height"], clock["width"]]), clock["slack"]
    low = np.floor(place / size) * size - slack
    high = low + size + 2.0 * slack

    def outside(t):
        """Distance outside the enlarged cell, m; negative inside."""
        at = place + velocity * t - np.array([0.0, 0.5 * problem.gravity * t * t, 0.0])
        return np.maximum(low - at, at - high).max()

    assert max(outside(t) for t in np.linspace(0.0, time, 400)[:-1]) < 1e-9
    assert abs(outside(time)) < 1e-9
    assert distance_to_leave(clock, *place) == pytest.approx(-outside(0.0), abs=1e-12)


# Bounds


def test_the_first_step_of_an_event_is_not_before_it_and_not_a_step_late():
    problem, _ = make_problem(CASE, SMALL)
    for steps, due in ((0.0, 7), (1e-9, 7), (0.5, 8), (1.0, 8), (2.25, 10), (1e9, 7 + 10**9)):
        assert due_step(problem, 7, steps * problem.dt) == due
    assert due_step(problem, 7, math.inf) == NEVER


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    growth=st.sampled_from([0.0, 0.05, 0.5, 4.0]),
    horizon=st.sampled_from([1e-4, 2e-3, 0.02, 0.1]),
)
def test_the_time_to_reach_a_growing_sphere_is_that_of_a_fine_search(seed, growth, horizon):
    rng = np.random.default_rng(seed)
    reach = 0.02
    p, u = rng.uniform(-0.06, 0.06, 3), rng.normal(0.0, 2.0, 3)
    if p @ p < reach**2:
        p = p * (1.01 * reach / math.sqrt(p @ p))
    found = time_to_reach(reach, tuple(p), tuple(u), p @ p, growth, horizon)
    times = np.linspace(0.0, 0.1, 100_001)
    apart = np.sqrt(((p + u * times[:, None]) ** 2).sum(axis=1)) - (reach + growth * times)
    inside = np.flatnonzero(apart <= 0.0)
    if inside.size and (math.isfinite(found) or times[inside[0]] <= horizon):
        assert times[inside[0]] - 1e-6 <= found <= times[inside[0]] + 1e-9
    elif not inside.size:
        assert found > times[-1] - 1e-9 or abs(apart).min() < 1e-6
    if growth == 0.0 and math.isfinite(found):
        meet = time_to_meet(reach**2, tuple(p), tuple(u), p @ p)
        assert meet == pytest.approx(found, rel=1e-9)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    x=st.floats(-1, 1), v=st.floats(-5, 5), a=st.sampled_from([-9.81, -3.0, 0.0, 4.0]),
    start=st.floats(0, 0.5),
)  # fmt: skip
def test_the_first_time_within_is_that_of_a_fine_search(x, v, a, start):
    half = 0.05
    found = first_time_within(x, v, a, half, start)
    times = np.linspace(start, start + 3.0, 300_001)
    inside = np.flatnonzero(np.abs(x + v * times + 0.5 * a * times**2) <= half)
    if inside.size:
        assert found <= times[inside[0]] + 1e-9
        assert abs(x + v * found + 0.5 * a * found**2) <= half * (1 + 1e-9) + 1e-12
    else:
        # Contacts missed by a fine search are grazing.
        assert found > start + 2.9 or found == np.inf or _is_graze(x, v, a, half, found)


def _is_graze(x, v, a, half, time):
    near = time + np.linspace(-2e-5, 2e-5, 5)
    return (np.abs(x + v * near + 0.5 * a * near**2) >= half * (1 - 1e-6)).any()


@pytest.mark.parametrize("angle", [0.0, 35.0, 90.0])
def test_nothing_reaches_the_plate_before_its_bound(angle):
    problem, _ = make_problem(dataclasses.replace(CASE, plate_angle=angle), SMALL)
    rng = np.random.default_rng(1)
    plate, radius = problem.plate, problem.radius
    touched = 0
    for _ in range(300):
        place = rng.uniform(-0.15, 0.15, 3)
        speed = rng.uniform(-1, 1, 3) - 20.0 * place
        bound = time_to_plate(problem, *place, *speed)
        if bound == 0.0:
            continue
        times = np.linspace(0.0, min(bound, 0.5), 2001)[:-1]
        x, y, z = place[:, None] + speed[:, None] * times
        y = y - 0.5 * problem.gravity * times**2
        along = plate.cos * x + plate.sin * y
        height = -plate.sin * x + plate.cos * y
        side = np.maximum(np.abs(along) - plate.half_length, 0.0)
        across = np.maximum(np.abs(z) - plate.half_width, 0.0)
        assert (np.sqrt(side**2 + height**2 + across**2) >= radius * (1 - 1e-12)).all()
        touched += math.isfinite(bound)
    assert 20 < touched < 300
