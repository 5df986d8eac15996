"""The cases of all blocks in one table."""

from abradem.running.job_log import log_to
from abradem.store.tables import concatenate, read_table, write_table

log_to(snakemake.log[0])

write_table(concatenate(map(read_table, snakemake.input)), snakemake.output[0])
