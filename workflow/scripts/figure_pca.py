"""Correlations, loadings, and regression on principal components."""

import json
from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.components import (
    components_curve_figure,
    correlations_figure,
    loadings_figure,
)
from abradem.joblog import log_to

log_to(snakemake.log[0])

summary = json.loads(Path(snakemake.input.summary).read_text(encoding="utf-8"))
model = json.loads(Path(snakemake.input.model).read_text(encoding="utf-8"))
loadings, scree, correlations, curve = (
    read_table(snakemake.input[name]) for name in ("loadings", "scree", "correlations", "curve")
)
for name, figure in (
    ("correlations", correlations_figure(correlations, model["training_rows"])),
    ("loadings", loadings_figure(loadings, scree, summary)),
    ("curve", components_curve_figure(curve)),
):
    stem = Path(snakemake.output[name][0]).with_suffix("")
    style.save(figure, stem, snakemake.params.formats)
