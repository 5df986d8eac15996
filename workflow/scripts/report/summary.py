"""Headline numbers for the overview of the report."""

from abradem.report.summary import study_summary
from abradem.running.job_log import log_to
from abradem.store.files import write_json
from abradem.store.tables import read_results

log_to(snakemake.log[0])

summary = study_summary(**read_results(snakemake.input.items()), **snakemake.params.options)
write_json(summary, snakemake.output[0])
