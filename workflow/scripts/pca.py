"""Principal components and the regression on them."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.modelfile import write_stage
from abradem.learning.principal import fit_principal
from abradem.learning.table import FEWEST_ROWS, learning_table

log_to(snakemake.log[0])

table = learning_table(read_table(snakemake.input[0]), **snakemake.params.table, fewest=FEWEST_ROWS)
found = fit_principal(table, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    loadings=found.loadings,
    scree=found.scree,
    correlations=found.correlations,
    curve=found.curve,
    scores=found.results.scores,
    predictions=found.results.predictions,
    summary=found.summary,
    model=found.model,
)
