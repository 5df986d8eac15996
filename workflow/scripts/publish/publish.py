"""The published folder with data, data card, descriptors, figures and models."""

from pathlib import Path

from abradem.publish.folder import Study, publish
from abradem.running.job_log import log_to

log_to(snakemake.log[0])

folder = Path(snakemake.output[0]).parent
publish(folder, folder.parent, snakemake.input, Study(**snakemake.params.study))
