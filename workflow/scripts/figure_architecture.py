"""The networks that the genetic search found."""

from pathlib import Path

from abradem.dataset import read_json
from abradem.figures import style
from abradem.figures.architecture import architecture_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

summaries = [read_json(path) for path in snakemake.input]
figure = architecture_figure({summary["protocol"]: summary for summary in summaries})
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)
