"""Exponents of the wear rate beside those of the published data."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.exponents import exponents_beside_published
from abradem.store.columns import EXPONENTS
from abradem.store.tables import read_table, write_table

found = exponents_beside_published(
    read_table(snakemake.input[0]), snakemake.params.target, snakemake.params.setup
)
write_table(found, snakemake.output[0], extra=EXPONENTS)
