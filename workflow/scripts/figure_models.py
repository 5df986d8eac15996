"""The models on dimensionless groups on one page."""

from pathlib import Path

from abradem.dataset import read_json, read_table
from abradem.figures import style
from abradem.figures.models import models_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

noise = snakemake.input.get("noise")
tables = ("comparison", "calibration", "curve", "indices", "exponents")
figure = models_figure(
    *(read_table(snakemake.input[name]) for name in tables),
    read_json(noise) if noise else None,
    snakemake.params.table,
)
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
