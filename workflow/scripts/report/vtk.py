"""Snapshots of a case for ParaView."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dem.model import Setup
from abradem.report.vtk import case_values, write_vtk
from abradem.store.tables import concatenate, read_table

case = snakemake.params.case
if case is None:
    cases = concatenate(map(read_table, snakemake.input.cases))
    case = case_values(cases, int(snakemake.wildcards.case))
write_vtk(
    read_table(snakemake.input.particles),
    read_table(snakemake.input.wear),
    case,
    Setup.from_dict(snakemake.params.setup),
    snakemake.output[0],
)
