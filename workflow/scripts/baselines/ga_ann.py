"""Genetic search for the architecture of a network, under one protocol."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.baselines.ga_ann import fit_networks, settings
from abradem.learning.baselines.genetic import terminal_progress
from abradem.learning.model_files import write_stage
from abradem.learning.rows import FEWEST_ROWS, learning_table
from abradem.store.tables import read_table

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
