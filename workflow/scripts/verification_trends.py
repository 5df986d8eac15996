"""Exponents in dilute jets."""

from abradem.joblog import log_to
from abradem.verification import trends
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = trends.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
