"""What is left of the wear after the linear equation, and how features depend on each other."""

import json
from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.regression import residuals_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

model = json.loads(Path(snakemake.input.summary).read_text(encoding="utf-8"))
figure = residuals_figure(
    read_table(snakemake.input.residuals), read_table(snakemake.input.coefficients), model
)
stem = Path(snakemake.output[0]).with_suffix("")
style.save(figure, stem, snakemake.params.formats)
