"""A model of the paper, or the feature selection; its module trains it and names the outputs."""

from abradem.running.job_log import start_job

start_job(snakemake)

from importlib import import_module

from abradem.learning.model_files import write_stage
from abradem.store.tables import read_table

module = import_module(snakemake.params.module)
found = module.train(
    read_table(snakemake.input[0]), **snakemake.params.table, **snakemake.params.options
)
write_stage(snakemake.output.items(), **found)
