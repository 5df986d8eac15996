"""The cases that are not in the data set, with the reasons."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dataset.join import join
from abradem.store.tables import concatenate, read_table, write_table

_, failures = join(
    read_table(snakemake.input.cases),
    concatenate(map(read_table, snakemake.input.rates)),
    concatenate(map(read_table, snakemake.input.runs)),
)
write_table(failures, snakemake.output[0])
