"""Do the stated standard errors of the wear rates hold? They are compared with replicates.

    python benchmarks/window_errors.py --replicates 40

Each set-up is simulated with many seeds. For each wear rate the root mean square of its stated
standard errors is divided by the standard deviation over the seeds: 1 is right, above 1 is too
cautious. From 40 seeds the ratio is known to 11 % at best. The row "jackknife" is for comparison:
what the jackknife over the parts of the window would state for `total`. The lines at the end are
the table of docs/method.md.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import pandas as pd

from abradem.dem.model import Setup
from abradem.quantities import (
    SAMPLED,
    STATISTICS,
    STDERR_COLUMNS,
    WEAR_COLUMNS,
    WEAR_MEASURES,
    stderr_column,
    wear_column,
)
from abradem.simulation.batch import TABLES, run_case
from abradem.units import MM_PER_M
from abradem.wear.rates import (
    element_counts,
    element_rates,
    element_wear,
    part_maps,
    wear_rates,
)

DILUTE = {"window": 3.0, "max_time": 20.0, "target_stderr": 0.5}
CROWDED = {
    "window": 2.5, "max_time": 12.0, "target_stderr": 0.5, "mass_rate": 42.0, "patch_length": 0.3,
    "patch_width": 0.3, "angle_acts": "arc", "fall_height": 0.385, "arc_radius": 0.235,
    "time_step_fraction": 0.2,
}  # fmt: skip

# Set-up, radius (m), plate angle (deg).
SCENES = {
    "dilute": (DILUTE, ((0.01, 35), (0.015, 5), (0.02, 20), (0.02, 60), (0.04, 35), (0.04, 10))),
    "crowded": (
        CROWDED,
        ((0.01, 60), (0.02, 35), (0.02, 60), (0.03, 15), (0.04, 35), (0.04, 60)),
    ),
}
ELEMENTS = (0.01, 0.03, 0.05)
"""Edges of the elements, m."""


def replicate(setup: dict, radius: float, angle: float, replicates: int) -> pd.DataFrame:
    """Return the wear rates of replicates of a case, for each edge of the elements."""
    row = {
        **{q.name: float(np.mean(q.paper_range)) for q in SAMPLED},
        "particle_radius": radius,
        "plate_angle": float(angle),
        "particle_velocity_y": -4.0,
        "factory_angle": -30.0,
        "case_id": 0,
        "block": 0,
        "rejected": "",
    }
    found = []
    built = Setup.from_dict(setup)
    for seed in range(replicates):
        case = {**row, "seed": seed}
        tables = run_case(case, setup)
        for size in ELEMENTS:
            rates = wear_rates(
                **{name: tables[name] for name in TABLES},
                cases=pd.DataFrame([case]),
                setup=built,
                element_size=size,
            )
            other = jackknife(tables, case["archard_constant"], built, size)
            found.append(rates.assign(element_size=size, **other))
    return pd.concat(found, ignore_index=True).dropna(subset=WEAR_COLUMNS)


def jackknife(tables: dict, constant: float, setup: Setup, size: float) -> dict[str, float]:
    """Return the errors of ``total`` by the jackknife over the parts of the window, mm/s."""
    run = tables["runs"].iloc[0]
    parts = part_maps(tables["parts"], run["window_parts"], setup.facets)["total"]
    counts = element_counts(setup, size)
    kept = run["window_end"] - run["window_start"]
    kept *= 1.0 - 1.0 / len(parts)
    area = setup.plate_area / np.prod(counts)
    left_out = pd.DataFrame(
        element_rates(element_wear(parts.sum(axis=0) - part, counts), area, kept) for part in parts
    )
    errors = MM_PER_M * constant * np.sqrt(len(parts) - 1) * left_out.std(ddof=0)
    return {f"jackknife_{name}": errors[name] for name in STATISTICS[1:]}


def ratios(rates: pd.DataFrame) -> pd.DataFrame:
    """Return stated over true error by statistic (columns) and wear measure or jackknife (rows)."""
    stated = np.sqrt((rates[list(STDERR_COLUMNS)] ** 2).mean())
    true = rates[list(WEAR_COLUMNS)].std(ddof=1)
    # A statistic that is the same in all replicates, such as a p99 of 0, has no error to tell.
    values = [
        [
            stated[stderr_column(name)] / true[name] if true[name] > 0.0 else np.nan
            for name in (wear_column(measure, statistic) for statistic in STATISTICS)
        ]
        for measure in WEAR_MEASURES
    ]
    table = pd.DataFrame(values, index=WEAR_MEASURES, columns=STATISTICS)
    for name in STATISTICS[1:]:
        other = np.sqrt((rates[f"jackknife_{name}"] ** 2).mean())
        spread = true[wear_column("total", name)]
        table.loc["jackknife", name] = other / spread if spread > 0.0 else np.nan
    return table


def main() -> None:
    """Print the ratios of each set-up, and their medians and ranges by statistic."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=40)
    replicates = parser.parse_args().replicates
    found = []
    for kind, (setup, cases) in SCENES.items():
        for radius, angle in cases:
            start = time.process_time()
            rates = replicate(setup, radius, angle, replicates)
            spent = time.process_time() - start
            print(f"{kind}, R {1e3 * radius:g} mm, plate {angle} deg: {spent:.0f} s", flush=True)
            for size, of_size in rates.groupby("element_size"):
                table = ratios(of_size)
                names = [wear_column("total", statistic) for statistic in STATISTICS]
                spread = of_size[names].std(ddof=1) / of_size[names].mean()
                print(
                    f"  elements of {1e3 * size:g} mm, {len(of_size)} replicates; relative scatter "
                    f"of total: {', '.join(f'{value:.3f}' for value in spread)}"
                )
                print("   ", table.to_string(float_format="{:.2f}".format).replace("\n", "\n    "))
                found.append(table.assign(kind=kind, element_size=size))
    whole = pd.concat(found)
    print("Stated over true error: median (least to largest) of set-ups and wear measures")
    whole["by"] = np.where(whole.index == "jackknife", "jackknife", "stated")
    for (by, kind, size), rows in whole.groupby(["by", "kind", "element_size"]):
        print(f"  {by}, {kind}, elements of {1e3 * size:g} mm: " + "; ".join(
            f"{name} {rows[name].median():.2f} ({rows[name].min():.2f} to {rows[name].max():.2f})"
            for name in STATISTICS
        ))  # fmt: skip


if __name__ == "__main__":
    main()
