"""A table as text, for the report."""

from abradem.report.tables import readable
from abradem.running.job_log import log_to
from abradem.store.files import write_csv
from abradem.store.tables import read_table

log_to(snakemake.log[0])

write_csv(readable(read_table(snakemake.input[0])), snakemake.output[0])
