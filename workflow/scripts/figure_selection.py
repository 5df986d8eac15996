"""The features that the networks get."""

import json
from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.regression import selection_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

summary = json.loads(Path(snakemake.input.summary).read_text(encoding="utf-8"))
figure = selection_figure(read_table(snakemake.input.selection), summary)
stem = Path(snakemake.output[0]).with_suffix("")
style.save(figure, stem, snakemake.params.formats)
