"""Cost of jets with this engine and with others: python benchmarks/speed.py [A M B D E F].

Prints `scenario, seconds of this engine, other, its seconds, ratio` for LIGGGHTS and LAMMPS, if
they are installed (benchmarks/README.md), and for the conventional stepping of this engine, which
gives bitwise equal results.

The time of this engine is a complete `simulate` call after a warm-up, with the three wear measures
on facets of 10 mm. The time of a peer is its run loop only, without wear (`peers`). Each uses one
core. This engine is timed before and after the others, and between them unless it takes long. The
shortest time of each counts.

`benchmarks/study.py` prints the cost of the simulations of a finished study.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pandas as pd
from peers import MARGIN, PEERS, Peer, Pour, installed, pour, timed_run, unlike

import abradem
from abradem.dem import Case, Setup, simulate
from abradem.dem.warm import warm

WIDE = {
    "plate_length": 0.5,
    "plate_width": 0.5,
    "patch_length": 0.2,
    "patch_width": 0.2,
    "fall_height": 0.5,
    "mass_rate": None,
    "number_rate": 500.0,
    "duration": 2.0,
    "time_step_fraction": 0.2,
}

CROWD = {
    "plate_length": 0.3,
    "plate_width": 0.3,
    "patch_length": 0.3,
    "patch_width": 0.3,
    "fall_height": 0.25,
    "mass_rate": 42.0,
    "duration": 1.0,
    "time_step_fraction": 0.2,
}


def particle(radius: float, plate_angle: float) -> Case:
    """Return a case with limestone-like particles on steel, released downwards at 3 m/s."""
    return Case(
        particle_shear_modulus=6e9,
        particle_poisson_ratio=0.25,
        particle_density=2500.0,
        equipment_shear_modulus=200e9 / 2.6,
        equipment_poisson_ratio=0.3,
        equipment_density=7800.0,
        restitution=0.5,
        rolling_friction=0.05,
        static_friction=0.45,
        archard_constant=1e-9,
        plate_angle=plate_angle,
        factory_angle=0.0,
        particle_radius=radius,
        particle_velocity_y=-3.0,
        seed=1,
    )


class Scenario(NamedTuple):
    """A jet, its description, and the target ratio of speeds of this engine and the fastest peer.

    ``skin`` is the reach of the pair lists of the peers beyond contact, in radii: the fastest of
    0.5, 1 and 2. ``rounds`` is the number of timings of each other code.
    """

    case: Case
    setup: Setup
    meaning: str
    target: float
    skin: float
    rounds: int = 3


SCENARIOS = {
    "A": Scenario(
        particle(0.01, 45.0),
        Setup(**WIDE),
        "dilute jet, 45 degrees, 500 particles a second",
        120.0,
        2.0,
    ),
    "M": Scenario(particle(0.01, 20.0), Setup(**WIDE), "the same, 20 degrees", 22.0, 2.0),
    "B": Scenario(
        particle(0.01, 0.0),
        Setup(**WIDE),
        "the same, level: particles stay on the plate",
        5.5,
        1.0,
    ),
    "D": Scenario(
        particle(0.005, 0.0),
        Setup(duration=5.0, time_step_fraction=0.2),
        "5 mm particles, level, 4 kg/s: a bed",
        3.5,
        1.0,
        rounds=1,
    ),
    "E": Scenario(
        particle(0.01, 35.0),
        Setup(**CROWD),
        "crowded jet, 35 degrees, 42 kg/s",
        7.0,
        0.5,
    ),
    "F": Scenario(particle(0.01, 10.0), Setup(**CROWD), "the same, 10 degrees", 5.0, 0.5),
}

BUSY = 0.9
"""Share of a core below which a run counts as disturbed by other processes."""


LONG = 20.0
"""This engine is timed again between the others if it takes less than this time, s."""


class Clock(NamedTuple):
    """Wall time and computing time, s."""

    wall: float
    cpu: float


def timed(case: Case, setup: Setup, releases=None):
    """Return the time of one `simulate` call and its result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = simulate(case, setup, releases)
    return Clock(time.perf_counter() - wall, time.process_time() - cpu), result


def repeated(case: Case, setup: Setup, releases=None):
    """Return the times of `simulate` calls repeated for a second, and a result."""
    spent, result = timed(case, setup, releases)
    times = [spent]
    while sum(one.wall for one in times) < 1.0:
        times.append(timed(case, setup, releases)[0])
    return times, result


def machine() -> str:
    """Return processor and versions in one line."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        model = names[0].split(":", 1)[1].strip() if names else model
    return (
        f"{model}, {os.cpu_count()} cores; abradem {abradem.__version__}, "
        f"Python {platform.python_version()}, numba {numba.__version__}"
    )


SYNCHRONOUS = Peer("synchronous", "", None)
"""Conventional stepping of this engine, compared like the other codes."""


def measure(scenario: Scenario, setup: Setup, poured: Pour, rounds: int, others):
    """Return the times of this engine, and the times and remarks of the others by name."""
    case, theirs, remarks = scenario.case, {}, {}
    ours, result = repeated(case, setup)
    for i, other in enumerate([*others] * rounds):
        if i > 0 and ours[-1].wall < LONG:
            ours += repeated(case, setup)[0]
        if other is SYNCHRONOUS:
            spent, same = timed(case, replace(setup, stepping="synchronous"))
            if not np.array_equal(result.worn, same.worn):
                raise SystemExit("the two steppings do not give bitwise equal results")
            remarks[other.name] = "bitwise equal"
        else:
            run = timed_run(other, case, setup, poured, scenario.skin * case.particle_radius)
            spent = Clock(run.wall, run.cpu)
            remarks[other.name] = unlike(poured, run) or (
                f"particles {run.present / poured.present.mean() - 1:+.1%}, "
                f"kinetic energy {run.energy / poured.energy.mean() - 1:+.1%}"
            )
        theirs.setdefault(other.name, []).append(spent)
    ours += repeated(case, setup)[0]
    return ours, theirs, remarks


def compare(name: str, seconds: float | None, rounds: int | None, clock: str, others) -> list[dict]:
    """Time a scenario with this engine and with others, print a line each, return the rows."""
    scenario = SCENARIOS[name]
    setup = scenario.setup if seconds is None else replace(scenario.setup, duration=seconds)
    poured = pour(scenario.case, setup)
    print(
        f"{name}: {scenario.meaning}; {poured.step.size} particles, {poured.end} steps of "
        f"{poured.problem.dt:.3g} s, {poured.present.mean():.0f} particles present on average",
        flush=True,
    )
    ours, theirs, remarks = measure(scenario, setup, poured, rounds or scenario.rounds, others)
    best = min(getattr(one, clock) for one in ours)
    rows = []
    for other, runs in theirs.items():
        spent = min(getattr(one, clock) for one in runs)
        print(
            f"{name} {best:9.3f} s   {other:11s} {spent:9.3f} s {spent / best:8.1f}   "
            f"{remarks[other]}",
            flush=True,
        )
        rows.append(
            {"scenario": name, "duration": setup.duration, "ours": best, "other": other,
             "theirs": spent, "ratio": spent / best, "clock": clock}
        )  # fmt: skip
    peers = [row for row in rows if row["other"] != SYNCHRONOUS.name]
    if peers:
        fastest = min(peers, key=lambda row: row["theirs"])
        print(f"{name}   {fastest['ratio']:.0f} times faster than {fastest['other']}; "
              f"target: {scenario.target:g}")  # fmt: skip
    everything = [ours, *theirs.values()]
    if clock == "wall" and any(
        max(one.cpu / one.wall for one in runs) < BUSY for runs in everything
    ):
        print(f"{name}   other work disturbed these timings; --clock cpu is less affected")
    return rows


def main() -> None:
    """Print the lines of all scenarios."""
    parser = argparse.ArgumentParser(description="compare the speed of this engine with others")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="some of A, M, B, D, E, F")
    parser.add_argument("--seconds", type=float, help="duration instead of that of the scenario, s")
    parser.add_argument("--rounds", type=int, help="number of timings of each other code")
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall")
    parser.add_argument(
        "--without", nargs="*", default=[], help="some of liggghts, lammps, synchronous"
    )
    parser.add_argument("--table", type=Path, help="CSV file for the numbers")
    chosen = parser.parse_args()
    unknown = [name for name in chosen.scenarios if name not in SCENARIOS]
    if unknown:
        parser.error(f"scenario {unknown[0]!r} is unknown; allowed: {', '.join(SCENARIOS)}")
    others = []
    for peer in PEERS:
        if peer.name.lower() in chosen.without:
            continue
        if installed(peer):
            others.append(peer)
        else:
            print(f"{peer.name} is not installed: see benchmarks/README.md")
    if "synchronous" not in chosen.without:
        others.append(SYNCHRONOUS)
    warm()
    print(machine())
    print(f"{chosen.clock} seconds; a fair peer differs by at most {MARGIN:.0%} in its particles")
    rows = []
    for name in chosen.scenarios or SCENARIOS:
        rows += compare(name, chosen.seconds, chosen.rounds, chosen.clock, others)
    if chosen.table:
        chosen.table.parent.mkdir(parents=True, exist_ok=True)
        pd.DataFrame(rows).to_csv(chosen.table, index=False, float_format="%.6g")


if __name__ == "__main__":
    main()
