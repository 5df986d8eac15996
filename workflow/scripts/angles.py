"""Wear depth against time for angles of plate and factory."""

from abradem.dataset import write_table
from abradem.joblog import log_to
from abradem.scenes import COLUMNS, depth_by_angle
from abradem.shards import setup_from_dict

log_to(snakemake.log[0])

curves, rates = depth_by_angle(
    snakemake.params.case, setup_from_dict(snakemake.params.setup), **snakemake.params.options
)
write_table(curves, snakemake.output.curves, extra=COLUMNS)
write_table(rates, snakemake.output.rates, extra=COLUMNS)
