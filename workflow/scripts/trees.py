"""Decision tree and random forest."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.modelfile import write_stage
from abradem.learning.table import FEWEST_ROWS, learning_table
from abradem.learning.trees import fit_trees

log_to(snakemake.log[0])

table = learning_table(read_table(snakemake.input[0]), **snakemake.params.table, fewest=FEWEST_ROWS)
found = fit_trees(table, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    curve=found.curve,
    nodes=found.nodes,
    importance=found.importance,
    scores=found.results.scores,
    predictions=found.results.predictions,
    summary=found.summary,
    **found.models,
)
