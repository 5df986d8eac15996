"""Snapshots of one case at regular intervals."""

from abradem.running.job_log import start_job

start_job(snakemake)

from pathlib import Path

from abradem.dem.model import Case, Setup
from abradem.simulation.snapshots import write_snapshots
from abradem.store.tables import concatenate, read_table

cases = concatenate(map(read_table, snakemake.input)).set_index("case_id")
write_snapshots(
    Case.from_row(cases.loc[int(snakemake.wildcards.case)]),
    Setup.from_dict(snakemake.params.setup),
    Path(snakemake.output.particles).parent,
    snakemake.params.interval,
)
