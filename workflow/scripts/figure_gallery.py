"""Wear maps over the parameter space."""

from pathlib import Path

from abradem.dataset import concatenate, read_table
from abradem.figures import style
from abradem.figures.gallery import gallery_figure
from abradem.gallery import chosen_cases
from abradem.joblog import log_to
from abradem.shards import setup_from_dict
from abradem.wear_rate import depth_rate_maps

log_to(snakemake.log[0])

runs = concatenate(map(read_table, snakemake.input.runs))
cases = read_table(snakemake.input.cases)
grid = snakemake.params.grid
places = chosen_cases(cases, runs, **grid)
chosen = list(places["case_id"])
# Of each shard only these: the maps of all cases of a large study do not fit into memory.
maps = concatenate(read_table(path).query("case_id in @chosen") for path in snakemake.input.maps)
facets, panels = depth_rate_maps(maps, runs, cases, setup_from_dict(snakemake.params.setup), chosen)
figure = gallery_figure(facets, panels, places, grid["across"], grid["down"])
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
