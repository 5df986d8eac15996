"""A table from elsewhere as the data set."""

from abradem.dataset import write_table
from abradem.external import read_external
from abradem.joblog import log_to

log_to(snakemake.log[0])

params = snakemake.params
found = read_external(snakemake.input[0], params.columns, params.damping_coefficient)
write_table(found, snakemake.output[0])
