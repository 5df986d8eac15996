"""Snapshots of one case at regular intervals."""

from abradem.running.job_log import start_job

start_job(snakemake)

from pathlib import Path

from abradem.dem.model import Setup
from abradem.simulation.snapshots import write_snapshots
from abradem.store.tables import concatenate, read_table

cases = concatenate(map(read_table, snakemake.input.cases)).set_index("case_id")
write_snapshots(
    cases.loc[int(snakemake.wildcards.case)].to_dict(),
    Setup.from_dict(snakemake.params.setup),
    Path(snakemake.output.particles).parent,
    snakemake.params.interval,
)
