"""How well the wear rates are known."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.series import quality_figure
from abradem.joblog import log_to
from abradem.wear_rate import quality_table

log_to(snakemake.log[0])

quality = quality_table(read_table(snakemake.input[0]))
stem = Path(snakemake.output[0]).with_suffix("")
style.save(quality_figure(quality, **snakemake.params.options), stem, snakemake.params.formats)
