"""Several threads give the bits of one, under both steppings."""

import dataclasses
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abradem.dem import parallel, simulate
from abradem.dem.model import Case, ContactModel, Setup
from abradem.dem.simulation import Engine
from abradem.dem.state import DONE, GONE, make_problem
from abradem.dem.team import make_team
from abradem.verification.surface_scenes import extruded

CASE = Case(6e9, 0.25, 2500, 8e10, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 10.0, 0.0, 0.01, -3.0, 1)
SMALL = Setup(plate_length=0.08, plate_width=0.06, removal_depth=0.05)
CROWDED = Setup(
    plate_length=0.3, plate_width=0.3, patch_length=0.3, patch_width=0.3, mass_rate=42.0,
    time_step_fraction=0.2,
)  # fmt: skip


def present(engine):
    """All fields of the particles that are there, by identity; of flights that of the anchor."""
    live = engine.state.particles[: int(engine.state.tally["live"][0])]
    there = np.sort(live[live["motion"] != GONE], order="identity")
    names = ["identity", "motion", "vx", "vy", "vz", "wx", "wy", "wz", "anchor_step", "anchor_y"]
    return there[[*names, "plate_fn", "plate_sx", "plate_energy", "first_contact"]]


def assert_same(one, other):
    for name in one.state.tally.dtype.names:
        if name not in ("pairs", "drift", "gone", "live"):
            assert one.state.tally[name][0] == other.state.tally[name][0], name
    np.testing.assert_array_equal(one.state.facet_wear, other.state.facet_wear)
    np.testing.assert_array_equal(present(one), present(other))


def advanced(problem, schedule, stepping, threads, ends):
    """Advance to each of the steps ``ends`` in turn; return the engine and the outcome."""
    engine = Engine(problem, schedule, stepping, None, threads)
    for end in ends:
        outcome = engine.advance(end)
        if outcome != DONE:
            break
    return engine, outcome


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(2, 40),
    angle=st.sampled_from([0.0, 10.0, 45.0, 90.0, -30.0]),
    speed=st.sampled_from([0.0, 0.5, 4.0]),
    restitution=st.sampled_from([0.2, 0.5, 1.0]),
    friction=st.sampled_from([0.0, 0.45]),
    model=st.sampled_from([ContactModel(), ContactModel(tangential="displacement")]),
)
def test_small_scenes_are_the_same_bits(seed, count, angle, speed, restitution, friction, model):
    """Random places, speeds and spins around a small plate; most pairs are of several threads."""
    rng = np.random.default_rng(seed)
    places: list[np.ndarray] = []
    for place in rng.uniform(-1, 1, (count, 3)) * (0.06, 0.04, 0.04) + (0, 0.07, 0):
        if all(np.linalg.norm(place - other) > 0.020001 for other in places):
            places.append(place)
    count = len(places)
    velocities = rng.normal(0.0, 1.0, (count, 3)) * speed - 3.0 * np.array(places) * speed
    spins = rng.normal(0.0, 100.0, (count, 3))
    times = np.sort(rng.choice([0.0, 0.0, 0.002], count))
    case = dataclasses.replace(
        CASE, plate_angle=angle, restitution=restitution, static_friction=friction
    )
    setup = dataclasses.replace(SMALL, contact=model)
    problem, schedule = make_problem(case, setup, (times, places, velocities, spins))
    # Some releases are into an overlap, which ends the case.
    alone, outcome = advanced(problem, schedule, "synchronous", 1, [800])
    for threads, ends in ((2, [800]), (3, [1, 300, 800])):
        together, same = advanced(problem, schedule, "synchronous", threads, ends)
        assert same == outcome
        assert_same(together, alone)


@pytest.mark.parametrize("stepping", ["islands", "synchronous"])
@pytest.mark.parametrize("threads", [2, 3])
def test_a_crowded_jet_is_the_same_bits(monkeypatch, stepping, threads):
    """Hundreds of particles arrive, collide and leave, and room is made for them."""
    sections = []
    advance = parallel.advance

    def noted(problem, schedule, state, team, me, last_step):
        sections.append(me)
        return advance(problem, schedule, state, team, me, last_step)

    monkeypatch.setattr(parallel, "advance", noted)
    setup = dataclasses.replace(CROWDED, plate_length=0.25, plate_width=0.25, removal_depth=0.02)
    case = dataclasses.replace(CASE, particle_radius=0.008)
    problem, schedule = make_problem(case, setup)
    last = int(0.13 / problem.dt)
    alone, _ = advanced(problem, schedule, "islands", 1, [last])
    engine = Engine(problem, schedule, stepping, None, threads)
    if stepping == "islands":
        # To and fro between steppings, from 2 % of what touches on.
        engine.agenda.clock["crowd"], engine.agenda.clock["thin"] = 0.02, 0.05
        engine.agenda.clock["threads"] = threads
    for end in (last // 3, last // 2, last):
        assert engine.advance(end) == DONE
    assert_same(engine, alone)
    assert alone.state.tally["removed"][0] > 0
    assert alone.state.tally["pairs"][0] > 0
    assert set(sections) == set(range(threads))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "angle", "setup"),
    [
        (0.01, 35.0, dataclasses.replace(CROWDED, duration=1.0)),
        (0.01, 10.0, dataclasses.replace(CROWDED, duration=0.5)),
        (0.005, 0.0, Setup(duration=0.5, time_step_fraction=0.2)),
    ],
)
def test_whole_simulations_are_the_same_bits(radius, angle, setup):
    """Scenario E and the beginnings of F and D of `benchmarks/speed.py`."""
    case = dataclasses.replace(CASE, particle_radius=radius, plate_angle=angle)
    alone = simulate(case, setup)
    together = simulate(case, setup, threads=2)
    assert alone.status == together.status == "ok"
    for name in ("worn", "facet_wear_all", "present", "delivered_mass", "max_overlap"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(together, name), name)


def test_samples_and_snapshots_are_the_same_bits():
    """With `simulate`: the stop rule, the energy balance and what a recorder sees."""

    class Recorder:
        interval = 0.01

        def __init__(self):
            self.seen = []

        def record(self, time, problem, state):
            self.seen.append((time, float(state.tally["worn_total"][0])))

    setup = dataclasses.replace(CROWDED, fall_height=0.05, duration=0.035, stepping="synchronous")
    one, two = Recorder(), Recorder()
    alone = simulate(CASE, setup, recorder=one)
    together = simulate(CASE, setup, recorder=two, threads=2)
    sampled = simulate(CASE, setup, threads=2)
    assert one.seen == two.seen
    assert one.seen[-1][1] > 0.0
    np.testing.assert_array_equal(alone.worn, together.worn)
    np.testing.assert_array_equal(alone.worn, sampled.worn)
    assert alone.energy["dissipated"] == pytest.approx(together.energy["dissipated"], rel=1e-12)


def test_a_simulation_with_a_surface_uses_one_thread():
    surface = extruded([(-0.1, 0.0), (0.1, 0.0)], 0.1)
    problem, schedule = make_problem(CASE, Setup(surface=surface))
    for stepping in ("islands", "synchronous"):
        engine = Engine(problem, schedule, stepping, surface, 2)
        assert engine.threads is None
        assert engine.agenda is None or engine.agenda.clock["threads"][0] == 1


@pytest.mark.parametrize("threads", [0, -1, 65])
def test_a_number_of_threads_out_of_range_is_refused(threads):
    with pytest.raises(ValueError, match=f"threads = {threads}; allowed: 1 to 64"):
        simulate(CASE, SMALL, threads=threads)


def test_too_large_an_overlap_stops_threads_at_the_step_that_stops_one():
    """Two particles shot at each other, in slabs of their own."""
    case = dataclasses.replace(CASE, particle_shear_modulus=1e6, particle_density=8000.0)
    places, speeds = [(-0.02, 0.3, 0.0), (0.02, 0.3, 0.0)], [(30.0, 0, 0), (-30.0, 0, 0)]
    problem, schedule = make_problem(case, SMALL, ([0.0, 0.0], places, speeds))
    outcomes = []
    for threads in (1, 2):
        engine = Engine(problem, schedule, "synchronous", None, threads)
        outcomes.append((engine.advance(100_000), int(engine.state.tally["step"][0])))
    assert outcomes[0] == outcomes[1]
    assert outcomes[0][0] != DONE


def test_an_error_in_a_thread_is_raised_and_stops_the_others(monkeypatch):
    problem, schedule = make_problem(CASE, CROWDED)
    advance = parallel.advance

    def failing(problem, schedule, state, team, me, last_step):
        if me == 1:
            raise MemoryError("no room")
        return advance(problem, schedule, state, team, me, last_step)

    engine = Engine(problem, schedule, "synchronous", None, 3)
    assert engine.advance(100) == DONE
    monkeypatch.setattr(parallel, "advance", failing)
    with pytest.raises(MemoryError, match="no room"):
        engine.advance(200)
    assert threading.active_count() == 1


def test_slabs_have_equal_work():
    """Of particles in a row, all alike, each of three threads gets a third."""
    problem, schedule = make_problem(CASE, SMALL)
    engine = Engine(problem, schedule, "synchronous")
    state, team = engine.state, make_team(3, 64)
    state.particles["x"][:60] = 0.03 * np.random.default_rng(1).permutation(60)
    state.particles["motion"][:60] = 1
    state.tally["live"] = 60
    parallel._share_out(state, team)
    owner = team.owner[:60]
    assert sorted(np.bincount(owner)) == [20, 20, 20]
    assert (np.diff(owner[np.argsort(state.particles["x"][:60])]) >= 0).all()
