"""The verification study at a glance."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.verdicts import verdicts_figure
from abradem.joblog import log_to
from abradem.verification.margins import margins
from abradem.verification.page import PARTS
from abradem.verification.table import HOLDS

log_to(snakemake.log[0])

figure = verdicts_figure(margins(read_table(snakemake.params.checks)), PARTS, HOLDS)
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
