"""The resolved configuration, and what else identifies the run."""

from abradem.joblog import log_to
from abradem.provenance import write_provenance

log_to(snakemake.log[0])

write_provenance(
    snakemake.params.config,
    snakemake.params.recorded,
    snakemake.output.config,
    snakemake.output.versions,
)
