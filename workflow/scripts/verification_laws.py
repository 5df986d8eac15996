"""Closed forms, sweeps and the order of convergence."""

from abradem.joblog import log_to
from abradem.verification import laws
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = laws.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
