"""Distributions of standardised wear, predictions and errors."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.distributions import distributions_figure
from abradem.joblog import log_to
from abradem.learning.distributions import standardised

log_to(snakemake.log[0])

target, model = snakemake.params.target, snakemake.params.model
table = standardised(
    read_table(snakemake.input.dataset), read_table(snakemake.input.predictions), target, model
)
figure = distributions_figure(table, model)
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
