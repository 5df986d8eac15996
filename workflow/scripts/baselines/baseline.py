"""A model of the paper, or the feature selection; its module trains it and names the outputs."""

from importlib import import_module

from abradem.learning.model_files import write_stage
from abradem.running.job_log import log_to
from abradem.store.tables import read_table

log_to(snakemake.log[0])

module = import_module(snakemake.params.module)
found = module.train(
    read_table(snakemake.input[0]), **snakemake.params.table, **snakemake.params.options
)
write_stage(snakemake.output.items(), **found)
