"""Wear depth against time for some cases."""

from pathlib import Path

from abradem.dataset import concatenate, read_table
from abradem.figures import style
from abradem.figures.series import series_figure
from abradem.joblog import log_to
from abradem.shards import setup_from_dict
from abradem.wear_rate import depth_series

log_to(snakemake.log[0])

tables = {
    name: concatenate(map(read_table, snakemake.input[name]))
    for name in ("series", "runs", "cases")
}
curves, fits = depth_series(
    **tables, setup=setup_from_dict(snakemake.params.setup), **snakemake.params.options
)
stem = Path(snakemake.output[0]).with_suffix("")
style.save(series_figure(curves, fits), stem, snakemake.params.formats)
