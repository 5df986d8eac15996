"""The trials of a rung: all, or the best of the rung before."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.calibration.halving import survivors
from abradem.store.files import read_json, write_json
from abradem.store.tables import read_table

if snakemake.input.get("scores"):
    scores = read_table(snakemake.input.scores)
    chosen = survivors(scores, snakemake.params.by, snakemake.params.trials)
    # A trial without a score has no place in the next rung.
    chosen += [None] * (snakemake.params.trials - len(chosen))
else:
    chosen = list(range(len(read_json(snakemake.input.setups)["setups"])))
write_json(chosen, snakemake.output[0])
