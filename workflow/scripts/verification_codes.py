"""Independent codes under the same options."""

from abradem.joblog import log_to
from abradem.verification import codes
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = codes.study(*(codes.read(snakemake.input[name]) for name in ("impacts", "jets", "forces")))
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
