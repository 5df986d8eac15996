"""How deep a tree may grow, and the pruned one."""

import json
from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.trees import tree_curve_figure, tree_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

summary = json.loads(Path(snakemake.input.summary).read_text(encoding="utf-8"))
curve, importance, nodes = (
    read_table(snakemake.input[name]) for name in ("curve", "importance", "nodes")
)
for name, figure in (
    ("curve", tree_curve_figure(curve, importance, summary)),
    ("tree", tree_figure(nodes, summary)),
):
    stem = Path(snakemake.output[name][0]).with_suffix("")
    style.save(figure, stem, snakemake.params.formats)
