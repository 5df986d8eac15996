"""The rules of the workflow and their dependencies."""

from abradem.running.job_log import start_job

start_job(snakemake)

from pathlib import Path

from abradem.running.rule_graph import rule_graph
from abradem.store.columns import RULE_GRAPH
from abradem.store.tables import write_table

graph = rule_graph(
    Path(snakemake.params.snakefile),
    map(Path, snakemake.params.rule_files),
    snakemake.params.options,
)
write_table(graph, snakemake.output[0], extra=RULE_GRAPH)
