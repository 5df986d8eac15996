"""The wear rates of one batch."""

from abradem.dem.model import Setup
from abradem.running.job_log import log_to
from abradem.store.tables import read_table, write_table
from abradem.wear.rates import wear_rates

log_to(snakemake.log[0])

tables = {name: read_table(snakemake.input[name]) for name in ("series", "maps", "runs", "cases")}
rates = wear_rates(
    **tables, setup=Setup.from_dict(snakemake.params.setup), **snakemake.params.options
)
write_table(rates, snakemake.output[0])
