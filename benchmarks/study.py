"""What the simulations of a finished study cost: python benchmarks/study.py results/paper.

Computing time is that of the cases, as each was noted; wall times and memory are Snakemake's
record of the jobs, which took two seconds more each. Used for docs/scaling.md.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import pandas as pd

STORED = ("series", "maps", "runs", "wear_rates", "cases")


def tables(folder: Path) -> list[pd.DataFrame]:
    """All Parquet tables of a folder."""
    return [pd.read_parquet(path) for path in sorted(folder.glob("*.parquet"))]


def size(paths) -> int:
    """Bytes of files."""
    return sum(path.stat().st_size for path in paths if path.is_file())


def main() -> None:
    """Print a line for each figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("study", type=Path, help="folder of a finished study: results/paper")
    folder = parser.parse_args().study
    spent, shards = tables(folder / "benchmarks" / "cases"), tables(folder / "runs")
    records = sorted((folder / "benchmarks" / "simulate").glob("*.tsv"))
    failures = folder / "failures.parquet"
    if not shards or len({len(spent), len(shards), len(records)}) > 1 or not failures.exists():
        raise SystemExit(f"{folder} is not the folder of a finished study")

    runs = pd.concat(shards)
    seconds = pd.concat(spent)["processor_time"]
    jobs = pd.concat(pd.read_csv(record, sep="\t") for record in records)
    dearest = max(job["processor_time"].sum() for job in spent)
    steps = (runs["simulated_time"] / runs["time_step"]).sum()
    stored = size(path for name in STORED for path in (folder / name).glob("*.parquet"))
    files = [path for path in folder.rglob("*") if path.is_file()]
    print(f"cases: {len(runs)}, of which failed: {len(pd.read_parquet(failures))}")
    print(f"simulated: {runs['simulated_time'].sum():.0f} s, {steps / 1e9:.2f} billion steps")
    print(f"stones released: {runs['released'].sum() / 1e6:.2f} million")
    print(f"computing: {seconds.sum():.0f} s, {seconds.sum() / 120:.1f} min of two cores")
    print(f"a case: mean {seconds.mean():.2f}, median {seconds.median():.2f}, "
          f"most {seconds.max():.0f} s of computing")  # fmt: skip
    print(f"jobs: {len(jobs)}, the dearest {dearest:.0f} s of computing, "
          f"together {jobs['s'].sum():.0f} s on the wall")  # fmt: skip
    print(f"memory of a job: at most {jobs['max_rss'].max():.0f} MB")
    print(f"series, maps, runs, rates and cases: {stored / len(runs) / 1e3:.0f} kB a case")
    print(f"data set: {size([folder / 'dataset.parquet']) / 1e6:.2f} MB")
    print(f"folder: {len(files)} files, {size(files) / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
