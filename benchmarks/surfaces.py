"""Cost of a triangulated surface beside the plate: python benchmarks/surfaces.py [A M B E].

The jets of `speed` fall on the plate, on the same rectangle cut into triangles, and on a curved
chute as wide as the plate. Prints `scenario, surface, triangles, seconds of computing, ratio to the
plate`. All are timed in turn within one process, so that other work disturbs them alike, and the
shortest time of each counts. The plates give the same motion but for rounding; the chute is other
work, and its ratio tells the order of what a chute costs.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from speed import SCENARIOS, machine

from abradem.dem import Case, Setup, simulate
from abradem.dem.surface import Surface
from abradem.dem.warm import warm
from abradem.verification.surface_scenes import cut_plane, extruded

CUTS = {"2 triangles": (1, 1), "200 triangles": (10, 10), "1800 triangles": (30, 30)}
CHUTE_FACETS, CHUTE_STRIPS = 13, 8


def curved_chute(length: float, width: float) -> Surface:
    """Return a chute of two plates and an arc of 35 deg, of 208 triangles, about the origin."""
    slopes = np.radians(np.linspace(45.0, 10.0, CHUTE_FACETS))
    step = length / CHUTE_FACETS
    corners = np.cumsum(
        np.vstack([[0.0, 0.0], np.stack([step * np.cos(slopes), -step * np.sin(slopes)], axis=1)]),
        axis=0,
    )
    return extruded(corners - corners[CHUTE_FACETS // 2], width, CHUTE_STRIPS)


def surfaces(case: Case, setup: Setup) -> dict[str, Surface | None]:
    """Return the surfaces under the jet of a scenario; None is the plate."""
    length, width = setup.plate_length, setup.plate_width
    cut = {
        words: cut_plane(length, width, case.plate_angle, cells) for words, cells in CUTS.items()
    }
    return {"plate": None, **cut, "chute": curved_chute(length, width)}


def seconds(case: Case, setup: Setup) -> float:
    """Return the time of computing of one `simulate` call, s."""
    begin = time.process_time()
    result = simulate(case, setup)
    spent = time.process_time() - begin
    if result.status != "ok":
        raise RuntimeError(f"a scenario ended early: {result.status}")
    return spent


def compare(name: str, duration: float | None, rounds: int) -> list[dict]:
    """Print the lines of a scenario and return them."""
    case, setup = SCENARIOS[name].case, SCENARIOS[name].setup
    if duration is not None:
        setup = replace(setup, duration=duration)
    lain = surfaces(case, setup)
    times: dict[str, list[float]] = {words: [] for words in lain}
    for _ in range(rounds):
        for words, surface in lain.items():
            times[words].append(seconds(case, replace(setup, surface=surface)))
    rows = []
    for words, surface in lain.items():
        spent, ratio = min(times[words]), min(times[words]) / min(times["plate"])
        triangles = 0 if surface is None else len(surface.triangles)
        print(f"{name}   {words:15s} {triangles:6d} {spent:9.4f} s {ratio:7.2f}", flush=True)
        rows.append(
            {"scenario": name, "surface": words, "triangles": triangles, "seconds": spent,
             "ratio": ratio, "duration": setup.duration}
        )  # fmt: skip
    return rows


def main() -> None:
    """Print the lines of all scenarios."""
    parser = argparse.ArgumentParser(description="cost of surfaces beside the plate")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="some of A, M, B, E")
    parser.add_argument("--seconds", type=float, help="duration instead of that of the scenario, s")
    parser.add_argument("--rounds", type=int, default=3, help="number of timings of each")
    parser.add_argument("--table", type=Path, help="CSV file for the numbers")
    chosen = parser.parse_args()
    unknown = [name for name in chosen.scenarios if name not in SCENARIOS]
    if unknown:
        parser.error(f"scenario {unknown[0]!r} is unknown; allowed: {', '.join(SCENARIOS)}")
    warm()
    print(machine())
    print("seconds of computing, the least of each")
    rows = []
    for name in chosen.scenarios or ("A", "M", "B", "E"):
        rows += compare(name, chosen.seconds, chosen.rounds)
    if chosen.table:
        chosen.table.parent.mkdir(parents=True, exist_ok=True)
        pd.DataFrame(rows).to_csv(chosen.table, index=False, float_format="%.6g")


if __name__ == "__main__":
    main()
