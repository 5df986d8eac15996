"""The set-ups of all trials, and the rows of the table in the order of the search."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.calibration.rows import arranged_rows
from abradem.dataset.external import read_external
from abradem.store.columns import CALIBRATION
from abradem.store.files import write_json
from abradem.store.tables import write_table

params = snakemake.params
table = read_external(params.table, params.columns)
write_table(arranged_rows(table, **params.rows), snakemake.output.rows, CALIBRATION)
write_json({"trials": params.trials, "setups": params.setups}, snakemake.output.setups)
