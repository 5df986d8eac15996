"""Intervals of the Gaussian process, calibrated and tested on rows held out."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.groups import jet_of
from abradem.learning.intervals import calibrate
from abradem.learning.modelfile import write_stage
from abradem.learning.physical import problem

log_to(snakemake.log[0])

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input[0]), jet, **snakemake.params.table)
calibration, summary = calibrate(given, **snakemake.params.options)
write_stage(snakemake.output.items(), calibration=calibration, summary=summary)
