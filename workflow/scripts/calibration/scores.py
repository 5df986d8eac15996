"""Scores of the trials of a rung."""

from abradem.running.job_log import start_job

start_job(snakemake)

import pandas as pd

from abradem.calibration.agreement import scored
from abradem.store.columns import CALIBRATION
from abradem.store.tables import read_table, write_table

rows = read_table(snakemake.input.rows).set_index("case_id")
runs = pd.concat([read_table(path) for path in snakemake.input.runs], ignore_index=True)
used = runs[runs["case_id"].map(rows["part"]) == "used"]
write_table(scored(used, rows["given"]), snakemake.output[0], CALIBRATION)
