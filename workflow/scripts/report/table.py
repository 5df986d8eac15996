"""A table as text, for the report."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.readable import readable
from abradem.store.files import write_csv
from abradem.store.tables import read_table

write_csv(readable(read_table(snakemake.input[0])), snakemake.output[0])
