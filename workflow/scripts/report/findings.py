"""Findings of the models as text."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.findings import findings, to_html
from abradem.store.files import write_text
from abradem.store.tables import read_results

paragraphs = findings(**read_results(snakemake.input.items()))
write_text(to_html(f"Models of study {snakemake.params.table}", paragraphs), snakemake.output[0])
