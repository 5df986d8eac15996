"""Wear depth against time for several plate angles and factory angles."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dem.model import Setup
from abradem.store.columns import ANGLES
from abradem.store.tables import write_table
from abradem.wear.angles import depth_by_angle

curves, rates = depth_by_angle(
    snakemake.params.case, Setup.from_dict(snakemake.params.setup), **snakemake.params.options
)
write_table(curves, snakemake.output.curves, extra=ANGLES)
write_table(rates, snakemake.output.rates, extra=ANGLES)
