"""The published folder with data, data card, descriptors, figures and models."""

from pathlib import Path

from abradem.running.job_log import start_job

folder = Path(snakemake.output[0]).parent
start_job(snakemake, folder)

from abradem.publish.folder import Study, publish

publish(folder, folder.parent, snakemake.input, Study(**snakemake.params.study))
