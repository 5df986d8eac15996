"""The eight particle-level tests of Chung & Ooi."""

from abradem.joblog import log_to
from abradem.verification import chung_ooi
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = chung_ooi.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
