"""The simulations of one batch of cases."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.simulation.batch import FILES, run_batch
from abradem.store.tables import read_table

start, stop = snakemake.params.rows
run_batch(
    read_table(snakemake.input.cases).iloc[start:stop],
    snakemake.params.setup,
    {name: snakemake.output[name] for name in FILES},
    finished=snakemake.params.finished,
    code=snakemake.params.code,
    threads=snakemake.threads,
)
