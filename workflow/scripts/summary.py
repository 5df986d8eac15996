"""The numbers that the report's overview begins with."""

import json
from pathlib import Path

from abradem.dataset import read_table, write_json
from abradem.joblog import log_to
from abradem.summary import summarise

log_to(snakemake.log[0])

summary = summarise(
    read_table(snakemake.input.dataset),
    read_table(snakemake.input.failures),
    json.loads(Path(snakemake.input.model).read_text()),
    snakemake.params.good_r2,
)
write_json(summary, snakemake.output[0])
