"""Cost of a step of a crowd: python benchmarks/crowd.py results/large 7559 --after 3.

Simulates the given number of seconds of a case of a study, then times the same steps repeatedly
from that state. The shortest time is the cost of a step of the bed, without the time to form it.
"""

from __future__ import annotations

import argparse
import time
from copy import deepcopy
from pathlib import Path

import numpy as np

from abradem.cli.main import find_case
from abradem.config import read_config, setup_dict
from abradem.dem.model import Case, Setup
from abradem.dem.simulation import Engine
from abradem.dem.state import DONE, GONE, make_problem

STEPS, ROUNDS = 5000, 5


def crowd_after(study: Path, case: int, seconds: float) -> Engine:
    """Return the engine of a case of a study, advanced to a simulated time."""
    setup = Setup.from_dict(setup_dict(read_config(study / "config.yaml")))
    problem, schedule = make_problem(Case.from_row(find_case(study, case)), setup)
    engine = Engine(problem, schedule, setup.stepping)
    outcome = engine.advance(round(seconds / problem.dt))
    if outcome != DONE:
        raise SystemExit(f"case {case} ended before {seconds:g} s: {outcome}")
    return engine


def seconds_per_step(engine: Engine, steps: int) -> float:
    """Return the computing time of a step from the current state, which is not changed, s."""
    copy = deepcopy(engine)
    start = int(copy.state.tally["step"][0])
    began = time.process_time()
    if copy.advance(start + steps) != DONE:
        raise SystemExit("the case ends during the timed steps; use a smaller --after")
    return (time.process_time() - began) / steps


def main() -> None:
    """Print the size of the crowd and the cost of a step."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("study", type=Path, help="folder with config.yaml and cases/")
    parser.add_argument("case", type=int, help="number of the case")
    parser.add_argument(
        "--after", type=float, required=True, help="simulated time before the timing, s"
    )
    chosen = parser.parse_args()
    engine = crowd_after(chosen.study, chosen.case, chosen.after)
    best = min(seconds_per_step(engine, STEPS) for _ in range(ROUNDS))
    tally = engine.state.tally[0]
    particles = engine.state.particles[: tally["live"]]
    present = np.count_nonzero(particles["motion"] != GONE)
    print(
        f"case {chosen.case} after {chosen.after:g} s: {present} particles, "
        f"{np.count_nonzero(particles['plate_stiffness'])} on the plate, "
        f"{np.count_nonzero(engine.state.pairs['stiffness'][: tally['pairs']])} contacts between "
        f"particles of {tally['pairs']} pairs listed"
    )
    print(f"{1e6 * best:.1f} us per step, {1e9 * best / present:.1f} ns per particle")


if __name__ == "__main__":
    main()
