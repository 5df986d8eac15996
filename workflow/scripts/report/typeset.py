"""The example paper with the tables, numbers and figures of a study."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.typeset import typeset

typeset(snakemake.input.text, snakemake.params.folder, snakemake.output[0])
