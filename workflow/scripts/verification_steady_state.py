"""The paper's steady-state study."""

from abradem.joblog import log_to
from abradem.verification import steady_state_study
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = steady_state_study.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
