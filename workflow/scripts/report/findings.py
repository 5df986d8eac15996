"""Findings of the models as text."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.findings import findings, to_html
from abradem.store.files import write_text
from abradem.store.tables import read_results
from abradem.words.wear import WearTarget

target = WearTarget(**snakemake.params.target) if snakemake.params.target else None
paragraphs = findings(**read_results(snakemake.input.items()), target=target)
write_text(to_html(f"Models of study {snakemake.params.table}", paragraphs), snakemake.output[0])
