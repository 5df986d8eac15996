"""The example text with the tables, numbers and figures of a study, as PDF."""

from abradem.joblog import log_to
from abradem.typeset import typeset

log_to(snakemake.log[0])

typeset(snakemake.input.text, snakemake.params.folder, snakemake.output[0])
