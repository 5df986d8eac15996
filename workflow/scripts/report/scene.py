"""A scene in three dimensions as one page."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.scene import scene_page
from abradem.store.files import write_text
from abradem.store.tables import read_table

page = scene_page(
    read_table(snakemake.input.particles),
    read_table(snakemake.input.wear),
    **snakemake.params.options,
)
write_text(page, snakemake.output[0])
