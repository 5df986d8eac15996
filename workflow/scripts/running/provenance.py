"""The resolved configuration, versions, seed and code hashes of the run."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.running.provenance import write_provenance

write_provenance(
    snakemake.params.config,
    snakemake.params.recorded,
    snakemake.output.config,
    snakemake.output.versions,
)
