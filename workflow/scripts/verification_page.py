"""All checks of the verification study: one table, one page, and the count of those that hold."""

import pandas as pd

from abradem.dataset import read_table, write_json
from abradem.joblog import log_to
from abradem.provenance import write_text
from abradem.verification.page import results_page, summarise
from abradem.verification.table import write

log_to(snakemake.log[0])

checks = pd.concat(map(read_table, snakemake.input), ignore_index=True)
write({"checks": checks}, {"checks": snakemake.output.checks})
write_text(results_page(checks), snakemake.output.page)
write_json(summarise(checks), snakemake.output.summary)
