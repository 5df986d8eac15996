"""The features that the networks get."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.modelfile import write_stage
from abradem.learning.selection import fit_selection
from abradem.learning.table import FEWEST_ROWS, learning_table

log_to(snakemake.log[0])

table = learning_table(read_table(snakemake.input[0]), **snakemake.params.table, fewest=FEWEST_ROWS)
selection, summary = fit_selection(table, **snakemake.params.options)
write_stage(snakemake.output.items(), selection=selection, summary=summary)
