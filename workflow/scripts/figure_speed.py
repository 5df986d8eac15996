"""What simulations cost."""

from pathlib import Path

import pandas as pd

from abradem.figures import style
from abradem.figures.engine import cost_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

figure = cost_figure(*map(pd.read_csv, snakemake.params.tables))
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
