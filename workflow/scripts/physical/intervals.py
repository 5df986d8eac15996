"""Prediction intervals of the Gaussian process, calibrated and tested on held-out rows."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.intervals import calibrate
from abradem.learning.physical.problem import problem
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input[0]), jet, **snakemake.params.table)
found = calibrate(given, **snakemake.params.options)
write_stage(snakemake.output.items(), **found._asdict())
