"""Lasso and ridge."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.modelfile import write_stage
from abradem.learning.penalised import fit_penalised
from abradem.learning.table import FEWEST_ROWS, learning_table

log_to(snakemake.log[0])

table = learning_table(read_table(snakemake.input[0]), **snakemake.params.table, fewest=FEWEST_ROWS)
found = fit_penalised(table, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    weights=found.weights,
    paths=found.paths,
    validation=found.validation,
    scores=found.results.scores,
    predictions=found.results.predictions,
    summary=found.summary,
    **found.models,
)
