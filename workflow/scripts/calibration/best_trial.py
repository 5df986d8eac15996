"""The best set-up, what the search cannot tell apart, and an override file."""

from abradem.running.job_log import start_job

start_job(snakemake)

import pandas as pd

from abradem.calibration.outcome import outcome, profiles, trial_table
from abradem.calibration.space import unknowns
from abradem.store.columns import CALIBRATION
from abradem.store.files import read_json, write_json
from abradem.store.tables import read_table, write_table

files, params, made = snakemake.input, snakemake.params, snakemake.output
drawn = read_json(files.setups)
space = unknowns(params.search)
scores = [read_table(path) for path in files.scores]
runs = pd.concat([read_table(path) for path in files.runs], ignore_index=True)
summary, predicted, slopes = outcome(
    read_table(files.rows), runs, drawn["trials"], drawn["setups"], space, params.by
)
write_json(summary, made.summary)
write_table(predicted, made.predicted, CALIBRATION)
write_table(slopes, made.slopes, CALIBRATION)
write_table(profiles(scores[0], drawn["trials"], space, params.by), made.profiles, CALIBRATION)
write_table(trial_table(scores, drawn["trials"], params.by), made.trials, CALIBRATION)
