"""Cost of a jet by this engine and by others: python benchmarks/speed.py [A M B D].

Prints `scenario, ours in s, other, its seconds, ratio` for LIGGGHTS and LAMMPS, if they are
installed (benchmarks/README.md), and for our own conventional stepping, which gives the same bits.

Ours is a whole `simulate` call after a warm-up, with its three wear measures on facets of 10 mm;
that of a peer its run loop alone, without wear (`peers`). One core each. Ours is timed before and
after the others, and between them unless it takes long; of each the shortest time counts.

`benchmarks/study.py` tells what the simulations of a finished study cost.
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
from abradem import Case, Setup, simulate
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


def particle(radius: float, plate_angle: float) -> Case:
    """Limestone-like particles on steel, thrown down at 3 m/s."""
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
    """A jet, what it is like, and how many times faster than the fastest peer we want to be.

    ``skin`` is the reach of the peers' pair lists beyond contact in radii, the fastest of 0.5, 1
    and 2; ``rounds`` how often each other is timed.
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
        100.0,
        2.0,
    ),
    "M": Scenario(particle(0.01, 20.0), Setup(**WIDE), "the same, 20 degrees", 40.0, 2.0),
    "B": Scenario(
        particle(0.01, 0.0),
        Setup(**WIDE),
        "the same, level: particles stay on the plate",
        10.0,
        1.0,
    ),
    "D": Scenario(
        particle(0.005, 0.0),
        Setup(duration=5.0, time_step_fraction=0.2),
        "5 mm particles, level, 4 kg/s: a bed",
        5.0,
        1.0,
        rounds=1,
    ),
}

BUSY = 0.9
"""Share of a core below which a run was disturbed by others."""


LONG = 20.0
"""Ours is timed again between the others if it takes less than so many seconds."""


class Clock(NamedTuple):
    """Seconds on the wall, and of computing, that something took."""

    wall: float
    cpu: float


def timed(case: Case, setup: Setup, releases=None):
    """Return the time of one `simulate` call and its result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = simulate(case, setup, releases)
    return Clock(time.perf_counter() - wall, time.process_time() - cpu), result


def repeated(case: Case, setup: Setup, releases=None):
    """Return the times of as many `simulate` calls as fill a second, and a result."""
    spent, result = timed(case, setup, releases)
    times = [spent]
    while sum(one.wall for one in times) < 1.0:
        times.append(timed(case, setup, releases)[0])
    return times, result


def machine() -> str:
    """Processor and versions, in a line."""
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
"""Our own conventional stepping, among the others."""


def measure(scenario: Scenario, setup: Setup, poured: Pour, rounds: int, others):
    """Return the times of ours, and by the name of each other its times and what to remark."""
    case, theirs, remarks = scenario.case, {}, {}
    ours, result = repeated(case, setup)
    for i, other in enumerate([*others] * rounds):
        if i > 0 and ours[-1].wall < LONG:
            ours += repeated(case, setup)[0]
        if other is SYNCHRONOUS:
            spent, same = timed(case, replace(setup, stepping="synchronous"))
            if not np.array_equal(result.worn, same.worn):
                raise SystemExit("the two steppings do not give the same bits")
            remarks[other.name] = "the same bits"
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
    """Time a scenario by us and by others, print a line for each, and return the rows."""
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
              f"wanted: {scenario.target:g}")  # fmt: skip
    everything = [ours, *theirs.values()]
    if clock == "wall" and any(
        max(one.cpu / one.wall for one in runs) < BUSY for runs in everything
    ):
        print(f"{name}   other work disturbed these timings; --clock cpu is less affected")
    return rows


def main() -> None:
    """Print the lines of all scenarios."""
    parser = argparse.ArgumentParser(description="time this engine against others")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="of A, M, B, D")
    parser.add_argument("--seconds", type=float, help="simulate so long, whatever the scenario")
    parser.add_argument("--rounds", type=int, help="how often to time each other")
    parser.add_argument("--clock", choices=("wall", "cpu"), default="wall")
    parser.add_argument("--without", nargs="*", default=[], help="of liggghts, lammps, synchronous")
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
    print(f"{chosen.clock} seconds; peers may differ from us by {MARGIN:.0%} in what they simulate")
    rows = []
    for name in chosen.scenarios or SCENARIOS:
        rows += compare(name, chosen.seconds, chosen.rounds, chosen.clock, others)
    if chosen.table:
        chosen.table.parent.mkdir(parents=True, exist_ok=True)
        pd.DataFrame(rows).to_csv(chosen.table, index=False, float_format="%.6g")


if __name__ == "__main__":
    main()
