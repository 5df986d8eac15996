"""Predicted against actual wear, held-out cases."""

import json
from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.linear import predicted_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

model = json.loads(Path(snakemake.input.summary).read_text(encoding="utf-8"))
figure = predicted_figure(read_table(snakemake.input.table), model)
stem = Path(snakemake.output[0]).with_suffix("")
style.save(figure, stem, snakemake.params.formats)
