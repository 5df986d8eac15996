"""Flow charts: generation of the data, set-up of a simulation, the whole workflow."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.flow import generation_figure, workflow_figure
from abradem.joblog import log_to
from abradem.shards import setup_from_dict

log_to(snakemake.log[0])

graph = read_table(snakemake.input[0])
values = snakemake.params.setup
setup = None if values is None else setup_from_dict(values)
for name, figure in (
    ("generation", generation_figure(graph, snakemake.params.study, setup)),
    ("rules", workflow_figure(graph)),
):
    stem = Path(snakemake.output[name][0]).with_suffix("")
    style.save(figure, stem, snakemake.params.formats)
