"""Computing times of engine and surrogate, measured in turn."""

from abradem.learning.physical.speed_up import time_both
from abradem.running.job_log import log_to
from abradem.store.files import write_json
from abradem.store.tables import read_table
from abradem.surrogate.model import Surrogate

log_to(snakemake.log[0])

found = time_both(
    read_table(snakemake.input.dataset),
    surrogate=Surrogate.load(snakemake.input.surrogate),
    **snakemake.params.options,
)
write_json(found, snakemake.output[0])
