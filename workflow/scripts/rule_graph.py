"""The rules of the workflow and what each takes from which."""

from pathlib import Path

from abradem.dataset import write_table
from abradem.joblog import log_to
from abradem.rulegraph import COLUMNS, rule_graph

log_to(snakemake.log[0])

graph = rule_graph(
    Path(snakemake.params.snakefile),
    map(Path, snakemake.params.rule_files),
    snakemake.params.options,
)
write_table(graph, snakemake.output[0], extra=COLUMNS)
