"""Rows of the table simulated under one set-up."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.calibration.trials import run_place
from abradem.store.columns import CALIBRATION
from abradem.store.files import read_json
from abradem.store.tables import read_table, write_table

runs = run_place(
    chosen=read_json(snakemake.input.chosen),
    setups=read_json(snakemake.input.setups)["setups"],
    rows=read_table(snakemake.input.rows),
    **snakemake.params.options,
)
write_table(runs, snakemake.output[0], CALIBRATION)
