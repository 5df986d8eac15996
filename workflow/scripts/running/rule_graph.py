"""The rules of the workflow and their dependencies."""

from pathlib import Path

from abradem.running.job_log import log_to
from abradem.running.rule_graph import rule_graph
from abradem.store.columns import RULE_GRAPH
from abradem.store.tables import write_table

log_to(snakemake.log[0])

graph = rule_graph(
    Path(snakemake.params.snakefile),
    map(Path, snakemake.params.rule_files),
    snakemake.params.options,
)
write_table(graph, snakemake.output[0], extra=RULE_GRAPH)
