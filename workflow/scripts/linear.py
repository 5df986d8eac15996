"""The linear regression of the data set."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.linear import fit_linear, write_linear

log_to(snakemake.log[0])

result = fit_linear(read_table(snakemake.input[0]), **snakemake.params.options)
write_linear(result, dict(snakemake.output.items()))
