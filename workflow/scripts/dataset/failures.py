"""The cases that are not in the data set, with the reasons."""

from abradem.dataset.join import join
from abradem.running.job_log import log_to
from abradem.store.tables import concatenate, read_table, write_table

log_to(snakemake.log[0])

_, failures = join(
    read_table(snakemake.input.cases),
    concatenate(map(read_table, snakemake.input.rates)),
    concatenate(map(read_table, snakemake.input.runs)),
)
write_table(failures, snakemake.output[0])
