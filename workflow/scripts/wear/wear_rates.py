"""The wear rates of one batch."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dem.model import Setup
from abradem.store.tables import read_table, write_table
from abradem.wear.rates import wear_rates

tables = {name: read_table(path) for name, path in snakemake.input.items()}
rates = wear_rates(
    **tables, setup=Setup.from_dict(snakemake.params.setup), **snakemake.params.options
)
write_table(rates, snakemake.output[0])
