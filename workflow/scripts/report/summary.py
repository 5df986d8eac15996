"""Headline numbers for the overview of the report."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.summary import study_summary
from abradem.store.files import write_json
from abradem.store.tables import read_results

summary = study_summary(**read_results(snakemake.input.items()), **snakemake.params.options)
write_json(summary, snakemake.output[0])
