"""A table as text, and as a page that sorts its rows, for the report."""

from abradem.running.job_log import start_job

start_job(snakemake)

from pathlib import Path

from abradem.report.readable import readable
from abradem.report.table_page import table_page
from abradem.store.files import write_csv, write_text
from abradem.store.tables import read_columns, read_table

table = readable(read_table(snakemake.input.table))
write_csv(table, snakemake.output.text)
page = table_page(
    Path(snakemake.output.page).stem,
    table,
    read_columns(snakemake.input.table),
    Path(snakemake.input.template).read_text(encoding="utf-8"),
)
write_text(page, snakemake.output.page)
