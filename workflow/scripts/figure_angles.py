"""Wear depth against time for angles of plate and factory."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.angles import angles_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

figure = angles_figure(
    read_table(snakemake.input.curves),
    read_table(snakemake.input.rates),
    **snakemake.params.options,
)
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
