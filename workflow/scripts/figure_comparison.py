"""All models side by side."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.comparison import comparison_figure, predictions_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

predictions, comparison, beside_paper = (
    read_table(snakemake.input[name]) for name in ("predictions", "comparison", "beside_paper")
)
for name, figure in (
    ("comparison", comparison_figure(comparison, beside_paper, snakemake.params.table)),
    ("predictions", predictions_figure(predictions, comparison)),
):
    stem = Path(snakemake.output[name][0]).with_suffix("")
    style.save(figure, stem, snakemake.params.formats)
