"""Some cases simulated again with other seeds."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.store.tables import read_table, write_table
from abradem.wear.replicates import choose_cases, replicate

cases = choose_cases(read_table(snakemake.input[0]), snakemake.params.cases)
part, parts = snakemake.params.part
found = replicate(
    cases.iloc[part::parts], snakemake.params.replicates, snakemake.params.setup,
    snakemake.params.options,
)  # fmt: skip
write_table(found, snakemake.output[0])
