"""Cost of simulations, and the cost if only contacts took time.

    python benchmarks/cost.py results/benchmarks

writes ``counts.csv`` (cost over the particles present, of this engine and of installed peers),
``times.csv`` (cost over simulated time), ``rates.csv`` (steps of particles and contacts per
second, share of the limit), ``contact.csv`` (cost of one contact in one step) and their figures.
With ``--images``, small copies of the figures are written to a second folder.

The limit is the number of steps of particles in contact, of contacts with the plate and of contacts
between particles, each multiplied by its minimum cost. The minimum cost is measured with dozens of
particles that are all in contact and fit into the fastest cache of the processor.
"""

from __future__ import annotations

import argparse
import functools
import time
from dataclasses import replace
from pathlib import Path

import numba
import numpy as np
import pandas as pd
from peers import PEERS, installed, pour, timed_run
from speed import SCENARIOS, WIDE, machine, particle, repeated

from abradem.dem import Setup, simulate
from abradem.dem.state import GONE, TOUCHING
from abradem.dem.warm import warm
from abradem.figures import speed as figures
from abradem.figures import style
from abradem.store.files import replacing

RATES = (30.0, 100.0, 300.0, 1000.0, 3000.0)
MOST_FOR_PEERS = 1000.0
"""Largest feed for peers, particles per second; they take minutes for more."""

COUNT_SECONDS = 1.0
LOOKS = 10_000
"""Number of times that the contacts of a scenario are counted."""

IMAGE_DPI = 130

STEPPINGS = ("islands", "synchronous")


class Census:
    """Recorder for `abradem.simulate` that counts particles and contacts at regular times."""

    def __init__(self, interval: float):
        self.interval = interval
        self.rows: list[tuple[int, int, int, int]] = []

    def record(self, time: float, problem, state) -> None:
        """Count; called by the engine."""
        particles = state.particles[: int(state.tally["live"][0])]
        present = particles[particles["motion"] != GONE]
        pairs = state.pairs[: int(state.tally["pairs"][0])]
        self.rows.append(
            (
                present.size,
                np.count_nonzero(present["motion"] == TOUCHING),
                np.count_nonzero(present["plate_stiffness"]),
                np.count_nonzero(pairs["stiffness"]),
            )
        )

    def means(self) -> dict:
        """Return the mean numbers of particles present and in contact, plate contacts and pairs."""
        names = ("particles", "touching", "plate", "pairs")
        return dict(zip(names, np.mean(self.rows, axis=0).tolist(), strict=True))


def lasting(setup: Setup, seconds: float | None) -> Setup:
    """Return the set-up, with another duration if ``seconds`` is given."""
    return setup if seconds is None else replace(setup, duration=seconds)


def shortest(case, setup, releases=None) -> float:
    """Return the shortest computing time of `simulate` in calls repeated for a second, s."""
    return min(spent.cpu for spent in repeated(case, setup, releases)[0])


def counts() -> pd.DataFrame:
    """Return the cost of a simulated second and the particles present, by feed, angle and code."""
    rows = []
    for angle in (45.0, 0.0):
        case = particle(0.01, angle)
        for rate in RATES:
            setup = Setup(**WIDE | {"number_rate": rate, "duration": COUNT_SECONDS})
            poured = pour(case, setup)
            costs = {name: shortest(case, replace(setup, stepping=name)) for name in STEPPINGS}
            for peer in PEERS:
                if installed(peer) and rate <= MOST_FOR_PEERS:
                    skin = (1.0 if angle == 0.0 else 2.0) * case.particle_radius
                    costs[peer.name] = timed_run(peer, case, setup, poured, skin).cpu
            rows += [
                {"plate_angle": angle, "number_rate": rate, "particles": poured.present.mean(),
                 "code": code, "cost": spent / COUNT_SECONDS}
                for code, spent in costs.items()
            ]  # fmt: skip
    return pd.DataFrame(rows)


def times(seconds: float | None) -> pd.DataFrame:
    """Return the computing time over the simulated time in one simulation of each scenario."""
    rows = []
    for name, scenario in SCENARIOS.items():
        start = time.process_time()

        def look(simulated, name=name, start=start):
            rows.append(
                {"scenario": name, "simulated": simulated, "spent": time.process_time() - start}
            )

        simulate(scenario.case, lasting(scenario.setup, seconds), progress=look)
    return pd.DataFrame(rows)


@functools.cache
def _three_cycles():
    @numba.njit
    def steps(x, count):
        # Shift, exclusive or, sum: a chain of three dependent operations of one cycle each.
        for _ in range(count):
            x = (x ^ (x >> np.uint64(7))) + np.uint64(0x9E3779B97F4A7C15)
        return x

    steps(np.uint64(1), 1)
    return steps


def clock_rate() -> float:
    """Return the processor cycles per second of computing."""
    count, best = 20_000_000, np.inf
    for _ in range(5):
        start = time.process_time()
        _three_cycles()(np.uint64(1), count)
        best = min(best, time.process_time() - start)
    return 3.0 * count / best


def touching_scene(kind: str):
    """Return case, set-up and releases of 64 particles in contact for the whole simulation.

    The step is so short that a contact lasts tens of thousands of steps. ``plate``: each particle
    touches only the plate; ``pairs``: 32 pairs collide; ``rows``: 8 rows of 8 particles are
    pressed together, with 56 contacts.
    """
    radius, dt, steps = 0.01, 1.5e-9, 20_000
    setup = Setup(
        plate_length=0.5, plate_width=0.5, mass_rate=None, number_rate=1.0, gravity=0.0,
        time_step=dt, sample_interval=steps * dt, duration=steps * dt,
    )  # fmt: skip
    i, k = (index.ravel() for index in np.indices((8, 8)))
    gap = 1e-10
    x, vx = 0.03 * i, np.zeros(64)
    z, vz = 0.03 * k, np.full(64, 0.5)
    y, vy = np.full(64, radius + gap), np.full(64, -1.0)
    if kind == "pairs":
        x = 0.06 * (i // 2) + (2.0 * radius + gap) * (i % 2)
        vx, vy, vz = 0.5 - i % 2, 0.2 * (i % 2), np.zeros(64)
    elif kind == "rows":
        x = (2.0 * radius + gap) * i
        vx, vy, vz = -1.0 * i, 0.4 * i, np.zeros(64)
    if kind != "plate":
        y = y + 0.1
    places = np.stack([x - x.mean(), y, z - z.mean()], axis=1)
    return particle(radius, 0.0), setup, (np.zeros(64), places, np.stack([vx, vy, vz], axis=1))


def contact_costs() -> dict:
    """Return the seconds of a step of a particle in contact, a plate contact and a pair contact.

    They are computed from the three scenes of `touching_scene` with the faster stepping.
    """
    step = {}
    for kind, contacts in (("plate", 64), ("pairs", 32), ("rows", 56)):
        case, setup, releases = touching_scene(kind)
        census = Census(setup.duration)
        simulate(case, setup, releases, recorder=census)
        if sum(census.rows[-1][2:]) != contacts:
            raise RuntimeError(f"scene {kind}: {census.rows[-1]} instead of {contacts} contacts")
        step[kind] = min(
            shortest(case, replace(setup, stepping=name), releases) for name in STEPPINGS
        ) / round(setup.duration / setup.time_step)
    pair = (step["rows"] - step["pairs"]) / (56 - 32)
    particle = (step["pairs"] - 32 * pair) / 64
    return {"particle": particle, "plate": step["plate"] / 64 - particle, "pair": pair}


def rates(costs: dict, seconds: float | None) -> pd.DataFrame:
    """Return steps per second of particles and contacts, and the share of the limit."""
    rows = []
    for name, scenario in SCENARIOS.items():
        setup = lasting(scenario.setup, seconds)
        census = Census(setup.duration / LOOKS)
        result = simulate(scenario.case, setup, recorder=census)
        steps = result.simulated_time / result.time_step
        mean = census.means()
        limit = steps * (
            mean["touching"] * costs["particle"]
            + mean["plate"] * costs["plate"]
            + mean["pairs"] * costs["pair"]
        )
        for stepping in STEPPINGS:
            spent = shortest(scenario.case, replace(setup, stepping=stepping))
            rows.append(
                {"scenario": name, "stepping": stepping, "seconds": spent,
                 "particle_steps": steps * mean["particles"] / spent,
                 "contact_steps": steps * (mean["plate"] + mean["pairs"]) / spent,
                 "limit_seconds": limit, "share_of_limit": limit / spent}
                | {f"mean_{key}": value for key, value in mean.items()}
            )  # fmt: skip
    return pd.DataFrame(rows)


def save_image(figure, path: Path) -> None:
    """Write a figure as a small PNG for the documentation."""
    with style.style(), replacing(path) as sink:
        figure.savefig(sink, format="png", dpi=IMAGE_DPI, metadata={"Software": None})


def main() -> None:
    """Measure the costs, write the tables and draw the figures."""
    parser = argparse.ArgumentParser(description="cost of simulations, as tables and figures")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--images", type=Path, help="folder for small copies of the figures")
    parser.add_argument("--seconds", type=float, help="duration of the scenarios, s")
    parser.add_argument("--draw", action="store_true", help="only draw the existing tables")
    chosen = parser.parse_args()
    folder = chosen.folder
    folder.mkdir(parents=True, exist_ok=True)
    if not chosen.draw:
        warm()
        print(machine(), flush=True)
        clock, costs = clock_rate(), contact_costs()
        one = pd.DataFrame(
            {"of": list(costs), "seconds": list(costs.values()),
             "cycles": [clock * seconds for seconds in costs.values()]}
        )  # fmt: skip
        print(f"clock {clock / 1e9:.2f} GHz\n{one.to_string(index=False)}", flush=True)
        found = rates(costs, chosen.seconds)
        print(found.to_string(index=False), flush=True)
        tables = {"contact": one, "rates": found, "times": times(chosen.seconds)}
        for name, table in (tables | {"counts": counts()}).items():
            table.to_csv(folder / f"{name}.csv", index=False, float_format="%.6g")
    read = {name: pd.read_csv(folder / f"{name}.csv") for name in ("counts", "times", "rates")}
    for name, figure in (
        ("cost", figures.cost_figure(read["counts"], read["times"])),
        ("rates", figures.rates_figure(read["rates"])),
    ):
        style.save(figure, folder / name)
        if chosen.images:
            save_image(figure, chosen.images / f"engine_{name}.png")


if __name__ == "__main__":
    main()
