"""One figure of the verification study."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.verification import FIGURES
from abradem.joblog import log_to

log_to(snakemake.log[0])

figure = FIGURES[snakemake.wildcards.figure](*map(read_table, snakemake.input))
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
