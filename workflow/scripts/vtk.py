"""Snapshots of a case for ParaView."""

from abradem.dataset import concatenate, read_table
from abradem.joblog import log_to
from abradem.shards import setup_from_dict
from abradem.vtk import case_values, write_vtk

log_to(snakemake.log[0])

case = snakemake.params.case
if case is None:
    cases = concatenate(map(read_table, snakemake.input.cases))
    case = case_values(cases, int(snakemake.wildcards.case))
write_vtk(
    read_table(snakemake.input.particles),
    read_table(snakemake.input.wear),
    case,
    setup_from_dict(snakemake.params.setup),
    snakemake.output[0],
)
