"""The paper's screw-conveyor check."""

from abradem.joblog import log_to
from abradem.verification import conveyor
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = conveyor.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
