"""The map surrogate, for `abradem predict --map` and the explorer, and its scores."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dem.model import Setup
from abradem.learning.model_files import write_stage
from abradem.learning.physical.problem import problem
from abradem.learning.physical.wear_maps import plate_of, wear_maps
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of
from abradem.wear.element_maps import element_maps

setup, options = snakemake.params.setup, snakemake.params.options
dataset = read_table(snakemake.input.dataset).sort_values("case_id", ignore_index=True)
batches = (
    (read_table(maps), read_table(runs))
    for maps, runs in zip(snakemake.input.maps, snakemake.input.runs, strict=True)
)
maps = element_maps(batches, dataset, Setup.from_dict(setup), **snakemake.params.elements)
given = problem(dataset, jet_of(setup), **snakemake.params.table)
model, scores = wear_maps(
    given, maps, plate_of(setup), snakemake.params.elements["measure"], **options
)
write_stage(snakemake.output.items(), model=model, scores=scores)
