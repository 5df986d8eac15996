"""The data set from an external table."""

from abradem.dataset.external import read_external
from abradem.running.job_log import log_to
from abradem.store.tables import write_table

log_to(snakemake.log[0])

params = snakemake.params
found = read_external(snakemake.params.table, params.columns, params.damping_coefficient)
write_table(found, snakemake.output[0])
