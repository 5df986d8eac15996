"""The rows that models of a named part learn from."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dataset.part_rows import part_rows
from abradem.store.tables import read_table, write_table

rows = part_rows(
    read_table(snakemake.input.dataset), read_table(snakemake.input.parts), snakemake.params.part
)
write_table(rows, snakemake.output[0])
