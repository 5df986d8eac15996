"""Engine and surrogate timed one after the other."""

from abradem.dataset import read_table, write_json
from abradem.joblog import log_to
from abradem.speed_up import time_both
from abradem.surrogate import Surrogate

log_to(snakemake.log[0])

found = time_both(
    read_table(snakemake.input.dataset),
    surrogate=Surrogate.load(snakemake.input.surrogate),
    **snakemake.params.options,
)
write_json(found, snakemake.output[0])
