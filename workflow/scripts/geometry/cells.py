"""The wear of every cell and of every named part of the surface of each case."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dem.model import Setup
from abradem.store.columns import CELL_TABLE
from abradem.store.tables import concatenate, read_table, write_table
from abradem.wear.surface_cells import cell_table, part_table

cells = cell_table(
    concatenate(map(read_table, snakemake.input.maps)),
    concatenate(map(read_table, snakemake.input.runs)),
    read_table(snakemake.input.cases),
    Setup.from_dict(snakemake.params.setup),
)
parts = part_table(cells, snakemake.params.footprint_share)
write_table(cells, snakemake.output.cells, CELL_TABLE)
write_table(parts, snakemake.output.parts, CELL_TABLE)
