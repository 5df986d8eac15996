"""Extrapolation and every target."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.models import reach_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

tables = (read_table(snakemake.input[name]) for name in ("extrapolation", "targets"))
figure = reach_figure(*tables, snakemake.params.table)
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
