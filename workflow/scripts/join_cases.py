"""The cases of all blocks in one table."""

from abradem.dataset import concatenate, read_table, write_table
from abradem.joblog import log_to

log_to(snakemake.log[0])

write_table(concatenate(map(read_table, snakemake.input)), snakemake.output[0])
