"""Computing times of engine and surrogate, measured in turn."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.physical.speed_up import time_both
from abradem.store.files import write_json
from abradem.store.tables import read_table
from abradem.surrogate.model import Surrogate

found = time_both(
    read_table(snakemake.input.dataset),
    surrogate=Surrogate.load(snakemake.input.surrogate),
    **snakemake.params.options,
)
write_json(found, snakemake.output[0])
