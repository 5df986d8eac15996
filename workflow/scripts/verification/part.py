"""One part of the verification study, computed by the module of the part."""

from importlib import import_module

from abradem.running.job_log import log_to
from abradem.store.tables import read_results
from abradem.verification.checks import write

log_to(snakemake.log[0])

tables = import_module(snakemake.params.module).study(**read_results(snakemake.input.items()))
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
