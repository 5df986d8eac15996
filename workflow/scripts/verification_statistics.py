"""Standard errors against replicates."""

from abradem.joblog import log_to
from abradem.verification import statistics
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = statistics.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
