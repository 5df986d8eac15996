"""Facets as bookkeeping; the books of a bed."""

from abradem.joblog import log_to
from abradem.verification import facets_and_bed
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = facets_and_bed.study()
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
