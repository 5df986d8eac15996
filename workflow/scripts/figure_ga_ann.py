"""The genetic search, both protocols."""

import json
from pathlib import Path

import pandas as pd

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.networks import search_figure
from abradem.joblog import log_to

log_to(snakemake.log[0])

history, scores = (
    pd.concat([read_table(path) for path in snakemake.input[name]], ignore_index=True)
    for name in ("history", "scores")
)
found = [json.loads(Path(path).read_text(encoding="utf-8")) for path in snakemake.input.summaries]
figure = search_figure(history, scores, {summary["protocol"]: summary for summary in found})
stem = Path(snakemake.output[0]).with_suffix("")
style.save(figure, stem, snakemake.params.formats)
