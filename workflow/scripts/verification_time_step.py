"""What the step does to each reading."""

from abradem.joblog import log_to
from abradem.verification import time_step
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = time_step.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
