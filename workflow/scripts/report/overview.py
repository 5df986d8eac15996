"""The first screen of the report, as a page."""

from abradem.running.job_log import start_job

start_job(snakemake)

from pathlib import Path

from abradem.report.overview import overview_page
from abradem.store.files import write_text
from abradem.store.tables import read_results

found = {name: snakemake.input.get(name) for name in ("summary", "comparison", "noise")}
page = overview_page(
    **snakemake.params.options,
    **read_results(found.items()),
    picture=Path(snakemake.input.picture).read_bytes(),
    template=Path(snakemake.input.template).read_text(encoding="utf-8"),
)
write_text(page, snakemake.output[0])
