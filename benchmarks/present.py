"""Cost of a step against the particles present: python benchmarks/present.py.

A hundred particles lie on the plate, and others fly without meeting anything: they rise and fall
beside the plate, as far apart as in a jet. So the number of contacts is the same in all rows.
"""

from __future__ import annotations

import argparse
import time
from copy import deepcopy

import numpy as np
from speed import machine, particle

from abradem import Setup
from abradem.dem.simulation import Engine
from abradem.dem.state import DONE, TOUCHING, make_problem

RADIUS = 0.01
LYING = 100
STEPS, ROUNDS = 5000, 5
FLYING = (0, 100, 300, 1000, 3000, 10_000, 30_000)
SETTLING = 20_000
"""Steps until the lying particles are at rest."""


def scene(flying: int, stepping: str) -> Engine:
    """Return the engine after `SETTLING` steps with ``flying`` particles in the air."""
    setup = Setup(plate_length=0.5, plate_width=0.5, removal_depth=50.0, time_step_fraction=0.2)
    i, k = (index.ravel() - 4.5 for index in np.indices((10, 10)))
    lying = np.stack([0.04 * i, np.full(LYING, RADIUS), 0.04 * k], axis=1)
    n = np.arange(flying)
    wide = 10
    # Rows of 10 x 10 beside the plate, one over the other, 5 radii apart.
    beside = np.stack(
        [1.0 + 0.05 * (n % wide), 0.05 * (n // wide**2), 0.05 * (n // wide % wide)], axis=1
    )
    places = np.concatenate([lying, beside])
    speeds = np.zeros_like(places)
    # All rise and fall alike, except for slow differences that bring none together.
    speeds[LYING:, 1] = 2.0 + 1e-3 * beside[:, 1]
    case = particle(RADIUS, 0.0)
    problem, schedule = make_problem(case, setup, (np.zeros(len(places)), places, speeds))
    engine = Engine(problem, schedule, stepping)
    if engine.advance(SETTLING) != DONE:
        raise SystemExit("the scene ended early")
    return engine


def seconds_per_step(engine: Engine) -> float:
    """Return the computing time of a step from the current state, which is not changed, s."""
    best = np.inf
    for _ in range(ROUNDS):
        copy = deepcopy(engine)
        start = int(copy.state.tally["step"][0])
        began = time.process_time()
        copy.advance(start + STEPS)
        best = min(best, (time.process_time() - began) / STEPS)
    return best


def main() -> None:
    """Print a line for each number of particles that fly."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--most", type=int, default=FLYING[-1], help="largest number in the air")
    most = parser.parse_args().most
    print(machine())
    print(f"{'flying':>8} {'touching':>9} {'islands, us a step':>19} {'synchronous':>12}")
    for flying in (number for number in FLYING if number <= most):
        costs, touching = [], 0
        for stepping in ("islands", "synchronous"):
            engine = scene(flying, stepping)
            touching = np.count_nonzero(engine.state.particles["motion"] == TOUCHING)
            costs.append(1e6 * seconds_per_step(engine))
        print(f"{flying:8d} {touching:9d} {costs[0]:19.2f} {costs[1]:12.2f}", flush=True)


if __name__ == "__main__":
    main()
