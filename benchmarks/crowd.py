"""Cost of a step of a crowd: python benchmarks/crowd.py results/large 7559 --after 3.

Simulates the given number of seconds of a case of a study, or of a scenario of `speed.py`
(``crowd.py D --after 2``), then times the same steps repeatedly from that state. The shortest time
is the cost of a step of the bed, without the time to form it. With ``--peers``, LIGGGHTS and LAMMPS
step the same bed: they get the places and velocities of its particles, without spins and without
what contacts remember.
"""

from __future__ import annotations

import argparse
import time
from copy import deepcopy
from pathlib import Path

import numpy as np
from peers import PEERS, Pour, installed, kinetic_energy, timed_run
from speed import SCENARIOS

from abradem.cli.simulate import find_case
from abradem.config import read_config, setup_dict
from abradem.dem.model import Case, Setup
from abradem.dem.simulation import Engine
from abradem.dem.state import DONE, FLYING, GONE, TOUCHING, make_problem

STEPS, ROUNDS, PEER_ROUNDS = 5000, 5, 2
USUAL_SKIN = 1.0
"""Reach of the pair lists of other codes beyond contact for cases of studies, radii."""


def chosen_case(name: str, number: int | None) -> tuple[Case, Setup]:
    """Return a scenario, or a case of the study in a folder."""
    if number is None:
        if name not in SCENARIOS:
            raise SystemExit(f"scenario {name!r} is unknown; allowed: {', '.join(SCENARIOS)}")
        return SCENARIOS[name].case, SCENARIOS[name].setup
    setup = Setup.from_dict(setup_dict(read_config(Path(name, "config.yaml"))))
    return Case.from_row(find_case(Path(name), number)), setup


def crowd_after(case: Case, setup: Setup, seconds: float) -> Engine:
    """Return the engine of a case, advanced to a simulated time."""
    problem, schedule = make_problem(case, setup)
    engine = Engine(problem, schedule, setup.stepping)
    outcome = engine.advance(round(seconds / problem.dt))
    if outcome != DONE:
        raise SystemExit(f"the case ended before {seconds:g} s: {outcome}")
    return engine


def seconds_per_step(engine: Engine, steps: int) -> float:
    """Return the computing time of a step from the current state, which is not changed, s."""
    copy = deepcopy(engine)
    start = int(copy.state.tally["step"][0])
    began = time.process_time()
    if copy.advance(start + steps) != DONE:
        raise SystemExit("the case ends during the timed steps; use a smaller --after")
    return (time.process_time() - began) / steps


def still(engine: Engine, steps: int) -> Pour:
    """Return the particles of a state as releases at once, for ``steps`` steps."""
    step = int(engine.state.tally["step"][0])
    particles = engine.state.particles[: int(engine.state.tally["live"][0])]
    particles = particles[particles["motion"] != GONE]
    flown = np.where(particles["motion"] == FLYING, step - particles["anchor_step"], 0)
    fall = engine.problem.gravity * engine.problem.dt * flown
    place = np.stack([particles[axis] for axis in "xyz"], axis=1)
    velocity = np.stack([particles["vx"], particles["vy"] - fall, particles["vz"]], axis=1)
    energy = kinetic_energy(engine.problem, particles, step)
    return Pour(
        engine.problem, steps, np.zeros(len(place), dtype=int), place, velocity,
        np.array([len(place)]), np.array([energy]), place.min(axis=0), place.max(axis=0),
    )  # fmt: skip


def main() -> None:
    """Print the size of the crowd and the cost of a step."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("study", help="folder with config.yaml and cases/, or a scenario: D")
    parser.add_argument("case", type=int, nargs="?", help="number of the case of the study")
    parser.add_argument(
        "--after", type=float, required=True, help="simulated time before the timing, s"
    )
    parser.add_argument("--peers", action="store_true", help="time the same bed with other codes")
    chosen = parser.parse_args()
    case, setup = chosen_case(chosen.study, chosen.case)
    engine = crowd_after(case, setup, chosen.after)
    best = min(seconds_per_step(engine, STEPS) for _ in range(ROUNDS))
    name = chosen.study if chosen.case is None else f"case {chosen.case}"
    tally = engine.state.tally[0]
    particles = engine.state.particles[: tally["live"]]
    present = np.count_nonzero(particles["motion"] != GONE)
    print(
        f"{name} after {chosen.after:g} s: {present} particles, "
        f"{np.count_nonzero(particles['motion'] == TOUCHING)} touch something, "
        f"{np.count_nonzero(particles['plate_stiffness'])} on the plate, "
        f"{np.count_nonzero(engine.state.pairs['stiffness'][: tally['pairs']])} contacts between "
        f"particles of {tally['pairs']} pairs listed"
    )
    print(f"{1e6 * best:.1f} us per step, {1e9 * best / present:.1f} ns per particle", flush=True)
    skin = SCENARIOS[chosen.study].skin if chosen.case is None else USUAL_SKIN
    poured = still(engine, STEPS)
    for peer in PEERS if chosen.peers else ():
        if not installed(peer):
            print(f"{peer.name} is not installed: see benchmarks/README.md")
            continue
        runs = [
            timed_run(peer, case, setup, poured, skin * case.particle_radius)
            for _ in range(PEER_ROUNDS)
        ]
        each = min(run.cpu for run in runs) / STEPS
        print(
            f"{peer.name} {runs[0].version}: {1e6 * each:.1f} us per step, "
            f"{1e9 * each / present:.1f} ns per particle, {each / best:.2f} times ours; "
            f"{runs[0].present:.0f} particles at the end"
        )


if __name__ == "__main__":
    main()
