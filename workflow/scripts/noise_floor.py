"""The best R2 that any model could reach."""

from abradem.dataset import concatenate, read_table
from abradem.joblog import log_to
from abradem.learning.modelfile import write_stage
from abradem.learning.noise_floor import noise_floor

log_to(snakemake.log[0])

per_case, summary = noise_floor(
    concatenate(map(read_table, snakemake.input.replicates)),
    read_table(snakemake.input.dataset),
    snakemake.params.confidence,
)
write_stage(snakemake.output.items(), per_case=per_case, summary=summary)
