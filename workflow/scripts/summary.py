"""The numbers that the report's overview begins with."""

import json
from pathlib import Path

from abradem.dataset import read_table, write_json
from abradem.joblog import log_to
from abradem.summary import summarise

log_to(snakemake.log[0])

failures = snakemake.input.failures
summary = summarise(
    read_table(snakemake.input.dataset),
    read_table(failures) if failures else None,
    json.loads(Path(snakemake.input.model).read_text()),
    read_table(snakemake.input.comparison),
    snakemake.params.good_r2,
    snakemake.params.external,
)
write_json(summary, snakemake.output[0])
