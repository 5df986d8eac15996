"""What each simulated second costs, here and elsewhere: python benchmarks/by_second.py [D].

Prints the computing time of this engine, LIGGGHTS and LAMMPS for each simulated second of a
scenario of `speed.py`, the particles present, and the ratios, for beds that fill for seconds. One
simulation of each; ``--together`` gives them a core each at the same time, so that all meet the
same other work. ``--pour`` keeps the releases in a file, or takes them from it; it is refused if
this engine releases another number of particles.
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from peers import PEERS, Pour, installed, pour, timed_run, unlike
from speed import SCENARIOS, Scenario, machine

from abradem.dem import Setup, simulate
from abradem.dem.state import make_problem
from abradem.dem.warm import warm


def kept_pour(path: Path | None, scenario: Scenario, setup: Setup) -> Pour:
    """Return the releases in a file, or make them and write the file if there is none."""
    if path is None or not path.exists():
        poured = pour(scenario.case, setup)
        if path is not None:
            np.savez(path, **{name: getattr(poured, name) for name in Pour._fields[1:]})
        return poured
    problem, _ = make_problem(scenario.case, setup)
    with np.load(path) as kept:
        values = [kept[name] for name in Pour._fields[2:]]
        end = int(kept["end"])
    steps = round(setup.duration / problem.dt)
    if not abs(end - steps) <= round(setup.sample_interval / problem.dt):
        raise SystemExit(f"{path} is a pour of {end} steps; this one has {steps}")
    return Pour(problem, end, *values)


def ours(scenario: Scenario, setup: Setup, poured: Pour) -> np.ndarray:
    """Return computing time (s) and mean number of particles in each second."""
    count = poured.second(poured.step[-1]) + 1
    ends = [time.process_time()]

    def progress(now: float) -> None:
        if count > len(ends) <= now + 1e-9:
            ends.append(time.process_time())
            print(f"{now:.3g} s simulated: {ends[-1] - ends[0]:.1f} s", flush=True)

    result = simulate(scenario.case, setup, progress=progress)
    ends.append(time.process_time())
    if result.released != poured.step.size:
        raise SystemExit(f"{result.released} releases instead of {poured.step.size} of the pour")
    seconds = np.array([poured.second(step) for step in np.unique(poured.step)[1:]])
    present = [poured.present[seconds == i].mean() for i in range(count)]
    return np.stack([np.diff(ends), present], axis=1)


def theirs(peer, scenario: Scenario, setup: Setup, poured: Pour) -> np.ndarray:
    """Return the same of a peer; print how it differs in its work."""
    case = scenario.case
    run = timed_run(peer, case, setup, poured, scenario.skin * case.particle_radius)
    print(
        f"{peer.name} {run.version}: {run.cpu:.1f} s, by second "
        f"{' '.join(f'{spent:.1f}' for spent in run.seconds[:, 0])}; particles "
        f"{run.present / poured.present.mean() - 1:+.1%}, kinetic energy "
        f"{run.energy / poured.energy.mean() - 1:+.1%}; {unlike(poured, run) or 'fair'}",
        flush=True,
    )
    return run.seconds


def table(found: dict[str, np.ndarray], dt: float) -> pd.DataFrame:
    """Return a line for each second and one for all.

    Parameters
    ----------
    found : dict of ndarray, shape (s, 2)
        Computing time (s) and mean number of particles in each second by code, this engine first.
    dt : float
        Time step, s.

    Returns
    -------
    pandas.DataFrame
        Of each code the computing time, the particles, and the time for one particle in one step
        (ns); the ratios of the times of the others to that of this engine.
    """
    columns = {}
    for name, seconds in found.items():
        spent = np.append(seconds[:, 0], seconds[:, 0].sum())
        present = np.append(seconds[:, 1], seconds[:, 1].mean())
        simulated = np.append(np.ones(len(seconds)), len(seconds))
        columns[f"{name}, s"] = spent
        columns[f"{name}, particles"] = present
        columns[f"{name}, ns"] = 1e9 * spent / (present * simulated / dt)
    lines = pd.DataFrame(columns, index=[*map(str, range(1, len(spent))), "all"])
    for name in list(found)[1:]:
        lines[f"{name}, ratio"] = lines[f"{name}, s"] / lines["abradem, s"]
    return lines


def main() -> None:
    """Print the table of a scenario."""
    parser = argparse.ArgumentParser(description="cost of each simulated second")
    parser.add_argument("scenario", nargs="?", choices=list(SCENARIOS), default="D")
    parser.add_argument("--seconds", type=float, help="duration instead of that of the scenario, s")
    parser.add_argument("--without", nargs="*", default=[], help="some of liggghts, lammps")
    parser.add_argument("--together", action="store_true", help="all at once, a core each")
    parser.add_argument("--pour", type=Path, help="file of the releases (.npz)")
    parser.add_argument("--table", type=Path, help="CSV file for the numbers")
    chosen = parser.parse_args()
    scenario = SCENARIOS[chosen.scenario]
    setup = replace(scenario.setup, duration=chosen.seconds or scenario.setup.duration)
    peers = [p for p in PEERS if p.name.lower() not in chosen.without and installed(p)]
    warm()
    print(machine(), flush=True)
    poured = kept_pour(chosen.pour, scenario, setup)
    with ThreadPoolExecutor(max(1, len(peers)) if chosen.together else 1) as pool:
        runs = {p.name: pool.submit(theirs, p, scenario, setup, poured) for p in peers}
        if not chosen.together:
            for run in runs.values():
                run.result()
        found = {"abradem": ours(scenario, setup, poured)}
        found |= {name: run.result() for name, run in runs.items()}
    lines = table(found, poured.problem.dt)
    print(lines.to_string(float_format="{:.4g}".format))
    if chosen.table:
        chosen.table.parent.mkdir(parents=True, exist_ok=True)
        lines.to_csv(chosen.table, index_label="second", float_format="%.6g")


if __name__ == "__main__":
    main()
