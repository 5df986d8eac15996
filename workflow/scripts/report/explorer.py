"""The explorer: one page that predicts wear while sliders are moved."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.explorer import explorer_page
from abradem.store.files import read_arrays, read_json, write_text
from abradem.store.tables import read_table
from abradem.surrogate.maps import MapSurrogate

page = explorer_page(
    (read_json(snakemake.input.model), read_arrays(snakemake.input.model_arrays)),
    MapSurrogate.load(snakemake.input.maps) if snakemake.input.get("maps") else None,
    read_table(snakemake.input.dataset),
    **snakemake.params.options,
)
write_text(page, snakemake.output[0])
