"""The data set, one row for each successful case."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dataset.join import check, check_failures, join
from abradem.store.tables import concatenate, read_table, write_table

dataset, failures = join(
    read_table(snakemake.input.cases),
    concatenate(map(read_table, snakemake.input.rates)),
    concatenate(map(read_table, snakemake.input.runs)),
    **snakemake.params.options,
)
check_failures(dataset, failures, snakemake.params.max_failed_share)
check(dataset)
write_table(dataset, snakemake.output[0])
