"""The example paper with the tables, numbers and figures of a study."""

from abradem.report.typeset import typeset
from abradem.running.job_log import log_to

log_to(snakemake.log[0])

typeset(snakemake.input.text, snakemake.params.folder, snakemake.output[0])
