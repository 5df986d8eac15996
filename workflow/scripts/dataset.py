"""The data set, one row per case that ended well."""

from abradem.dataset import check, concatenate, join, read_table, write_table
from abradem.joblog import log_to

log_to(snakemake.log[0])

dataset, _ = join(
    read_table(snakemake.input.cases[0]),
    concatenate(map(read_table, snakemake.input.rates)),
    concatenate(map(read_table, snakemake.input.runs)),
    **snakemake.params.options,
)
check(dataset)
write_table(dataset, snakemake.output[0])
