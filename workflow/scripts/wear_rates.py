"""The wear rates of one shard."""

from abradem.dataset import read_table, write_table
from abradem.joblog import log_to
from abradem.shards import setup_from_dict
from abradem.wear_rate import wear_rates

log_to(snakemake.log[0])

tables = {name: read_table(snakemake.input[name]) for name in ("series", "maps", "runs", "cases")}
rates = wear_rates(
    **tables, setup=setup_from_dict(snakemake.params.setup), **snakemake.params.options
)
write_table(rates, snakemake.output[0])
