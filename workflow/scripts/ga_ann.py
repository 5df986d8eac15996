"""The networks whose architecture a genetic search finds, under one protocol."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.ga_ann import fit_networks, settings
from abradem.learning.genetic import terminal_progress
from abradem.learning.modelfile import write_stage
from abradem.learning.table import FEWEST_ROWS, learning_table

log_to(snakemake.log[0])

table = learning_table(read_table(snakemake.input[0]), **snakemake.params.table, fewest=FEWEST_ROWS)
protocol = snakemake.wildcards.protocol
found = fit_networks(
    table,
    protocol,
    **settings(snakemake.params.networks),
    **snakemake.params.options,
    cores=snakemake.threads,
    folder=snakemake.params.folder,
    code=snakemake.params.code,
    progress=terminal_progress(f"genetic search, {protocol}"),
)
write_stage(
    snakemake.output.items(),
    history=found.history,
    scores=found.results.scores,
    predictions=found.results.predictions,
    summary=found.summary,
    model=found.model,
)
