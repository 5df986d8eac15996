"""Wall time against the number of threads: python benchmarks/threads.py [D F] [--threads 1 2].

Prints `scenario, threads, seconds, ratio to the first number of threads` for scenarios of
`benchmarks/speed.py`, D for its first second. The numbers of threads take turns; the shortest time
of each counts. Results must have the same bits. Threads wait for each other in every step, so the
times mean something on a machine without other work alone; the share of a core that each thread
got is printed too.

With ``--after``, all begin from the state after that simulated time, which one thread computed, and
step it for 5000 steps: ``threads.py D --after 2`` measures a crowd without its time to form.
"""

from __future__ import annotations

import argparse
import time
from copy import deepcopy
from dataclasses import replace

import numpy as np
from crowd import STEPS, crowd_after
from speed import BUSY, SCENARIOS, Clock, machine

import abradem.dem
from abradem.dem import warm
from abradem.dem.model import MOST_THREADS
from abradem.dem.simulation import Engine
from abradem.dem.state import DONE, GONE, TOUCHING

FIRST_SECOND = {"D": 1.0}
"""Durations instead of those of the scenarios, s."""


def timed(case, setup, threads: int):
    """Return the time of one simulation and its result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = abradem.dem.simulate(case, setup, threads=threads)
    return Clock(time.perf_counter() - wall, time.process_time() - cpu), result


def compare(name: str, numbers: list[int], seconds: float | None, rounds: int) -> None:
    """Time a scenario with each number of threads, and print a line each."""
    scenario = SCENARIOS[name]
    setup = replace(
        scenario.setup,
        duration=seconds or FIRST_SECOND.get(name, scenario.setup.duration),
    )
    times: dict[int, list[Clock]] = {threads: [] for threads in numbers}
    first = None
    for threads in numbers * rounds:
        spent, result = timed(scenario.case, setup, threads)
        times[threads].append(spent)
        first = first or result
        for field in ("worn", "facet_wear_all", "present", "max_overlap"):
            if not np.array_equal(getattr(first, field), getattr(result, field)):
                raise SystemExit(f"{name}: {field} depends on the number of threads")
    least = {threads: min(runs) for threads, runs in times.items()}
    for threads, spent in least.items():
        busy = spent.cpu / spent.wall / threads
        print(
            f"{name}, {setup.duration:g} s   {threads:2d} threads {spent.wall:9.3f} s "
            f"{least[numbers[0]].wall / spent.wall:6.2f}   {busy:.0%} of a core each"
            + ("" if busy > BUSY or threads > 1 else ": other work disturbed this"),
            flush=True,
        )


def from_state(engine: Engine, threads: int) -> Engine:
    """Return a copy of an engine of one thread that goes on with any number of them."""
    copy = deepcopy(engine)
    if threads > 1:
        team = Engine(copy.problem, copy.schedule, "islands", None, threads)
        team.state, team.agenda = copy.state, copy.agenda
        team.agenda.clock["threads"] = threads
        return team
    return copy


def compare_steps(name: str, numbers: list[int], after: float, rounds: int) -> None:
    """Time the same steps of a crowd with each number of threads, and print a line each."""
    engine = crowd_after(SCENARIOS[name].case, SCENARIOS[name].setup, after)
    start = int(engine.state.tally["step"][0])
    particles = engine.state.particles[: int(engine.state.tally["live"][0])]
    touching = np.count_nonzero(particles["motion"] == TOUCHING)
    print(
        f"{name} after {after:g} s: {np.count_nonzero(particles['motion'] != GONE)} particles, "
        f"{touching} touch something",
        flush=True,
    )
    times: dict[int, list[Clock]] = {threads: [] for threads in numbers}
    first = None
    for threads in numbers * rounds:
        team = from_state(engine, threads)
        # The first steps make the pair list and share the particles among the threads.
        team.advance(start + STEPS // 10)
        wall, cpu = time.perf_counter(), time.process_time()
        if team.advance(start + STEPS // 10 + STEPS) != DONE:
            raise SystemExit(f"{name} ended during the timed steps")
        times[threads].append(Clock(time.perf_counter() - wall, time.process_time() - cpu))
        state = team.state.particles, team.state.facet_wear
        first = first or state
        if any(a.tobytes() != b.tobytes() for a, b in zip(first, state, strict=True)):
            raise SystemExit(f"{name}: the state depends on the number of threads")
    least = {threads: min(runs) for threads, runs in times.items()}
    for threads, spent in least.items():
        print(
            f"{threads:2d} threads {1e6 * spent.wall / STEPS:9.1f} us a step "
            f"{least[numbers[0]].wall / spent.wall:6.2f}   "
            f"{spent.cpu / spent.wall / threads:.0%} of a core each",
            flush=True,
        )


def main() -> None:
    """Print the lines of all scenarios."""
    parser = argparse.ArgumentParser(description="wall time against the number of threads")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="some of A, M, B, D, E, F")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--seconds", type=float, help="duration instead of that of the scenario, s")
    parser.add_argument("--rounds", type=int, default=3, help="number of timings of each")
    parser.add_argument("--after", type=float, help="only steps from this simulated time on, s")
    chosen = parser.parse_args()
    unknown = [name for name in chosen.scenarios if name not in SCENARIOS]
    if unknown:
        parser.error(f"scenario {unknown[0]!r} is unknown; allowed: {', '.join(SCENARIOS)}")
    if not all(1 <= threads <= MOST_THREADS for threads in chosen.threads):
        parser.error(f"threads {chosen.threads}; allowed: 1 to {MOST_THREADS}")
    warm.load("islands")
    if max(chosen.threads) > 1:
        warm.load("parallel")
    print(machine())
    for name in chosen.scenarios or ["D", "F"]:
        if chosen.after is None:
            compare(name, chosen.threads, chosen.seconds, chosen.rounds)
        else:
            compare_steps(name, chosen.threads, chosen.after, chosen.rounds)


if __name__ == "__main__":
    main()
