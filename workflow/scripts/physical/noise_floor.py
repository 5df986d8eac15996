"""The largest R2 that any model could reach."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.noise_floor import noise_floor
from abradem.store.tables import concatenate, read_table

per_case, summary = noise_floor(
    concatenate(map(read_table, snakemake.input.replicates)),
    read_table(snakemake.input.dataset),
    snakemake.params.target,
    snakemake.params.confidence,
)
write_stage(snakemake.output.items(), per_case=per_case, summary=summary)
