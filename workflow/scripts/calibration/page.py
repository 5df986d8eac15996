"""The calibration in words, and the best set-up as an override file."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.calibration import sentences
from abradem.report.findings import to_html
from abradem.running.trial_setups import override_file
from abradem.store.files import read_json, write_text
from abradem.store.tables import read_table

files, config = snakemake.input, snakemake.params.config
summary = read_json(files.summary)
search = config["calibration"]
paragraphs = sentences(
    summary, read_table(files.slopes), read_table(files.profiles), search["trials"]
)
write_text(to_html(f"Calibration to {search['table']}", paragraphs), snakemake.output.page)
write_text(override_file(config, summary), snakemake.output.best)
