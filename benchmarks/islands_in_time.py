"""Draw when the particles of a small scene are stepped: python benchmarks/islands_in_time.py PNG.

The scene is a dozen particles on a small plate. After every lattice step the state of the engine
shows which particles are asleep, touch the plate, or touch each other.
"""

from __future__ import annotations

import itertools
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from cost import save_image
from speed import particle as limestone

from abradem import Setup
from abradem.dem.simulation import Engine
from abradem.dem.state import make_problem
from abradem.figures import speed as figures

ASLEEP, PLATE, PARTICLE, ABSENT = range(4)
NAMES = ("asleep", "plate", "particle")


def watched(case, setup):
    """Simulate a case and record the state of all particles after each step.

    Returns
    -------
    spans, contacts : DataFrame
        Arguments of `abradem.figures.speed.islands_figure`.
    """
    problem, schedule = make_problem(case, setup)
    engine = Engine(problem, schedule, "islands")
    steps = round(setup.duration / problem.dt)
    does = np.full((steps + 1, round(setup.duration * setup.number_rate) + 1), ABSENT, np.int8)
    open_pairs: dict[tuple[int, int], int] = {}
    contacts = []
    for step in range(1, steps + 1):
        engine.advance(step, None, None)
        state, live = engine.state, int(engine.state.tally["live"][0])
        particles = state.particles[:live]
        now = np.full(live, ASLEEP)
        now[particles["plate_stiffness"] != 0.0] = PLATE
        touching = set()
        for pair in state.pairs[: int(state.tally["pairs"][0])]:
            if pair["stiffness"] != 0.0:
                now[[pair["i"], pair["j"]]] = PARTICLE
                touching.add(tuple(int(particles["identity"][pair[end]]) for end in "ij"))
        present = particles["motion"] != 0
        does[step, particles["identity"][present]] = now[present]
        for pair in touching - open_pairs.keys():
            open_pairs[pair] = step
        for pair in open_pairs.keys() - touching:
            contacts.append((*pair, open_pairs.pop(pair), step))
    contacts += [(*pair, begin, steps) for pair, begin in open_pairs.items()]
    contacts = pd.DataFrame(contacts, columns=["particle", "partner", "begin", "end"])
    contacts[["begin", "end"]] *= problem.dt
    return _spans(does, problem.dt), contacts


def _spans(does: np.ndarray, dt: float) -> pd.DataFrame:
    rows = []
    for particle in range(does.shape[1]):
        track = does[:, particle]
        changes = np.flatnonzero(np.diff(track)) + 1
        edges = [0, *changes.tolist(), track.size]
        rows += [
            (particle, begin * dt, end * dt, NAMES[track[begin]])
            for begin, end in itertools.pairwise(edges)
            if track[begin] != ABSENT
        ]
    return pd.DataFrame(rows, columns=["particle", "begin", "end", "does"])


def main(path: Path) -> None:
    """Simulate the scene, print the shares of time in each state, and draw the figure."""
    setup = Setup(
        plate_length=0.1, plate_width=0.1, patch_length=0.05, patch_width=0.05, fall_height=0.1,
        removal_depth=0.03, mass_rate=None, number_rate=60.0, duration=0.25,
        time_step_fraction=0.2,
    )  # fmt: skip
    case = replace(limestone(0.01, 5.0), particle_velocity_y=-1.0, restitution=0.3)
    spans, contacts = watched(case, setup)
    spans["lasts"] = spans["end"] - spans["begin"]
    shares = spans.groupby("does")["lasts"].sum() / spans["lasts"].sum()
    print(", ".join(f"{name} {shares.get(name, 0.0):.2%}" for name in NAMES), "of the time")
    print(f"{len(contacts)} contacts between particles")
    save_image(figures.islands_figure(spans, contacts, zooms_of(contacts, setup.duration)), path)


def zooms_of(contacts: pd.DataFrame, duration: float):
    """Return the whole time, the 20 ms with most particle contacts, and the busiest 1 ms in it."""
    zooms = [(0.0, duration)]
    for width in (20e-3, 1e-3):
        low, high = zooms[-1]
        begins = contacts["begin"].to_numpy()
        begins = begins[(begins >= low) & (begins < high)]
        if begins.size == 0:
            break
        most = max(
            begins,
            key=lambda start: np.count_nonzero((begins >= start) & (begins < start + 0.8 * width)),
        )
        start = min(max(most - 0.1 * width, low), high - width)
        zooms.append((start, start + width))
    return zooms


if __name__ == "__main__":
    main(Path(sys.argv[1]))
