"""Simulation of one case, from the first particle to the stop rule."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from abradem.dem import samples
from abradem.dem.agenda import Agenda, grown_agenda, make_agenda
from abradem.dem.energy import energy_balance
from abradem.dem.impact import CONVERGED_STEPS, step_bias
from abradem.dem.islands import CROWD_STEPS, resume_if_thinned
from abradem.dem.model import MOST_THREADS, Case, Setup, SimulationResult
from abradem.dem.samples import Record, make_record
from abradem.dem.state import (
    DONE,
    NEEDS_ROOM,
    NEEDS_TEAM,
    STOP_CROWDED,
    STOP_ENERGY_GAIN,
    STOP_REASONS,
    Problem,
    Schedule,
    State,
    grown,
    lowest_point,
    make_problem,
    make_state,
)
from abradem.dem.stop import StopRule
from abradem.dem.surface import Surface
from abradem.elastic import hertz_duration, sphere_volume

if TYPE_CHECKING:
    from abradem.dem.parallel import Threads

FIRST_CAPACITY = 256
"""Room for particles at the beginning."""

PARTICLES_IN_A_CALL = 2000
"""Largest product of particles present and samples in one kernel call."""

LARGEST_STEP_BIAS = 0.05
"""Largest bias of ``total`` and ``friction`` that the time step may cause in the first impact on
the plate. A case beyond it is refused: its wear would be wrong without a sign of it."""

JUDGED_ANGLES = (10.0, 80.0)
"""Angles from the normal, degrees, between which the first impact is judged. Nearer to the normal
its wear tends to zero and the bias to a constant."""

SURFACE_ANGLES = (20.0, 45.0, 70.0)
"""Angles at which the first impact on a surface is judged, degrees."""

FEWEST_STEPS_PER_CONTACT = 5.0
MOST_STEPS_PER_CONTACT = 1e5
MOST_SAMPLES = 10**5
MOST_PARTICLES = 2**19
"""Limits of the steps per contact, samples, and particles present at once. A case beyond a limit
is rejected or stopped; above the upper limits it would take days."""


def simulate(
    case: Case,
    setup: Setup | None = None,
    releases=None,
    progress=None,
    recorder=None,
    threads: int = 1,
):
    """Pour particles on the plate of ``case`` until the wear rate is accurate enough.

    `steady.steady_part` finds the end of the transient. The simulation continues until the
    ``window`` after the transient is complete and the relative standard error of the plate-mean
    ``total`` rate is reliably at most ``target_stderr`` (`stop.StopRule`), or until ``max_time``.
    If ``duration`` is given, it ends exactly after that time.

    Parameters
    ----------
    case : Case
    setup : Setup, optional
        The default is that of `studies/dilute.yaml`.
    releases : tuple of array_like, optional
        Times (n,) in s, positions (n, 3) in m, velocities (n, 3) in m/s and, optionally, spins
        (n, 3) in rad/s of the released particles. They replace the factory, so that other codes
        can be given the same particles.
    progress : callable, optional
        Called with the simulated time (s) at each sample.
    recorder : object, optional
        Has an attribute ``interval`` (s) and a method ``record(time, problem, state)``, which is
        called at time 0 and then at that interval. It must not change the state.
    threads : int, optional
        Number of threads, 1 to `MOST_THREADS`; it changes no bit of the result. They step crowds
        and what the stepping ``synchronous`` steps, see `parallel`. A simulation with a surface
        uses one.

    Returns
    -------
    SimulationResult

    Raises
    ------
    ValueError
        If the time step does not resolve a contact or is far too short, if there would be too
        many samples or particles, if the releases are malformed, or if the number of threads is
        out of range.
    """
    setup = Setup() if setup is None else setup
    if not 1 <= threads <= MOST_THREADS:
        raise ValueError(f"threads = {threads}; allowed: 1 to {MOST_THREADS}")
    problem, schedule = make_problem(case, setup, releases)
    _check_step(case, problem, schedule, setup)
    _check_size(case, problem, setup)
    engine = Engine(problem, schedule, setup.stepping, setup.surface, threads)
    sample_steps = max(1, round(setup.sample_interval / problem.dt))
    interval = sample_steps * problem.dt
    rule = StopRule(setup, interval, 0.0 if problem.scheduled else 1.0 / problem.rate)
    count = max(1, round(_longest(setup) / interval))
    record_steps = max(1, round(recorder.interval / problem.dt)) if recorder else None
    if recorder:
        recorder.record(0.0, problem, engine.state)

    time = np.arange(count + 1) * interval
    record = make_record(count)
    maps = [_map(engine.state)]
    status = "ok"
    if setup.duration is not None:
        rule.next_look = count + 1
    alone = recorder or progress is not None
    sample = 0
    outcome: int | str = DONE
    while sample < count:
        last = sample + 1
        if not alone:
            # Continue to the next map or the next evaluation of the stop rule.
            next_map = (sample // rule.map_samples + 1) * rule.map_samples
            last = min(count, next_map, max(last, rule.next_look))
            last = min(last, sample + engine.samples_in_a_call())
        if recorder:
            outcome = engine.advance(last * sample_steps, record_steps, recorder)
        if outcome == DONE:
            # With a recorder the state is already advanced, and this only takes the sample.
            sample, outcome = engine.take_samples(sample_steps, sample, last, record)
        if outcome != DONE:
            status = _status(outcome, record)
            break
        if sample % rule.map_samples == 0:
            maps.append(_map(engine.state))
        if progress is not None:
            progress(float(time[sample]))
        if sample >= rule.next_look and rule.ends(*_past(record, time, sample)):
            break
    return _result(
        case, setup, problem, engine.state, status, time[: sample + 1], record, maps, rule
    )


def _map(state: State) -> np.ndarray:
    """Copy of the wear of all facets, and of the other sums of the cells of a surface."""
    if state.mesh is None:
        return state.facet_wear.copy()
    return np.concatenate([state.facet_wear[:, :, 0], state.mesh.sums.T])


def _status(outcome: int | str, record: Record) -> str:
    """Return the status text of a case that ended early."""
    if outcome == STOP_ENERGY_GAIN:
        gained = 100.0 * record.balance["gained"][0]
        return f"energy gain of {gained:.3g} % of the energy that moved"
    return outcome if isinstance(outcome, str) else STOP_REASONS[outcome]


class Engine:
    """A state and the stepping that advances it; the arrays grow as needed."""

    def __init__(
        self,
        problem: Problem,
        schedule: Schedule,
        stepping: str,
        surface: Surface | None = None,
        threads: int = 1,
    ):
        self.problem, self.schedule = problem, schedule
        self.state = make_state(problem, FIRST_CAPACITY, surface)
        self.threads: Threads | None = None
        # Only the stepping by islands and threads need an agenda.
        self.agenda: Agenda | None = None
        if threads > 1 and surface is None:
            # Loaded only if it is used, as its kernels are.
            from abradem.dem.parallel import Threads

            self.threads = Threads(threads)
            self.agenda = make_agenda(problem, FIRST_CAPACITY, threads)
            if stepping == "synchronous":
                # A crowd from the beginning to the end.
                self.agenda.clock["crowded"], self.agenda.clock["thin"] = 1, -1.0
        elif stepping == "islands":
            self.agenda = make_agenda(problem, FIRST_CAPACITY)

    def advance(self, last_step: int, record_steps=None, recorder=None) -> int | str:
        """Advance to ``last_step`` and call the recorder at its interval; return the outcome."""
        while True:
            target = last_step
            if record_steps:
                target = min(target, (self._step() // record_steps + 1) * record_steps)
            outcome = self._advance(target)
            if outcome != DONE:
                return outcome
            if record_steps and target % record_steps == 0:
                recorder.record(target * self.problem.dt, self.problem, self.state)
            if target == last_step:
                return DONE

    def take_samples(
        self, sample_steps: int, sample: int, last: int, record: Record
    ) -> tuple[int, int | str]:
        """Continue to sample ``last``; return the last sample reached and the outcome."""
        while True:
            sample, outcome = samples.take_samples(
                self.problem, self.schedule, self.state, self.agenda, sample_steps, sample, last,
                record,
            )  # fmt: skip
            if outcome == DONE:
                return sample, DONE
            outcome = self._give_what_is_needed(outcome, (sample + 1) * sample_steps)
            if outcome != DONE:
                return sample, outcome

    def _advance(self, target: int) -> int | str:
        while True:
            outcome = samples.advance(self.problem, self.schedule, self.state, self.agenda, target)
            if outcome == DONE:
                return DONE
            needed = self._give_what_is_needed(outcome, target)
            if needed != DONE:
                return needed

    def _step(self) -> int:
        return int(self.state.tally["step"][0])

    def _give_what_is_needed(self, outcome: int, target: int) -> int | str:
        """Make room, or step a crowd to ``target`` at most; return `DONE` or why a case ends."""
        if outcome == NEEDS_TEAM and self.threads and self.agenda:
            until = min(target, self._step() + CROWD_STEPS)
            outcome = self.threads.advance(self.problem, self.schedule, self.state, until)
            if outcome == DONE and not resume_if_thinned(self.problem, self.state, self.agenda):
                return STOP_CROWDED
        return self._make_room() if outcome == NEEDS_ROOM else outcome

    def samples_in_a_call(self) -> int:
        """Number of samples in one kernel call; an interrupt only acts after the call."""
        return max(1, PARTICLES_IN_A_CALL // max(1, int(self.state.tally["live"][0])))

    def _make_room(self) -> int | str:
        """Double the capacity; return `DONE`, or the reason why it cannot be increased."""
        capacity = 2 * self.state.particles.size
        if capacity > MOST_PARTICLES:
            return f"more than {MOST_PARTICLES} particles at once"
        self.state = grown(self.state, capacity)
        if self.agenda is not None:
            self.agenda = grown_agenda(self.agenda, self.problem, capacity)
        return DONE


def _check_step(case: Case, problem: Problem, schedule: Schedule, setup: Setup) -> None:
    """Raise if the time step does not resolve a contact or is far too short."""
    fastest, angle = _fall_speed(case, problem, setup), abs(case.plate_angle)
    if problem.scheduled and schedule.velocity.size:
        fastest, angle = _fastest_release(problem, schedule, lowest_point(case, setup))
    if fastest == 0.0:
        return
    steps = hertz_duration(problem.plate_law.kn, problem.mass, fastest) / problem.dt
    # The condition also catches nan, the result of an infinite speed.
    if not steps >= FEWEST_STEPS_PER_CONTACT:
        raise ValueError(
            f"time step {problem.dt:.3g} s gives {steps:.1f} steps per contact at "
            f"{fastest:.3g} m/s; at least {FEWEST_STEPS_PER_CONTACT:g} are needed"
        )
    if steps > MOST_STEPS_PER_CONTACT:
        raise ValueError(
            f"time step {problem.dt:.3g} s gives {steps:.3g} steps per contact at "
            f"{fastest:.3g} m/s; at most {MOST_STEPS_PER_CONTACT:g} are allowed"
        )
    if steps < CONVERGED_STEPS:
        # A surface is met at any angle.
        for judged in (angle,) if setup.surface is None else SURFACE_ANGLES:
            _check_bias(case, problem, setup, fastest, judged, steps)


def _check_bias(case, problem, setup, speed, angle, steps) -> None:
    """Raise if the time step biases the wear of the first impact too much."""
    angle = min(max(angle, JUDGED_ANGLES[0]), JUDGED_ANGLES[1])
    try:
        found = step_bias(case, setup.contact, problem.dt, speed, angle)
    except ValueError:
        # Too soft for this speed, which the guards tell.
        return
    for measure, bias in found.items():
        if not abs(bias) <= LARGEST_STEP_BIAS:
            raise ValueError(
                f"time step {problem.dt:.3g} s, {steps:.1f} steps per contact at {speed:.3g} m/s, "
                f"biases {measure} of an impact at {angle:.3g} deg from the normal by "
                f"{100.0 * bias:+.1f} %; at most {100.0 * LARGEST_STEP_BIAS:g} % are allowed"
            )


def _fastest_release(problem: Problem, schedule: Schedule, lowest: float) -> tuple[float, float]:
    """Return speed (m/s) and angle from the normal of the plate (deg) of the fastest release.

    They are those at the height of the lowest point of the plate or the surface.
    """
    heights = np.maximum(schedule.position[:, 1] - lowest, 0.0)
    with np.errstate(over="ignore"):
        speeds2 = (schedule.velocity**2).sum(axis=1) + 2.0 * problem.gravity * heights
    fastest = int(np.argmax(speeds2))
    speed = math.sqrt(speeds2[fastest])
    if not 0.0 < speed < math.inf:
        return speed, 0.0
    along, across = schedule.velocity[fastest, 0], schedule.velocity[fastest, 2]
    down = math.sqrt(max(speeds2[fastest] - along**2 - across**2, 0.0))
    towards = problem.plate.cos * down + problem.plate.sin * along
    return speed, math.degrees(math.acos(min(abs(towards) / speed, 1.0)))


def _check_size(case: Case, problem: Problem, setup: Setup) -> None:
    """Raise if the simulation would need too many samples or particles."""
    samples = _longest(setup) / max(setup.sample_interval, problem.dt)
    if samples > MOST_SAMPLES:
        raise ValueError(
            f"sample_interval = {setup.sample_interval:g} s gives {samples:.3g} samples in "
            f"{_longest(setup):g} s; at most {MOST_SAMPLES} are allowed"
        )
    fastest, height = _fall_speed(case, problem, setup), _fall_height(case, problem, setup)
    if problem.scheduled or fastest == 0.0:
        return
    # Above the plate at once: the particles released during one fall, or those that fit there.
    falling = min(problem.rate * height / fastest, _room(problem, height))
    if falling > MOST_PARTICLES:
        raise ValueError(
            f"the feed of {problem.rate:.3g} particles per second of radius {problem.radius:g} m "
            f"keeps {falling:.3g} of them in the air; at most {MOST_PARTICLES} are allowed"
        )


def _fall_height(case: Case, problem: Problem, setup: Setup) -> float:
    """Height of the factory above the centre of the plate or the lowest point of a surface, m."""
    if setup.surface is None:
        return setup.fall_height
    return max(problem.patch_height - lowest_point(case, setup), 0.0)


def _fall_speed(case: Case, problem: Problem, setup: Setup) -> float:
    """Speed of a particle from the factory after its fall, m/s."""
    height = _fall_height(case, problem, setup)
    return math.sqrt(case.particle_velocity_y**2 + 2.0 * problem.gravity * height)


def _longest(setup: Setup) -> float:
    return setup.max_time if setup.duration is None else setup.duration


def _room(problem: Problem, height: float) -> float:
    """Number of particles that fit between patch and plate: volume over that of a particle."""
    sides = (
        side + 2.0 * problem.radius
        for side in (2.0 * problem.patch_half_length, 2.0 * problem.patch_half_width, height)
    )
    return math.prod(sides) / sphere_volume(problem.radius)


def _past(record: Record, time, sample: int):
    """Times, ``total`` wear and particles present up to a sample."""
    past = slice(sample + 1)
    return time[past], record.worn[past, 0], record.present[past]


def _result(
    case, setup, problem, state, status, time, record, maps, rule: StopRule
) -> SimulationResult:
    steady = rule.steady(*_past(record, time, len(time) - 1))
    complete = steady.complete(len(maps))
    last = _map(state)
    if complete:
        windowed = maps[steady.last_map] - maps[steady.first_map]
        parts = np.diff(maps[steady.first_map : steady.last_map + 1], axis=0)
        window = (steady.start, steady.window_end)
    else:
        windowed = np.full_like(last, np.nan)
        parts = np.empty((0, *last.shape))
        window = (math.nan, math.nan)
    measures = len(state.facet_wear)
    tally = state.tally[0]
    ended = int(tally["face"] + tally["edge"] + tally["missed"])
    simulated = float(time[-1])
    past = slice(time.size)
    delivered = record.placed[past] * problem.mass

    def share(number):
        return float(number) / ended if ended else math.nan

    return SimulationResult(
        case=case,
        setup=setup,
        status=status,
        time=time,
        worn=record.worn[past],
        delivered_mass=delivered,
        present=record.present[past],
        facet_wear=windowed[:measures],
        facet_wear_parts=parts[:, :measures],
        facet_wear_all=last[:measures],
        cell_sums=windowed[measures:],
        cell_sums_all=last[measures:],
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
        max_overlap=float(tally["largest_overlap"] / problem.radius),
        released=int(tally["placed"]),
        removed=int(tally["removed"]),
        energy=energy_balance(problem, state),
    )
