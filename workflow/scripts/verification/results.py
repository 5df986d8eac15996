"""All checks of the verification study: table, results page, and number of checks that hold."""

from abradem.running.job_log import start_job

start_job(snakemake)

import pandas as pd

from abradem.store.files import write_json, write_text
from abradem.store.tables import read_table
from abradem.verification.checks import write
from abradem.verification.results_page import results_page, verdict_counts

checks = pd.concat(map(read_table, snakemake.input), ignore_index=True)
write({"checks": checks}, {"checks": snakemake.output.checks})
write_text(results_page(checks), snakemake.output.page)
write_json(verdict_counts(checks), snakemake.output.summary)
