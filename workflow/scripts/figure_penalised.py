"""Paths, penalties and weights of lasso and ridge."""

import json
from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.regression import penalised_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

summary = json.loads(Path(snakemake.input.summary).read_text(encoding="utf-8"))
tables = [read_table(snakemake.input[name]) for name in ("paths", "validation", "weights")]
stem = Path(snakemake.output[0]).with_suffix("")
style.save(penalised_figure(*tables, summary), stem, snakemake.params.formats)
