"""Where on the plate the wear is, for some cases."""

from pathlib import Path

from abradem.dataset import concatenate, read_table
from abradem.figures import style
from abradem.figures.maps import wear_maps_figure
from abradem.joblog import log_to
from abradem.shards import setup_from_dict
from abradem.wear_rate import depth_rate_maps

log_to(snakemake.log[0])

tables = {
    name: concatenate(map(read_table, snakemake.input[name])) for name in ("maps", "runs", "cases")
}
facets, panels = depth_rate_maps(
    **tables, setup=setup_from_dict(snakemake.params.setup), **snakemake.params.options
)
stem = Path(snakemake.output[0]).with_suffix("")
style.save(wear_maps_figure(facets, panels), stem, snakemake.params.formats)
