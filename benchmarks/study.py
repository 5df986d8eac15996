"""Cost of the simulations of a finished study: python benchmarks/study.py results/paper.

Computing time is the recorded time of the cases. Memory is from Snakemake's record of the jobs,
which samples them every 30 s. Wall time is that of the jobs, including the time outside the cases.
These are the numbers in docs/scaling.md.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from abradem.config import Config, read_config
from abradem.store.tables import read_table

STORED = ("series", "maps", "parts", "runs", "wear_rates")


class Study(NamedTuple):
    """A study with finished simulations: its configuration and the tables of each job."""

    config: Config
    jobs: list[str]
    runs: list[pd.DataFrame]
    times: list[pd.DataFrame]


def read_study(folder: Path) -> Study:
    """Read the tables that the configuration of the study defines; other files are ignored."""
    if not (folder / "config.yaml").exists():
        raise SystemExit(f"{folder}/config.yaml is missing; `snakemake simulation` writes it")
    config = read_config(folder / "config.yaml")
    jobs = [
        f"block-{block:03d}-batch-{batch:03d}"
        for block in range(config.sampling.blocks)
        for batch in range(len(config.batches))
    ]
    tables = []
    for part in ("runs", "benchmarks/cases"):
        paths = [folder / part / f"{job}.parquet" for job in jobs]
        missing = [path for path in paths if not path.exists()]
        if missing:
            raise SystemExit(f"{missing[0]} is missing, with {len(missing) - 1} others: unfinished")
        tables.append([read_table(path) for path in paths])
    return Study(config, jobs, *tables)


def size(paths) -> int:
    """Return the total size of files, bytes."""
    return sum(path.stat().st_size for path in paths if path.is_file())


def presence(folder: Path, study: Study) -> pd.DataFrame:
    """Return the processor time of every case, and its particles present times steps."""
    found = []
    for job, runs, times in zip(study.jobs, study.runs, study.times, strict=True):
        series = read_table(folder / "series" / f"{job}.parquet", ("case_id", "particles_present"))
        mean = series.groupby("case_id")["particles_present"].mean().rename("present")
        steps = (runs["simulated_time"] / runs["time_step"]).rename("steps")
        table = runs[["case_id"]].join(steps).merge(times, on="case_id").join(mean, on="case_id")
        found.append(table)
    cases = pd.concat(found, ignore_index=True)
    cases["particle_steps"] = cases["present"].fillna(0.0) * cases["steps"].fillna(0.0)
    return cases


def main() -> None:
    """Print a line for each number."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("study", type=Path, help="folder of a finished study: results/paper")
    folder = parser.parse_args().study
    study = read_study(folder)

    runs = pd.concat(study.runs)
    seconds = pd.concat(study.times)["processor_time"]
    records = [folder / "benchmarks" / "simulate" / f"{job}.tsv" for job in study.jobs]
    jobs = pd.concat(pd.read_csv(record, sep="\t") for record in records)
    most_expensive = max(times["processor_time"].sum() for times in study.times)
    steps = (runs["simulated_time"] / runs["time_step"]).sum()
    stored = size(folder / name / f"{job}.parquet" for name in STORED for job in study.jobs)
    stored += size((folder / "cases").glob("*.parquet"))
    files = [path for path in folder.rglob("*") if path.is_file()]
    cases = presence(folder, study)
    costly = cases.nlargest(max(1, len(cases) // 100), "processor_time")
    print(f"cases: {len(runs)}, simulated: {(runs['status'] == 'ok').sum()}")
    print(f"simulated: {runs['simulated_time'].sum():.0f} s, {steps / 1e9:.2f} billion steps")
    print(f"particles released: {runs['released'].sum() / 1e6:.2f} million")
    print(f"computing: {seconds.sum():.0f} s, {seconds.sum() / 120:.1f} min of two cores")
    print(
        f"a case: mean {seconds.mean():.2f}, median {seconds.median():.2f}, "
        f"most {seconds.max():.0f} s of computing; the most expensive hundredth takes "
        f"{100 * costly['processor_time'].sum() / seconds.sum():.0f} % of all"
    )
    each = 1e9 * costly["processor_time"] / costly["particle_steps"]
    print(
        f"particles present times steps: {cases['particle_steps'].sum() / 1e9:.0f} billion; in the "
        f"most expensive hundredth {costly['particle_steps'].sum() / 1e9:.0f} billion, of "
        f"{1e9 * costly['processor_time'].sum() / costly['particle_steps'].sum():.0f} ns each "
        f"({each.min():.0f} to {each.max():.0f} in single cases)"
    )
    print(
        f"jobs: {len(jobs)}, the most expensive {most_expensive:.0f} s of computing, "
        f"together {jobs['s'].sum():.0f} s on the wall, "
        f"{100 * (jobs['s'].sum() / seconds.sum() - 1):.1f} % more than their cases took"
    )
    print(f"memory of a job: at most {jobs['max_rss'].max():.0f} MB")
    print(f"series, maps, parts, runs, rates and cases: {stored / len(runs) / 1e3:.0f} kB a case")
    if (folder / "dataset.parquet").exists():
        print(f"data set: {size([folder / 'dataset.parquet']) / 1e6:.2f} MB")
    print(f"folder: {len(files)} files, {size(files) / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
