"""Rows of the table simulated under one set-up."""

from abradem.calibration.trials import run_place
from abradem.running.job_log import log_to
from abradem.store.columns import CALIBRATION
from abradem.store.files import read_json
from abradem.store.tables import read_table, write_table

log_to(snakemake.log[0])

runs = run_place(
    chosen=read_json(snakemake.input.chosen),
    setups=read_json(snakemake.input.setups)["setups"],
    rows=read_table(snakemake.input.rows),
    **snakemake.params.options,
)
write_table(runs, snakemake.output[0], CALIBRATION)
