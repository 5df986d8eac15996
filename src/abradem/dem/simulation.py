"""One case from the first stone to the stop rule."""

from __future__ import annotations

import math

import numpy as np

from abradem.dem import islands, synchronous
from abradem.dem.agenda import grown_agenda, make_agenda
from abradem.dem.contact import hertz_duration
from abradem.dem.energy import energy_book
from abradem.dem.model import Case, Setup, SimulationResult
from abradem.dem.state import (
    DONE,
    NEEDS_ROOM,
    STOP_NOT_FINITE,
    STOP_REASONS,
    Problem,
    Schedule,
    State,
    grown,
    make_problem,
    make_state,
)
from abradem.dem.steady import batch_means, steady_start
from abradem.parameters import READINGS

FIRST_CAPACITY = 64
ENERGY_TOLERANCE = 0.02
"""Energy gained between two samples that ends a case, as a share of the energy put in."""

CHECK_GROWTH = 1.1
"""The stop rule is looked at when the simulated time has grown by this factor: often enough to
stop early, seldom enough not to stop on a lucky fluctuation."""

MAPS_PER_WINDOW = 10
FEWEST_STEPS_PER_CONTACT = 5.0
MOST_STEPS_PER_CONTACT = 1e5
MOST_SAMPLES = 10**5
MOST_PARTICLES = 2**19
"""Particles present at once, samples, and steps per contact beyond which a case, which would not
end in days, is refused or stopped."""


def simulate(case: Case, setup: Setup | None = None, releases=None, progress=None, recorder=None):
    """Pour spheres on the plate of ``case`` until its wear rate is known well enough.

    The transient is dropped by `steady.steady_start`. Simulation goes on until the ``window``
    after it is complete and the relative standard error of the plate-mean ``total`` rate is at
    most ``target_stderr``, or until ``max_time``; with ``duration``, exactly so long.

    Parameters
    ----------
    case : Case
    setup : Setup, optional
        The default is the study of the paper.
    releases : tuple of array_like, optional
        Times (n,) in s, positions (n, 3) in m, velocities (n, 3) in m/s and optionally spins
        (n, 3) in rad/s, which replace the factory; every code can be fed the same stones.
    progress : callable, optional
        Called with the simulated time (s) at each sample.
    recorder : object, optional
        With an attribute ``interval`` (s) and a method ``record(time, problem, state)``, called
        at 0 and then at that interval; it must not change the state.

    Returns
    -------
    SimulationResult

    Raises
    ------
    ValueError
        If the time step does not resolve a contact or is absurdly short, if samples or particles
        would be too many, or the releases are malformed.
    """
    setup = Setup() if setup is None else setup
    problem, schedule = make_problem(case, setup, releases)
    _check_step(problem, schedule, setup)
    _check_size(problem, setup)
    engine = _Engine(problem, schedule, setup.stepping)
    sample_steps = max(1, round(setup.sample_interval / problem.dt))
    interval = sample_steps * problem.dt
    map_samples = max(1, round(setup.window / MAPS_PER_WINDOW / interval))
    window_maps = max(1, round(setup.window / (map_samples * interval)))
    samples = max(1, round(_longest(setup) / interval))
    record_steps = max(1, round(recorder.interval / problem.dt)) if recorder else None
    state = engine.state
    if recorder:
        recorder.record(0.0, problem, state)

    time, worn, placed = [0.0], [np.zeros(3)], [0]
    maps = [state.facet_wear.copy()]
    book = energy_book(problem, state)
    status = "ok"
    next_check = setup.window
    settled = None
    for sample in range(1, samples + 1):
        outcome = engine.advance(sample * sample_steps, record_steps, recorder)
        state = engine.state
        if outcome == DONE:
            outcome, book = _guard(problem, state, book)
        if outcome != DONE:
            status = STOP_REASONS.get(outcome, outcome)
            break
        time.append(sample * interval)
        worn.append(_worn(state))
        placed.append(int(state.tally["placed"][0]))
        if sample % map_samples == 0:
            maps.append(state.facet_wear.copy())
        if progress is not None:
            progress(time[-1])
        if setup.duration is None and time[-1] >= next_check:
            next_check = time[-1] * CHECK_GROWTH
            settled = _steady(time, worn, map_samples * interval)
            if (
                settled.settled
                and settled.first_map + window_maps < len(maps)
                and settled.relative_stderr <= setup.target_stderr
            ):
                break
    return _result(
        case, setup, problem, state, status, time, worn, placed, maps, window_maps,
        map_samples * interval,
    )  # fmt: skip


def _worn(state: State) -> np.ndarray:
    return np.array([state.tally[f"worn_{reading}"][0] for reading in READINGS])


class _Engine:
    """A state and the stepping that advances it, with room made as needed."""

    def __init__(self, problem: Problem, schedule: Schedule, stepping: str):
        self.problem, self.schedule = problem, schedule
        self.state = make_state(problem, FIRST_CAPACITY)
        # Only the stepping by islands keeps an agenda.
        self.agenda = make_agenda(problem, FIRST_CAPACITY) if stepping == "islands" else None

    def advance(self, last_step: int, record_steps, recorder) -> int | str:
        """Step on to ``last_step``, recording on the way; return how that ended."""
        while True:
            target = last_step
            if record_steps:
                step = int(self.state.tally["step"][0])
                target = min(target, (step // record_steps + 1) * record_steps)
            outcome = self._kernel(target)
            if outcome == NEEDS_ROOM:
                if self.state.particles.size >= MOST_PARTICLES:
                    return f"more than {MOST_PARTICLES} particles at once"
                self._grow()
                continue
            if outcome != DONE:
                return outcome
            if record_steps and target % record_steps == 0:
                recorder.record(target * self.problem.dt, self.problem, self.state)
            if target == last_step:
                return DONE

    def _kernel(self, target: int) -> int:
        if self.agenda is None:
            return synchronous.advance(self.problem, self.schedule, self.state, target)
        return islands.advance(self.problem, self.schedule, self.state, self.agenda, target)

    def _grow(self) -> None:
        capacity = 2 * self.state.particles.size
        self.state = grown(self.state, capacity)
        if self.agenda is not None:
            self.agenda = grown_agenda(self.agenda, self.problem, capacity)


def _check_step(problem: Problem, schedule: Schedule, setup: Setup) -> None:
    """Refuse a step that would jump through a contact."""
    fastest = _fall_speed(problem, setup)
    if problem.scheduled and schedule.velocity.size:
        heights = np.maximum(schedule.position[:, 1] - problem.removal_height, 0.0)
        with np.errstate(over="ignore"):
            speeds2 = (schedule.velocity**2).sum(axis=1) + 2.0 * problem.gravity * heights
        fastest = float(np.sqrt(speeds2).max())
    if fastest == 0.0:
        return
    steps = hertz_duration(problem.plate_law, problem.mass, fastest) / problem.dt
    # Also where an infinite speed leaves no number of steps at all.
    if not steps >= FEWEST_STEPS_PER_CONTACT:
        raise ValueError(
            f"time step {problem.dt:.3g} s gives {steps:.1f} steps per contact at "
            f"{fastest:.3g} m/s; at least {FEWEST_STEPS_PER_CONTACT:g} are needed"
        )
    if steps > MOST_STEPS_PER_CONTACT:
        raise ValueError(
            f"time step {problem.dt:.3g} s gives {steps:.3g} steps per contact at "
            f"{fastest:.3g} m/s; at most {MOST_STEPS_PER_CONTACT:g} are taken"
        )


def _check_size(problem: Problem, setup: Setup) -> None:
    """Refuse what would need more samples or particles than a computer has time for."""
    samples = _longest(setup) / max(setup.sample_interval, problem.dt)
    if samples > MOST_SAMPLES:
        raise ValueError(
            f"sample_interval = {setup.sample_interval:g} s gives {samples:.3g} samples in "
            f"{_longest(setup):g} s; at most {MOST_SAMPLES} are taken"
        )
    fastest = _fall_speed(problem, setup)
    if problem.scheduled or fastest == 0.0:
        return
    # Above the plate at once: what is released during the fall, or what has room there.
    falling = min(problem.rate * setup.fall_height / fastest, _room(problem, setup))
    if falling > MOST_PARTICLES:
        raise ValueError(
            f"the feed of {problem.rate:.3g} particles per second of radius {problem.radius:g} m "
            f"keeps {falling:.3g} of them in the air; at most {MOST_PARTICLES} are simulated"
        )


def _fall_speed(problem: Problem, setup: Setup) -> float:
    """Speed of a particle from the factory at the height of the plate's middle, m/s."""
    return math.sqrt(problem.release_speed**2 + 2.0 * problem.gravity * setup.fall_height)


def _longest(setup: Setup) -> float:
    return setup.max_time if setup.duration is None else setup.duration


def _room(problem: Problem, setup: Setup) -> float:
    """Particles that find room between patch and plate: volume by that of a sphere."""
    sides = (
        side + 2.0 * problem.radius
        for side in (setup.patch_length, setup.patch_width, setup.fall_height)
    )
    return math.prod(sides) / (4.0 / 3.0 * math.pi * problem.radius**3)


def _guard(problem: Problem, state: State, before: dict):
    """Check that positions are numbers and that no energy was gained since the last sample."""
    book = energy_book(problem, state)
    if not (math.isfinite(book["resident"]) and math.isfinite(book["removed"])):
        return STOP_NOT_FINITE, book
    if not np.isfinite(_worn(state)).all():
        return "the wear is not a finite number", book
    gained = before["dissipated"] - book["dissipated"]
    if gained > ENERGY_TOLERANCE * max(book["inserted"], 0.0) and gained > 0.0:
        share = gained / book["inserted"]
        return f"energy gain of {100 * share:.1f} % of the energy put in", book
    return DONE, book


class _Steady:
    """The steady part of a record: where it begins and how well the rate is known."""

    def __init__(self, time, total, map_interval):
        start = steady_start(time, total)
        self.settled = start.settled
        self.first_map = math.ceil(start.time / map_interval - 1e-9)
        self.start = self.first_map * map_interval
        rate = batch_means(time, total, self.start)
        known = rate.batches > 0 and rate.rate > 0.0
        self.relative_stderr = rate.stderr / rate.rate if known else math.inf


def _steady(time, worn, map_interval) -> _Steady:
    return _Steady(np.array(time), np.array(worn)[:, 0], map_interval)


def _result(
    case, setup, problem, state, status, time, worn, placed, maps, window_maps, map_interval
) -> SimulationResult:
    steady = _steady(time, worn, map_interval)
    complete = steady.first_map + window_maps < len(maps)
    if complete:
        last = steady.first_map + window_maps
        facet_wear = maps[last] - maps[steady.first_map]
        window = (steady.start, last * map_interval)
    else:
        facet_wear = np.full_like(state.facet_wear, np.nan)
        window = (math.nan, math.nan)
    tally = state.tally[0]
    ended = int(tally["face"] + tally["edge"] + tally["missed"])
    simulated = time[-1]
    delivered = np.array(placed) * problem.mass

    def share(number):
        return float(number) / ended if ended else math.nan

    return SimulationResult(
        case=case,
        setup=setup,
        status=status,
        time=np.array(time),
        worn=np.array(worn),
        delivered_mass=delivered,
        facet_wear=facet_wear,
        facet_wear_all=state.facet_wear.copy(),
        window=window,
        steady_from=steady.start if complete else math.nan,
        settled=steady.settled,
        stderr=steady.relative_stderr if complete else math.nan,
        time_step=problem.dt,
        simulated_time=simulated,
        requested_rate=problem.rate * problem.mass if not problem.scheduled else math.nan,
        delivered_rate=float(delivered[-1] / simulated) if simulated > 0 else 0.0,
        face_share=share(tally["face"]),
        edge_share=share(tally["edge"]),
        missed_share=share(tally["missed"]),
        max_overlap=float(tally["largest_overlap"]),
        released=int(tally["placed"]),
        removed=int(tally["removed"]),
        energy=energy_book(problem, state),
    )
