"""One part of the verification study, computed by the module of the part."""

from abradem.running.job_log import start_job

start_job(snakemake)

from importlib import import_module

from abradem.store.tables import read_results
from abradem.verification.checks import write

tables = import_module(snakemake.params.module).study(**read_results(snakemake.input.items()))
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})
