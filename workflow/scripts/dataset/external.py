"""The data set from an external table."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dataset.external import read_external
from abradem.store.tables import write_table

params = snakemake.params
found = read_external(snakemake.params.table, params.columns, params.damping_coefficient)
write_table(found, snakemake.output[0])
