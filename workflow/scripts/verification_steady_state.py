"""The paper's steady-state study."""

from abradem.joblog import log_to
from abradem.verification import steady_state_study
from abradem.verification.table import write

log_to(snakemake.log[0])

write(steady_state_study.study(), {name: snakemake.output[name] for name in snakemake.params.tables})
