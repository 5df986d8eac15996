"""The resolved configuration, versions, seed and code hashes of the run."""

from abradem.running.job_log import log_to
from abradem.running.provenance import write_provenance

log_to(snakemake.log[0])

write_provenance(
    snakemake.params.config,
    snakemake.params.recorded,
    snakemake.output.config,
    snakemake.output.versions,
)
