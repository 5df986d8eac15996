"""The cases of all blocks in one table."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.store.tables import concatenate, read_table, write_table

write_table(concatenate(map(read_table, snakemake.input)), snakemake.output[0])
