"""The cases that are no row of the data set, and why."""

from abradem.dataset import concatenate, join, read_table, write_table
from abradem.joblog import log_to

log_to(snakemake.log[0])

_, failures = join(
    read_table(snakemake.input.cases),
    concatenate(map(read_table, snakemake.input.rates)),
    concatenate(map(read_table, snakemake.input.runs)),
)
write_table(failures, snakemake.output[0])
