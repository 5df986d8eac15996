"""The eight particle-level tests of Chung & Ooi."""

from abradem.joblog import log_to
from abradem.verification import chung_ooi
from abradem.verification.table import write

log_to(snakemake.log[0])

write(chung_ooi.study(), {name: snakemake.output[name] for name in snakemake.params.tables})
