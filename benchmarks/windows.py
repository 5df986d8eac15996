"""Effect of shorter windows on the wear rates of a study, and of longer simulations on its beds.

    python benchmarks/windows.py results/tenfold              # on stored records, seconds
    python benchmarks/windows.py results/tenfold --beds 5     # new simulations of 20 s, an hour

The first command applies the stop rule (docs/method.md) to the stored series of a study with
windows of 1, 2 and 3 s, and compares the rates with those of its own window. The second one
simulates beds, small particles on nearly level plates, for `LONG` seconds, and compares the rate at
which the rule stops with the mean of the second half.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from abradem.config import load_config, setup_dict
from abradem.dem import simulate
from abradem.dem.model import Case, Setup
from abradem.dem.steady import batch_means
from abradem.dem.stop import StopRule
from abradem.elastic import sphere_mass
from abradem.store.tables import read_table

SHORTER = (1.0, 2.0, 3.0)
LONG = 20.0
FLAT, SMALL = 12.0, 0.012
"""Plate angle, deg, and radius, m, below which beds form."""


def stopped_rate(time, worn, present, setup, release_interval: float):
    """Return the rate, its relative standard error and the time at which the stop rule ends.

    All are nan if the record is too short for the rule to end.
    """
    if len(time) < 2:
        return math.nan, math.nan, math.nan
    rule = StopRule(setup, time[1] - time[0], release_interval)
    while rule.next_look < len(time):
        past = slice(rule.next_look + 1)
        if rule.ends(time[past], worn[past], present[past]):
            steady = rule.steady(time[past], worn[past], present[past])
            return steady.rate, steady.relative_stderr, time[past][-1]
    return math.nan, math.nan, math.nan


def release_interval(cases, setup):
    """Return the time between two releases, s, of a case or of a table of cases."""
    if setup.number_rate is not None:
        return 1.0 / setup.number_rate + 0.0 * cases["particle_radius"]
    return sphere_mass(cases["particle_radius"], cases["particle_density"]) / setup.mass_rate


def replayed(folder: Path, setup) -> pd.DataFrame:
    """Return relative changes of the rates of all cases of a study with shorter windows."""
    cases = read_table(folder / "cases.parquet").set_index("case_id")
    intervals = release_interval(cases, setup)
    rows = []
    for path in sorted((folder / "series").glob("*.parquet")):
        columns = ("time", "worn_total", "particles_present")
        for case_id, record in read_table(path, ("case_id", *columns)).groupby("case_id"):
            arrays = [record[column].to_numpy() for column in columns]
            interval = intervals[case_id]
            rate = stopped_rate(*arrays, setup, interval)[0]
            row = {"case_id": case_id}
            for window in SHORTER:
                shorter = stopped_rate(*arrays, replace(setup, window=window), interval)[0]
                row[window] = shorter / rate - 1.0
            rows.append(row)
    return pd.DataFrame(rows).set_index("case_id").join(cases)


def beds(folder: Path, setup, number: int) -> None:
    """Simulate some beds of the study for a long time; print a line for each and a summary."""
    cases = pd.concat(read_table(path) for path in sorted((folder / "cases").glob("*.parquet")))
    flat = cases[(cases["plate_angle"] < 7.0) & cases["particle_radius"].between(0.007, SMALL)]
    off = []
    for row in flat.head(number).to_dict("records"):
        result = simulate(Case.from_row(row), replace(setup, duration=LONG))
        time, worn = result.time, result.worn[:, 0]
        rate, stderr, end = stopped_rate(
            time, worn, result.present, setup, release_interval(row, setup)
        )
        late = batch_means(time, worn, LONG / 2.0)
        off.append(100.0 * (rate / late.rate - 1.0))
        print(
            f"case {row['case_id']}: R {1e3 * row['particle_radius']:.1f} mm, "
            f"{row['plate_angle']:.1f} deg, {result.present[-1]} particles: "
            f"the rule stops after {end:.1f} s, {off[-1]:+.1f} % from the mean of the last "
            f"{LONG / 2:g} s; standard errors {100 * stderr:.1f} % and "
            f"{100 * late.stderr / late.rate:.1f} %",
            flush=True,
        )
    known = np.array(off)[np.isfinite(off)]
    if not known.size:
        raise SystemExit(f"none of {len(off)} beds stopped within {LONG:g} s")
    print(
        f"{len(known)} of {len(off)} beds stopped within {LONG:g} s: mean {known.mean():+.1f} %, "
        f"root mean square {np.sqrt((known**2).mean()):.1f} %, largest {abs(known).max():.1f} %"
    )


def main() -> None:
    """Print the effect of shorter windows, or of longer simulations of beds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("study", type=Path, help="folder with its results")
    parser.add_argument("--beds", type=int, help="number of beds to simulate for a long time")
    chosen = parser.parse_args()
    stored = yaml.safe_load((chosen.study / "config.yaml").read_text(encoding="utf-8"))
    setup = Setup.from_dict(setup_dict(load_config(stored)))
    if chosen.beds:
        beds(chosen.study, setup, chosen.beds)
        return
    table = replayed(chosen.study, setup)
    bed = (table["plate_angle"] < FLAT) & (table["particle_radius"] < SMALL)
    for window in SHORTER:
        for name, which in (("beds", bed), ("others", ~bed)):
            off = 100.0 * table.loc[which, window]
            known = off.dropna()
            print(
                f"window {window:g} s, {name}: {len(known)} of {len(off)} cases, "
                f"mean {known.mean():+.2f} %, largest {known.abs().max():.1f} %"
            )


if __name__ == "__main__":
    main()
