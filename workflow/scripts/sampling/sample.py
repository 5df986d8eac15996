"""One block of cases."""

from abradem.dem.model import Setup
from abradem.running.job_log import log_to
from abradem.sampling.draw import block_cases
from abradem.store.tables import write_table

log_to(snakemake.log[0])

cases = block_cases(
    block=int(snakemake.wildcards.block),
    setup=Setup.from_dict(snakemake.params.setup),
    **snakemake.params.options,
)
write_table(cases, snakemake.output[0])
