"""What the quantities of a study do to the wear of each part, as a table and in words."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.parts_page import parts_page
from abradem.store.columns import PART_EFFECTS
from abradem.store.files import write_text
from abradem.store.tables import read_table, write_table
from abradem.wear.part_effects import part_effects

parts, cases = read_table(snakemake.input.parts), read_table(snakemake.input.cases)
effects = part_effects(parts, cases, snakemake.params.column)
write_table(effects, snakemake.output.table, PART_EFFECTS)
params = snakemake.params
page = parts_page(
    params.study, parts, effects, cases, params.column, params.reference, params.source,
    params.part,
)  # fmt: skip
write_text(page, snakemake.output.page)
