"""Snapshots of one case at regular intervals."""

from pathlib import Path

from abradem.dataset import concatenate, read_table
from abradem.export import write_snapshots
from abradem.joblog import log_to
from abradem.shards import case_from_row, setup_from_dict

log_to(snakemake.log[0])

cases = concatenate(map(read_table, snakemake.input)).set_index("case_id")
write_snapshots(
    case_from_row(cases.loc[int(snakemake.wildcards.case)]),
    setup_from_dict(snakemake.params.setup),
    Path(snakemake.output.particles).parent,
    snakemake.params.interval,
)
