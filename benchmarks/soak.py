"""Soak test of the engine on random cases: memory, guards and energy balance.

    python benchmarks/soak.py --minutes 60 --table results/benchmarks/soak.csv

Cases are drawn from the whole range of the physical limits, much wider than in a study: hard and
soft materials, e from 0.05 to 1, friction from 0, all angles, both steppings, all contact laws.
Each case must end with finite results or a status with a reason. For each case it is checked that
all numbers are finite, wear never decreases, the facets add up to the wear of the plate, and the
energy balance is satisfied (inserted energy is resident, removed or dissipated; none is gained).
The memory of the process must not grow until the end.
"""

from __future__ import annotations

import argparse
import bisect
import csv
import io
import math
import os
import resource
import sys
import time
from array import array
from collections import Counter
from pathlib import Path

import numpy as np

from abradem.dem import Case, Setup, simulate
from abradem.dem.model import NORMAL_LAWS, STEPPINGS, TANGENTIAL_DAMPINGS, ContactModel
from abradem.dem.samples import ENERGY_TOLERANCE
from abradem.quantities import SAMPLED
from abradem.store.files import replacing

MOST_GROWTH = 0.1
"""Largest relative growth of the memory from a tenth of the time to the end; some growth is allowed
because the allocator keeps the memory of the largest case."""

MOST_STEPS = 300_000
"""Largest number of steps of a case; another case is drawn instead of one with more, because a bed
of the hardest particles would take hours."""

COLUMNS = ("elapsed_s", "case_s", "simulated_s", "memory_mb", "status", "problems")


def draw(rng: np.random.Generator) -> tuple[Case, Setup]:
    """Return a random case within the physical limits and a short set-up."""
    values = {}
    for row in SAMPLED:
        low, high = row.limits
        # Moduli and the wear constant span decades.
        wide = low > 0.0 and high / low > 1e3
        between = math.exp(rng.uniform(math.log(low), math.log(high))) if wide else None
        values[row.name] = between if wide else rng.uniform(low, high)
        if rng.random() < 0.1:
            values[row.name] = rng.choice([low, high])
    values["particle_radius"] = math.exp(rng.uniform(math.log(4e-3), math.log(0.1)))
    values = {name: float(value) for name, value in values.items()}
    setup = Setup(
        mass_rate=None,
        number_rate=float(math.exp(rng.uniform(math.log(5.0), math.log(500.0)))),
        facet_size=0.03,
        stepping=str(rng.choice(STEPPINGS)),
        contact=ContactModel(
            normal=str(rng.choice(NORMAL_LAWS)),
            tangential_damping=str(rng.choice(TANGENTIAL_DAMPINGS)),
        ),
        time_step_fraction=float(rng.uniform(0.05, 0.2)),
        duration=float(rng.uniform(0.2, 1.0)),
    )
    return Case(**values, seed=int(rng.integers(2**63))), setup


def problems_of(result) -> list[str]:
    """Return the problems of a finished simulation."""
    found = []
    if not (np.isfinite(result.worn).all() and np.isfinite(result.facet_wear_all).all()):
        found.append("wear is not finite")
    elif (np.diff(result.worn[:, :2], axis=0) < 0.0).any():
        # Only total and sliding; friction can decrease because springs store and return energy.
        found.append("wear decreased")
    elif (
        not np.allclose(
            result.facet_wear_all.sum(axis=(1, 2)), result.worn[-1], rtol=1e-9, atol=1e-12
        )
        and result.status == "ok"
    ):
        found.append("the facets do not add up to the wear of the plate")
    balance = result.energy
    if result.status == "ok" and not all(map(math.isfinite, balance.values())):
        found.append("the energy balance is not finite")
    least = -ENERGY_TOLERANCE * abs(balance["inserted"])
    if result.status == "ok" and balance["dissipated"] < least:
        found.append(f"energy gained: {balance}")
    return found


def megabytes() -> float:
    """Return the current memory of this process, MB (the peak if the current is not available)."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def soak(minutes: float, seed: int, log) -> int:
    """Simulate random cases for a time, with a row of ``log`` for each; return an exit status."""
    rng = np.random.default_rng(seed)
    # Only two numbers per case are kept in memory, so that its growth is that of the engine.
    elapsed_s, memory_mb = array("d"), array("d")
    kinds, simulated_s, longest, bad = Counter(), 0.0, 0.0, 0
    began = time.monotonic()
    while (elapsed := time.monotonic() - began) < 60.0 * minutes:
        case, setup = draw(rng)
        step = setup.time_step_fraction * case.particle.rayleigh_time(case.particle_radius)
        if setup.duration / step > MOST_STEPS:
            continue
        start = time.monotonic()
        try:
            result = simulate(case, setup)
        except ValueError as refused:
            status, simulated, problems = f"refused: {refused}", 0.0, []
        else:
            status, simulated, problems = result.status, result.simulated_time, problems_of(result)
        for problem in problems:
            print(f"{problem}\n  {case}\n  {setup}", flush=True)
        seconds = time.monotonic() - start
        elapsed_s.append(elapsed)
        memory_mb.append(megabytes())
        kinds[status.split(":")[0].split(" of ")[0]] += 1
        simulated_s += simulated
        longest = max(longest, seconds)
        bad += bool(problems)
        log.writerow([elapsed, seconds, simulated, memory_mb[-1], status, "; ".join(problems)])

    print(f"{len(elapsed_s)} cases, {simulated_s:.0f} s simulated: {dict(kinds)}")
    tenth = bisect.bisect(elapsed_s, 0.1 * elapsed_s[-1])
    early, last, most = max(memory_mb[:tenth]), memory_mb[-1], max(memory_mb)
    growth = last / early - 1.0
    print(
        f"memory: {early:.0f} MB after a tenth of the time, {last:.0f} MB at the end "
        f"({100 * growth:+.1f} %), at most {most:.0f} MB"
    )
    print(f"longest case: {longest:.1f} s; cases with a problem: {bad}")
    return 1 if bad or growth > MOST_GROWTH else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--table", type=Path, help="CSV of all cases")
    options = parser.parse_args()
    if not options.table:
        with open(os.devnull, "w") as sink:
            return soak(options.minutes, options.seed, csv.writer(sink))
    with replacing(options.table) as sink:
        lines = io.TextIOWrapper(sink, encoding="utf-8", newline="")
        log = csv.writer(lines)
        log.writerow(COLUMNS)
        status = soak(options.minutes, options.seed, log)
        lines.flush()
        lines.detach()
    return status


if __name__ == "__main__":
    sys.exit(main())
